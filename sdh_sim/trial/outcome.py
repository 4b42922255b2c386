"""Whether a grasp held: from the object's motion in the hand frame since the snapshot."""

from __future__ import annotations

import math

import mujoco
import numpy as np

MAX_DISPLACEMENT_MM = 10.0
MAX_ROTATION_DEG = 10.0
GONE_MM = 80.0  # an object this far from its place in the hand has left it; no need to go on


def motion(before: np.ndarray, now: np.ndarray, com: np.ndarray) -> tuple[float, float]:
    """How far an object moved between two poses in the same frame.

    Args:
        before, now: poses x y z qw qx qy qz (7,) [m].
        com: point of the object whose displacement counts (3,) [m].

    Returns:
        displacement [mm] and rotation [deg].
    """
    shift = _apply(now, com) - _apply(before, com)
    cosine = min(1.0, abs(float(before[3:].dot(now[3:]))))
    return 1e3 * math.hypot(*shift), math.degrees(2.0 * math.acos(cosine))


def gave_way(
    before: np.ndarray, now: np.ndarray, com: np.ndarray, limit_mm: float, limit_deg: float
) -> bool:
    """Whether the motion between two poses, as in ``motion``, exceeds either limit."""
    moved, turned = motion(before, now, com)
    return moved > limit_mm or turned > limit_deg


def classify(touched: bool, on_table: bool, displacement_mm: float, rotation_deg: float) -> str:
    """The failure mode, ``none`` for a grasp that held.

    Args:
        touched: any part of the hand bore on the object at the snapshot.
        on_table: the object touches the table at the end, or has left the hand.
        displacement_mm, rotation_deg: greatest motion since the snapshot.
    """
    if not touched:
        return "no_contact"
    if not (math.isfinite(displacement_mm) and math.isfinite(rotation_deg)):
        return "unstable_simulation"
    if on_table:
        return "dropped"
    if displacement_mm > MAX_DISPLACEMENT_MM:
        return "slipped"
    if rotation_deg > MAX_ROTATION_DEG:
        return "rotated"
    return "none"


def _apply(pose: np.ndarray, point: np.ndarray) -> np.ndarray:
    moved = np.empty(3)
    mujoco.mju_rotVecQuat(moved, point, pose[3:])
    return pose[:3] + moved
