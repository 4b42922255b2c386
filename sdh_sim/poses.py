"""Poses: x y z and a unit quaternion w x y z, one array (7,); `pose_A_B` is the pose of B in A."""

from __future__ import annotations

import mujoco
import numpy as np


def rotation_of(quat: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) of a unit quaternion w x y z (4,)."""
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quat, dtype=float))
    return matrix.reshape(3, 3)
