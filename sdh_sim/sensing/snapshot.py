"""What a snapshot of the hand holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TactileSnapshot:
    """What the hand knows after acquisition; predictions see this and nothing else of a trial.

    Attributes:
        proximal: readings (3, 14, 6) [kPa], fingers as in ``sdh2_constants.FINGERS``.
        distal: readings (3, 13, 6) [kPa].
        joint_angles: motor angles (7,) [rad].
        motor_torques: motor torques (7,) [N m].
        object_pose_hand: pose of the object in the palm frame, x y z qw qx qy qz (7,).
        hand_pose_world: pose of the palm in the world (7,).
        gravity: directions of the weight in the object's frame, as the setting ``gravity`` says;
            empty: downward in the world.
    """

    proximal: np.ndarray
    distal: np.ndarray
    joint_angles: np.ndarray
    motor_torques: np.ndarray
    object_pose_hand: np.ndarray
    hand_pose_world: np.ndarray
    gravity: str = ""
