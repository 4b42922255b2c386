"""Lift and hold, watching how far the object moves in the hand."""

from __future__ import annotations

import numpy as np

from sdh_sim.cell.simulation import Cell
from sdh_sim.grasping.motion_plan import Course
from sdh_sim.objects.catalogue import ObjectInfo
from sdh_sim.robot.arm import along, arm_kinematics
from sdh_sim.trial import outcome

LIFT_TIME, HOLD_TIME = 1.5, 2.0  # [s]


def lift(
    cell: Cell, thing: ObjectInfo, course: Course, before: np.ndarray
) -> tuple[float, float, bool]:
    """Lift and hold.

    Args:
        cell: at the snapshot.
        thing: the object.
        course: with the arm's path.
        before: pose of the object in the hand at the snapshot (7,).

    Returns:
        greatest displacement [mm] and rotation [deg] of the object in the hand, whether it fell.

    Raises:
        Diverged: the simulation did.
    """
    duration = arm_kinematics().duration(course.lift, LIFT_TIME)
    moved = turned = 0.0
    for k in range(1, round((duration + HOLD_TIME) / cell.tick_time) + 1):
        share = k * cell.tick_time / duration
        cell.phase = "lift" if share <= 1.0 else "hold"
        cell.tick(along(course.lift, share))
        step = outcome.motion(before, cell.object_in_hand(), thing.com_m)
        moved, turned = max(moved, step[0]), max(turned, step[1])
        if moved > outcome.GONE_MM:
            return moved, turned, True
    return moved, turned, cell.on_table()
