"""The hand and what carries it as devices: their numbers, pads and kinematics."""

from sdh_sim.robot.arm import ARM, ARM_JOINTS, ArmKinematics
from sdh_sim.robot.carrier import palm_motion_of
from sdh_sim.robot.closing import Closing
from sdh_sim.robot.find_hand import find_hand, hand_in
from sdh_sim.robot.hand import (
    HAND,
    HandKinematics,
    HandPosture,
    built_in_hand,
    closing_between,
    hand_kinematics,
    hand_spec,
    joint_table,
    preshape_closing,
    strip_taxels,
    taxel_names,
)
from sdh_sim.robot.hand_description import Finger, Hand, Motor
from sdh_sim.robot.hand_folder import hand_named, hand_of, read_hand_folder
from sdh_sim.robot.mechanism import find_transmission, moment_arms
from sdh_sim.robot.pads import Pad, TaxelArray
from sdh_sim.robot.palm_motion import PalmMotion, along

__all__ = [
    "ARM",
    "ARM_JOINTS",
    "HAND",
    "ArmKinematics",
    "Closing",
    "Finger",
    "Hand",
    "HandKinematics",
    "HandPosture",
    "Motor",
    "Pad",
    "PalmMotion",
    "TaxelArray",
    "along",
    "built_in_hand",
    "closing_between",
    "find_hand",
    "find_transmission",
    "hand_in",
    "hand_kinematics",
    "hand_named",
    "hand_of",
    "hand_spec",
    "joint_table",
    "moment_arms",
    "palm_motion_of",
    "preshape_closing",
    "read_hand_folder",
    "strip_taxels",
    "taxel_names",
]
