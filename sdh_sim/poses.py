"""Poses and rotations: a pose is x y z and a unit quaternion w x y z, one array (7,).

``pose_A_B`` is the pose of frame B in frame A: it takes coordinates in B to coordinates in A.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np


def rotation_of(quat: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) of a unit quaternion w x y z (4,)."""
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quat, dtype=float))
    return matrix.reshape(3, 3)


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternion w x y z (4,) of a rotation (3, 3)."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(rotation, dtype=float).reshape(9))
    return quat


def about_z(angle: float) -> np.ndarray:
    """Unit quaternion w x y z (4,) of a turn about z [rad]."""
    return np.array([math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)])


def product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Quaternion (4,) that turns by ``second`` and then by ``first``."""
    quat = np.empty(4)
    mujoco.mju_mulQuat(quat, first, second)
    return quat


def rotate(quat: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """The vector (3,) turned by a quaternion (4,)."""
    turned = np.empty(3)
    mujoco.mju_rotVecQuat(turned, vector, quat)
    return turned


def transform(pose: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Coordinates in A (3,) [m] of a point given in B, by pose_A_B (7,)."""
    return pose[:3] + rotate(pose[3:], point)


def compose(pose_a_b: np.ndarray, pose_b_c: np.ndarray) -> np.ndarray:
    """Pose of C in A (7,)."""
    turn = product(pose_a_b[3:], np.ascontiguousarray(pose_b_c[3:]))
    return np.concatenate((transform(pose_a_b, np.ascontiguousarray(pose_b_c[:3])), turn))


def relative(pose_w_a: np.ndarray, pose_w_b: np.ndarray) -> np.ndarray:
    """Pose of B in A (7,), from the poses of both in W."""
    inverse = np.empty(4)
    mujoco.mju_negQuat(inverse, pose_w_a[3:])
    position = rotate(inverse, pose_w_b[:3] - pose_w_a[:3])
    return np.concatenate((position, product(inverse, pose_w_b[3:])))


def turn_between(first: np.ndarray, second: np.ndarray) -> float:
    """Angle [rad], 0 to pi, between the orientations of two poses (7,)."""
    return 2.0 * math.acos(min(1.0, abs(float(first[3:].dot(second[3:])))))


def body_pose(data: mujoco.MjData, body: int) -> np.ndarray:
    """Pose of a body's frame in the world (7,)."""
    return np.concatenate((data.xpos[body], data.xquat[body]))
