"""What a snapshot of the hand holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TactileSnapshot:
    """What the hand knows after acquisition; predictions see this and nothing else of a trial.

    Attributes:
        tactile: readings of each kind of array (pads, rows, columns) [kPa].
        joint_angles: motor positions (n,) [rad or m].
        motor_torques: motor torques (n,) [N m or N].
        object_pose_hand: pose of the object in the palm frame, x y z qw qx qy qz (7,).
        hand_pose_world: pose of the palm in the world (7,).
        gravity: directions of the weight in the object's frame, as the setting ``gravity`` says;
            empty: downward in the world.
        joints: positions of all joints of a hand with passive ones [rad or m]; None: they follow
            from the motors'.
    """

    tactile: Mapping[str, np.ndarray]
    joint_angles: np.ndarray
    motor_torques: np.ndarray
    object_pose_hand: np.ndarray
    hand_pose_world: np.ndarray
    gravity: str = ""
    joints: np.ndarray | None = None

    @property
    def proximal(self) -> np.ndarray:
        """Readings of the proximal arrays of the SDH-2 (3, 14, 6) [kPa]."""
        return self.tactile["proximal"]

    @property
    def distal(self) -> np.ndarray:
        """Readings of the distal arrays of the SDH-2 (3, 13, 6) [kPa]."""
        return self.tactile["distal"]
