"""A user's object on the table: mass, inertia and pose, and whether a real body can have them."""

from __future__ import annotations

import mujoco
import numpy as np

from sdh_sim.errors import MjcfError
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.objects.facts import Facts
from sdh_sim.objects.standing import proposed_pose, settle
from sdh_sim.poses import rotation_of
from sdh_sim.user_files.folder import Folder


def set_mass_and_pose(folder: Folder, spec: mujoco.MjSpec, facts: Facts, file: str) -> list[str]:
    """Give the body ``object`` its mass, centre of mass, inertia and pose on the table.

    Args:
        folder: the object's, for messages.
        spec: the object; changed in place.
        facts: what ``object.toml`` says.
        file: with the shape, for messages.

    Returns:
        notes for the user.

    Raises:
        MjcfError: the shape has no volume.
        ObjectError: mass, centre of mass or inertia that no such body has, or it falls over.
    """
    body = spec.body("object")
    model = spec.compile()
    number = model.body("object").id
    points = collision_vertices(model)
    low, high = points.min(axis=0), points.max(axis=0)
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
    standing = proposed_pose(folder, model, points, com, facts)
    turn = rotation_of(np.array(standing.quat))
    height = -float((points @ turn.T)[:, 2].min())
    body.pos, body.quat = (0.0, 0.0, height), standing.quat
    body.explicitinertial = True
    body.mass, body.ipos = facts.mass, com
    body.iquat = (1.0, 0.0, 0.0, 0.0)
    body.fullinertia = (*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2])
    notes = settle(folder, spec, facts, standing)
    w, *axis = body.quat
    foot = rotation_of(np.array(body.quat)).T @ np.array([0.0, 0.0, -body.pos[2]])
    body.add_site(name="base", pos=foot, quat=(w, *(-a for a in axis)), size=[0.005] * 3, group=4)
    return notes


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


def _mm(values: np.ndarray) -> str:
    """Lengths (n,) [m] in millimetres, for a message."""
    return ", ".join(f"{1e3 * v:.1f}" for v in values)
