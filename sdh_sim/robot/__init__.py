"""The SDH-2 and the arm as devices: their numbers, pads and kinematics."""

from sdh_sim.robot.arm import ARM, ARM_JOINTS, ArmKinematics
from sdh_sim.robot.carrier import palm_motion_of
from sdh_sim.robot.closing import Closing, closing_between, preshape_closing
from sdh_sim.robot.hand import (
    FINGER_NAMES,
    HAND,
    MOTOR_NAMES,
    HandKinematics,
    HandPosture,
    hand_kinematics,
    joint_table,
    strip_taxels,
    torque_limits,
)
from sdh_sim.robot.pads import (
    PAD_NAMES,
    PAD_OFFSETS,
    TACTILE_SIZE,
    arrays,
    live_mask,
    pad_table,
    taxel_centres,
)
from sdh_sim.robot.palm_motion import PalmMotion, along

__all__ = [
    "ARM",
    "ARM_JOINTS",
    "FINGER_NAMES",
    "HAND",
    "MOTOR_NAMES",
    "PAD_NAMES",
    "PAD_OFFSETS",
    "TACTILE_SIZE",
    "ArmKinematics",
    "Closing",
    "HandKinematics",
    "HandPosture",
    "PalmMotion",
    "along",
    "arrays",
    "closing_between",
    "hand_kinematics",
    "joint_table",
    "live_mask",
    "pad_table",
    "palm_motion_of",
    "preshape_closing",
    "strip_taxels",
    "taxel_centres",
    "torque_limits",
]
