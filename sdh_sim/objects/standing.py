"""How a user's object stands on the table before the hand comes.

It stands as ``up`` says where it rests so. A base that is not quite level (every scan has one) lets
it tilt into the stable pose nearest to that. What would tilt further falls over, and is refused.
Statics propose the pose, the simulation has it come to rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from sdh_sim.errors import SettingsError
from sdh_sim.objects.collision_shape import shapes_of
from sdh_sim.objects.facts import Facts
from sdh_sim.objects.settling import come_to_rest
from sdh_sim.objects.stable_poses import LEVEL, StablePose, margin_within, stable_poses
from sdh_sim.poses import product, rotation_of

if TYPE_CHECKING:
    from sdh_sim.user_files.folder import Folder

FALLS = np.radians(15.0)  # an object that would tilt further than that falls over
SHIFTS = np.radians(0.5)  # one that tilts less when the table yields is left as it is
STILL = (1e-4, np.radians(0.1))  # speeds at rest [m/s], [rad/s]
ROLLS = 0.02  # a ball of triangles rolls slowly; faster, an object is not at rest [m/s]
ROUND_BASE = 0.001  # of a round shape, what is so near the lowest point bears the object [m]
ROUND_TILT = np.radians(3.0)  # angle between the points that stand for a round shape
HALF = np.sqrt(0.5)
# The quaternion w x y z that turns the object's `up` axis to the world's z.
STANDING = {"x": (HALF, 0.0, -HALF, 0.0), "y": (HALF, HALF, 0.0, 0.0), "z": (1.0, 0.0, 0.0, 0.0)}
_ROUND = (
    mujoco.mjtGeom.mjGEOM_SPHERE,
    mujoco.mjtGeom.mjGEOM_CAPSULE,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    mujoco.mjtGeom.mjGEOM_CYLINDER,
)

Quat = tuple[float, float, float, float]


@dataclass(frozen=True)
class Standing:
    """How an object stands.

    Attributes:
        quat: orientation, w x y z.
        number: of the stable pose; 0: as ``up`` says.
    """

    quat: Quat
    number: int


def proposed_pose(
    folder: Folder, model: mujoco.MjModel, points: np.ndarray, com: np.ndarray, facts: Facts
) -> Standing:
    """How an object stands on a rigid plane.

    Args:
        folder: the object's, for messages.
        model: of the object alone.
        points: that span what collides (n, 3) [m].
        com: centre of mass (3,) [m].
        facts: what ``object.toml`` says.

    Raises:
        ObjectError: it falls over, or has no such pose.
    """
    upright: Quat = STANDING[facts.up]
    down = -rotation_of(np.array(upright))[2]
    poses = stable_poses(points, com, down)
    if facts.pose is not None:
        found = list(islice(poses, facts.pose))
        if len(found) < facts.pose:
            raise folder.error(
                f"object.toml: pose is 'stable:{facts.pose}'; it has {len(found)} stable poses"
            )
        return Standing(_tilted(upright, down, found[-1].down), facts.pose)
    depth = points @ down
    if margin_within(points[depth >= depth.max() - LEVEL], com, down) > 0.0:
        return Standing(upright, 0)
    nearest = next(poses, None)
    near = nearest is not None and nearest.tilt <= ROUND_TILT
    if near and _stands_round(model, points, com, down):
        return Standing(upright, 0)
    if nearest is None or nearest.tilt > FALLS:
        raise _falls(folder, facts.up, _beside(points, com, down), nearest)
    return Standing(_tilted(upright, down, nearest.down), 1)


def settle(folder: Folder, spec: mujoco.MjSpec, facts: Facts, proposed: Standing) -> list[str]:
    """Let an object come to rest on the table, which yields; notes for the user.

    An object that stands as ``up`` says and hardly moves is left as it is, as built-in ones are.

    Args:
        folder: the object's, for messages.
        spec: the object in the pose proposed; its pose is changed in place.
        facts: what ``object.toml`` says.
        proposed: how it stands on a rigid plane.

    Raises:
        ObjectError: it falls over, or does not come to rest.
    """
    rest = come_to_rest(spec, facts.friction)
    up = -rotation_of(np.array(STANDING[facts.up]))[2]
    tilt = float(np.arccos(np.clip(-rotation_of(rest.quat)[2] @ up, -1.0, 1.0)))
    if facts.pose is None and tilt > FALLS:
        raise folder.error(
            f"it falls over: put on the table with {facts.up} up, it tips by "
            f"{np.degrees(tilt):.0f}°, since its base is narrow and the table yields; set up or "
            'pose = "stable:1" in object.toml, or correct com'
        )
    if facts.pose is not None and rest.turned > FALLS:
        raise folder.error(
            f"object.toml: pose is 'stable:{facts.pose}', in which it falls over by "
            f"{np.degrees(rest.turned):.0f}°, since its base is narrow and the table yields; give "
            "another"
        )
    if rest.speed > ROLLS:
        raise folder.error(
            f"it does not come to rest on the table: it moves by {1e3 * rest.speed:.0f} mm/s; set "
            "up or pose in object.toml"
        )
    notes = []
    if proposed.number or rest.turned > SHIFTS:
        body = spec.body("object")
        body.quat, body.pos = rest.quat, (0.0, 0.0, rest.height)
        number = f"stable pose {proposed.number}, " if proposed.number else "at rest "
        notes.append(f"{number}tilted by {round(np.degrees(tilt), 2):g}° from {facts.up} up")
    if rest.speed > STILL[0] or rest.turn_rate > STILL[1]:
        notes.append(
            f"still moves on the table, by {1e3 * rest.speed:.2g} mm and "
            f"{np.degrees(rest.turn_rate):.2g}° in a second"
        )
    return notes


def _beside(points: np.ndarray, com: np.ndarray, down: np.ndarray) -> float:
    """How far a centre of mass lies beside the lowest points, seen from above [m]."""
    turn = rotation_of(_shortest(down, np.array([0.0, 0.0, -1.0])))
    depth = points @ down
    foot = points[depth >= depth.max() - LEVEL] @ turn.T
    # The distance from a convex area is the largest, over directions, of how far the centre of
    # mass lies beyond the area's extreme point in that direction.
    angles = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    directions = np.stack((np.cos(angles), np.sin(angles)))
    return float(((turn @ com)[:2] @ directions - (foot[:, :2] @ directions).max(axis=0)).max())


def _falls(folder: Folder, up: str, beside: float, nearest: StablePose | None) -> SettingsError:
    """The error for an object that does not rest near the pose asked for."""
    other = ""
    if nearest is not None:
        other = (
            f"; its nearest stable pose is tilted by {np.degrees(nearest.tilt):.1f}°: take that "
            'with pose = "stable:1"'
        )
    return folder.error(
        f"it falls over: standing on {up} up, its centre of mass is {1e3 * max(beside, 0.0):.1f} "
        f"mm beside the area that it stands on{other}, set up in object.toml, turn the shape, or "
        "correct com"
    )


def _stands_round(
    model: mujoco.MjModel, points: np.ndarray, com: np.ndarray, down: np.ndarray
) -> bool:
    """Whether a round shape bears the object; arguments as ``proposed_pose``.

    Points on the surface stand for a round shape, so that the hull has facets where the shape has
    none. Such an object rests as it is.
    """
    depth = points @ down
    reach = [(shape @ down).max() for geom, shape in shapes_of(model) if _is_round(model, geom)]
    if max(reach, default=-np.inf) < depth.max() - LEVEL:
        return False
    return margin_within(points[depth >= depth.max() - ROUND_BASE], com, down) > 0.0


def _is_round(model: mujoco.MjModel, geom: int) -> bool:
    return mujoco.mjtGeom(int(model.geom_type[geom])) in _ROUND


def _tilted(upright: Quat, down: np.ndarray, facet: np.ndarray) -> Quat:
    """The upright orientation turned the shortest way until a facet's normal points down.

    Args:
        upright: w x y z (4,).
        down: unit vector that points down when upright, in the object's frame (3,).
        facet: outward normal of the facet, in the object's frame (3,).
    """
    turn = rotation_of(np.array(upright))
    w, x, y, z = product(_shortest(turn @ facet, turn @ down), np.array(upright))
    return float(w), float(x), float(y), float(z)


def _shortest(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Quaternion (4,) that turns one unit vector (3,) the shortest way onto another."""
    cosine = float(start @ end)
    if cosine < -1.0 + 1e-12:  # half a turn about any axis across
        across = np.cross(start, np.eye(3)[int(np.argmin(np.abs(start)))])
        return np.array([0.0, *(across / np.linalg.norm(across))])
    quat = np.array([1.0 + cosine, *np.cross(start, end)])
    return quat / np.linalg.norm(quat)
