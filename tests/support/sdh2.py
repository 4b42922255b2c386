"""The SDH-2 by the names that its tests use."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sdh_sim.robot import built_in_hand
from sdh_sim.sensing import TactileSnapshot

SDH2 = built_in_hand("schunk_sdh2")
MOTOR_NAMES, FINGER_NAMES, PAD_NAMES = SDH2.motor_names, SDH2.finger_names, SDH2.pad_names
PAD_OFFSETS, TACTILE_SIZE = SDH2.pad_offsets, SDH2.tactile_size
torque_limits = SDH2.torque_limits


def live_mask(kind: str) -> np.ndarray:
    """Which taxels of an array exist (rows, 6) bool."""
    return SDH2.arrays[kind].live


def taxel_centres(kind: str) -> np.ndarray:
    """Taxel centres in the link frame (rows, 6, 3) [m]."""
    return SDH2.arrays[kind].centres


def arrays(flat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The flat tactile vector as arrays: proximal (3, 14, 6), distal (3, 13, 6)."""
    found = SDH2.by_kind(flat)
    return found["proximal"], found["distal"]


def snapshot(
    proximal: np.ndarray,
    distal: np.ndarray,
    joint_angles: np.ndarray,
    motor_torques: np.ndarray,
    object_pose_hand: np.ndarray,
    hand_pose_world: np.ndarray,
) -> TactileSnapshot:
    """A snapshot of the SDH-2 from its two kinds of arrays."""
    tactile = {"proximal": proximal, "distal": distal}
    return TactileSnapshot(
        tactile, joint_angles, motor_torques, object_pose_hand, hand_pose_world
    )  # fmt: skip


def with_arrays(seen: TactileSnapshot, **arrays: np.ndarray) -> TactileSnapshot:
    """The snapshot with other readings of some kinds of arrays."""
    return replace(seen, tactile={**seen.tactile, **arrays})
