"""What the row of a trial says of its conditions and of the grasp that was planned."""

from __future__ import annotations

import numpy as np

from sdh_sim.grasping import GraspPlan, MotionPlan
from sdh_sim.objects import ObjectInfo
from sdh_sim.records import HAND_NAME, TrialRow
from sdh_sim.settings import DEFAULT_HAND, TrialSettings


def describe_conditions(
    row: TrialRow, settings: TrialSettings, obj: ObjectInfo, limits: np.ndarray
) -> None:
    """Set the columns of the object, the hand and the torque limits of its motors (n,)."""
    row.mass_kg, row.friction = obj.mass_kg, obj.friction
    row.torque_limit_nm = limits
    if settings.hand != DEFAULT_HAND:
        row[HAND_NAME] = settings.hand
    row.gravity = settings.gravity if settings.support == "none" else None


def describe_grasp(row: TrialRow, grasp: GraspPlan, obj: ObjectInfo) -> None:
    """Set the columns of a grasp, whether there is a motion to it or not."""
    row.preshape = grasp.closing.name or None
    row.plan_palm_pose_object = grasp.palm_in_object(obj)
    row.plan_open_rad, row.plan_closed_rad = grasp.closing.open, grasp.closing.closed
    row.plan_opening = grasp.opening
    row.object_yaw_rad = None if grasp.turnable else grasp.object_yaw


def describe_motion(row: TrialRow, motion: MotionPlan) -> None:
    """Set the columns that the motion decides, and how a random grasp was drawn."""
    row.plan_opening, row.object_yaw_rad = motion.opening, motion.grasp.object_yaw
    drawn = motion.grasp.drawn
    if drawn is None:
        return
    row.approach = drawn.approach
    row.plan_azimuth_rad, row.plan_roll_rad = drawn.azimuth, drawn.roll
    row.plan_tilt_rad = drawn.tilt
    row.plan_height_m, row.plan_depth_m = drawn.height, drawn.depth
    row.plan_offset_m = drawn.offset
    row.resampled_unreachable = motion.unreachable
    row.resampled_colliding = motion.colliding
