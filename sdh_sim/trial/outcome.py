"""Whether a grasp held: from the object's motion in the hand frame since the snapshot."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from sdh_sim import poses
from sdh_sim.cell import Simulation

MAX_DISPLACEMENT_MM = 10.0
MAX_ROTATION_DEG = 10.0
GONE_MM = 80.0  # an object this far from its place in the hand has left it; no need to go on


class Motion(NamedTuple):
    """How far an object has moved in the hand, at most, and where it ended.

    Attributes:
        displacement_mm: of its centre of mass [mm].
        rotation_deg: [deg].
        fell: it touches the table at the end, or has left the hand.
    """

    displacement_mm: float
    rotation_deg: float
    fell: bool


def moved_between(before: np.ndarray, now: np.ndarray, com: np.ndarray) -> tuple[float, float]:
    """How far an object moved between two poses in the same frame.

    Args:
        before, now: poses x y z qw qx qy qz (7,) [m].
        com: point of the object whose displacement counts (3,) [m].

    Returns:
        displacement [mm] and rotation [deg].
    """
    shift = poses.transform(now, com) - poses.transform(before, com)
    return 1e3 * math.hypot(*shift), math.degrees(poses.turn_between(before, now))


def gave_way(
    before: np.ndarray, now: np.ndarray, com: np.ndarray, limit_mm: float, limit_deg: float
) -> bool:
    """Whether the motion between two poses, as in ``moved_between``, exceeds either limit."""
    moved, turned = moved_between(before, now, com)
    return moved > limit_mm or turned > limit_deg


def watch(
    simulation: Simulation, before: np.ndarray, references: Iterable[np.ndarray | None]
) -> Motion:
    """Follow references of the arm tick by tick, and watch the object in the hand.

    Args:
        simulation: with the object in the hand.
        before: pose of the object in the hand that motion is counted from (7,).
        references: of the arm's joints (6,) [rad], one a tick; None keeps them.

    Raises:
        Diverged: the simulation did.
    """
    com = simulation.scene.obj.com_m
    moved = turned = 0.0
    for reference in references:
        simulation.tick(reference)
        step = moved_between(before, simulation.object_in_hand(), com)
        moved, turned = max(moved, step[0]), max(turned, step[1])
        if moved > GONE_MM:
            return Motion(moved, turned, True)
    return Motion(moved, turned, simulation.on_table())


def further(first: Motion, then: Motion) -> Motion:
    """The motion in two parts of a trial, one after the other, as one."""
    moved = max(first.displacement_mm, then.displacement_mm)
    return Motion(moved, max(first.rotation_deg, then.rotation_deg), then.fell)


def classify(motion: Motion) -> str:
    """The failure mode of a grasp that had touched the object, ``none`` where it held."""
    if not (math.isfinite(motion.displacement_mm) and math.isfinite(motion.rotation_deg)):
        return "unstable_simulation"
    if motion.fell:
        return "dropped"
    if motion.displacement_mm > MAX_DISPLACEMENT_MM:
        return "slipped"
    if motion.rotation_deg > MAX_ROTATION_DEG:
        return "rotated"
    return "none"
