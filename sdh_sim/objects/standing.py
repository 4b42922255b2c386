"""How a user's object stands on the table before the hand comes.

It stands as ``up`` says where it rests so. A base that is not quite level (every scan has one) lets
it tilt into the stable pose nearest to that. What would tilt further falls over, and is refused.
"""

from __future__ import annotations

from itertools import islice

import mujoco
import numpy as np

from sdh_sim.errors import ObjectError
from sdh_sim.objects.collision_shape import shapes_of
from sdh_sim.objects.facts import Facts
from sdh_sim.objects.folder_reader import Folder
from sdh_sim.objects.stable_poses import LEVEL, StablePose, margin_within, stable_poses
from sdh_sim.poses import product, rotation_of

FALLS = np.radians(15.0)  # an object that would tilt further than that falls over
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


def standing_pose(
    folder: Folder, model: mujoco.MjModel, points: np.ndarray, com: np.ndarray, facts: Facts
) -> tuple[Quat, list[str]]:
    """Orientation w x y z in which an object stands on the table, and notes for the user.

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
    if facts.pose is None:
        depth = points @ down
        if margin_within(points[depth >= depth.max() - LEVEL], com, down) > 0.0:
            return upright, []
        nearest = next(poses, None)
        if nearest is not None and nearest.tilt <= ROUND_TILT and _stands_round(
            model, points, com, down
        ):
            return upright, []
        if nearest is None or nearest.tilt > FALLS:
            raise _falls(folder, facts.up, _beside(points, com, down), nearest)
        chosen = nearest
    else:
        found = list(islice(poses, facts.pose))
        if len(found) < facts.pose:
            raise folder.error(
                f"object.toml: pose is 'stable:{facts.pose}'; it has {len(found)} stable poses"
            )
        chosen = found[-1]
    return _tilted(upright, down, chosen.down), [_told(chosen, facts)]


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


def _falls(folder: Folder, up: str, beside: float, nearest: StablePose | None) -> ObjectError:
    """The error for an object that does not rest near the pose asked for."""
    other = ""
    if nearest is not None:
        other = (
            f"; its nearest stable pose is tilted by {np.degrees(nearest.tilt):.1f}°: take that "
            'with pose = "stable:1"'
        )
    return folder.error(
        f"it falls over: standing on {up} up, its centre of mass is {1e3 * max(beside, 0.0):.1f} mm "
        f"beside the area that it stands on{other}, set up in object.toml, turn the shape, or "
        "correct com"
    )


def _told(pose: StablePose, facts: Facts) -> str:
    number = 1 if facts.pose is None else facts.pose
    return f"stable pose {number}, tilted by {np.degrees(pose.tilt):.2g}° from {facts.up} up"


def _stands_round(
    model: mujoco.MjModel, points: np.ndarray, com: np.ndarray, down: np.ndarray
) -> bool:
    """Whether a round shape bears the object; arguments as ``standing_pose``.

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
