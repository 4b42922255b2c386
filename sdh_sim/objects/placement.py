"""A user's object on the table: mass, inertia and pose, and whether a real body can have them."""

from __future__ import annotations

import mujoco
import numpy as np

from sdh_sim.errors import MeshError, MjcfError
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.objects.facts import MJCF, Facts
from sdh_sim.objects.folder_reader import Folder
from sdh_sim.poses import rotation_of

SIZE = (0.01, 0.5)  # the largest extent, at least and at most [m]
THINNEST = 0.005  # the smallest extent; thinner, the pads' contacts would reach through [m]
STANDS_WITHIN = 0.001  # what is so near its lowest point bears an object on the table [m]
TOPPLES = 0.002  # centre of mass beyond the area that the object stands on [m]
HALF = np.sqrt(0.5)
# The quaternion w x y z that turns the object's `up` axis to the world's z.
STANDING = {"x": (HALF, 0.0, -HALF, 0.0), "y": (HALF, HALF, 0.0, 0.0), "z": (1.0, 0.0, 0.0, 0.0)}


def set_mass_and_pose(folder: Folder, spec: mujoco.MjSpec, facts: Facts, file: str) -> None:
    """Give the body ``object`` its mass, centre of mass, inertia and pose on the table.

    Args:
        folder: the object's, for messages.
        spec: the object; changed in place.
        facts: what ``object.toml`` says.
        file: with the shape, for messages.

    Raises:
        MeshError: the shape is too large, too small or too thin.
        MjcfError: the shape has no volume.
        ObjectError: mass, centre of mass or inertia that no such body has, or it falls over.
    """
    body = spec.body("object")
    model = spec.compile()
    number = model.body("object").id
    points = collision_vertices(model)
    low, high = points.min(axis=0), points.max(axis=0)
    check_extents(high - low, "set the sizes in metres" if file.endswith(MJCF) else "set scale")
    volume_mass = float(model.body_mass[number])
    if not volume_mass > 0.0:
        raise MjcfError("encloses no volume")
    com = np.array(model.body_ipos[number] if facts.com is None else facts.com)
    if not ((low <= com) & (com <= high)).all():
        raise folder.error(
            f"object.toml: com is {_mm(com)} mm, outside the shape, which goes from {_mm(low)} to "
            f"{_mm(high)} mm; give x, y, z in metres in the frame of {file}"
        )
    if facts.inertia is None:
        axes = rotation_of(model.body_iquat[number])
        inertia = axes @ np.diag(model.body_inertia[number]) @ axes.T * (facts.mass / volume_mass)
    else:
        inertia = _inertia_matrix(facts.inertia)
        _check_inertia(folder, inertia, facts.mass, np.maximum(high - com, com - low))
    turn = rotation_of(np.array(STANDING[facts.up]))
    standing = points @ turn.T
    height = -float(standing[:, 2].min())
    _check_stands(folder, standing, turn @ com, facts.up)
    body.pos, body.quat = (0.0, 0.0, height), STANDING[facts.up]
    body.explicitinertial = True
    body.mass, body.ipos = facts.mass, com
    body.iquat = (1.0, 0.0, 0.0, 0.0)
    body.fullinertia = (*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2])
    w, *axis = STANDING[facts.up]
    foot = turn.T @ np.array([0.0, 0.0, -height])
    body.add_site(name="base", pos=foot, quat=(w, *(-a for a in axis)), size=[0.005] * 3, group=4)


def check_extents(extents: np.ndarray, remedy: str, scale: float = 1.0) -> None:
    """Check that an object has the size of what a hand can grasp.

    Args:
        extents: along the object's axes (3,) [m].
        remedy: what the user can do about a wrong size, for the message.
        scale: that the file's lengths were multiplied with.

    Raises:
        MeshError: it is too large, too small or too thin; the message guesses the unit.
    """
    largest = float(extents.max())
    size = " × ".join(f"{e:.4g}" for e in extents)
    if not SIZE[0] <= largest <= SIZE[1]:
        hint = f"{remedy} so that it is between {SIZE[0]:g} and {SIZE[1]:g} m"
        for unit, factor in (("millimetres", 1e-3), ("centimetres", 1e-2), ("inches", 0.0254)):
            if largest > SIZE[1] and 0.03 <= largest * factor <= SIZE[1]:
                hint = f"it looks like {unit}: {remedy} = {scale * factor:g}"
                break
        for factor in (1e3, 1e2):
            if largest < SIZE[0] and 0.03 <= largest * factor <= SIZE[1]:
                hint = f"its unit looks {factor:g} times as large: {remedy} = {scale * factor:g}"
                break
        raise MeshError(f"is {size} m large; {hint}")
    if extents.min() < THINNEST:
        raise MeshError(f"is {size} m large; no side may be thinner than {THINNEST:g} m")


def _inertia_matrix(values: tuple[float, ...]) -> np.ndarray:
    """The matrix (3, 3) of xx yy zz xy xz yz (6,)."""
    xx, yy, zz, xy, xz, yz = values
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _check_inertia(folder: Folder, matrix: np.ndarray, mass: float, reach: np.ndarray) -> None:
    """Raise ObjectError where no body of that mass and size has the inertia.

    Args:
        folder: the object's, for the message.
        matrix: about the centre of mass (3, 3) [kg m^2].
        mass: [kg].
        reach: from the centre of mass to the farther side of the shape's box, per axis (3,) [m].
    """
    moments = np.linalg.eigvalsh(matrix)
    most = mass * float(reach @ reach)
    if moments[0] <= 0.0 or moments[2] > (moments[0] + moments[1]) * (1 + 1e-9):
        problem = "no body has it: moments must be positive, the largest at most the others' sum"
    elif moments[2] > most:
        problem = f"more than the mass in the farthest corner has ({most:.3g} kg m²)"
    elif moments[2] < 1e-5 * most:
        problem = "as if all mass were in one point"
    else:
        return
    text = ", ".join(f"{m:.3g}" for m in moments)
    raise folder.error(
        f"object.toml: inertia has the principal moments {text} kg m²: {problem}; give xx, yy, "
        "zz, xy, xz, yz in kg m² about the centre of mass, or leave it out"
    )


def _check_stands(folder: Folder, points: np.ndarray, com: np.ndarray, up: str) -> None:
    """Raise ObjectError where the centre of mass is not over the area that bears the object.

    Args:
        folder: the object's, for the message.
        points: that span the shape (n, 3) [m], turned as the object stands.
        com: centre of mass (3,) [m], turned likewise.
        up: axis of the object that points up, for the message.
    """
    foot = points[points[:, 2] <= points[:, 2].min() + STANDS_WITHIN, :2]
    # The distance from a convex area is the largest, over directions, of how far the centre of
    # mass lies beyond the area's extreme point in that direction.
    angles = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    directions = np.stack((np.cos(angles), np.sin(angles)))
    beyond = float((com[:2] @ directions - (foot @ directions).max(axis=0)).max())
    if beyond > TOPPLES:
        raise folder.error(
            f"it falls over: standing on {up} up, its centre of mass is {1e3 * beyond:.1f} mm "
            "beside the area that it stands on; set up in object.toml, turn the shape, or correct "
            "com"
        )


def _mm(values: np.ndarray) -> str:
    """Lengths (n,) [m] in millimetres, for a message."""
    return ", ".join(f"{1e3 * v:.1f}" for v in values)
