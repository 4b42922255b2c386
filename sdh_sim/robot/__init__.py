"""The SDH-2 and the arm as devices: their numbers, pads and kinematics."""

from sdh_sim.robot.arm import ARM, ARM_JOINTS, ArmKinematics, along, arm_kinematics
from sdh_sim.robot.hand import (
    FINGER_NAMES,
    HAND,
    MOTOR_NAMES,
    HandKinematics,
    HandPosture,
    hand_kinematics,
    joint_table,
    preshape_angles,
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
    "HandKinematics",
    "HandPosture",
    "along",
    "arm_kinematics",
    "arrays",
    "hand_kinematics",
    "joint_table",
    "live_mask",
    "pad_table",
    "preshape_angles",
    "strip_taxels",
    "taxel_centres",
    "torque_limits",
]
