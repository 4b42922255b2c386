"""A hand without an arm: six stiff joints carry it anywhere, three along and three about axes.

The joints slide along the world's x, y, z and turn about z, y and z again (Euler's zyz), the last
about the palm's own z as an arm's wrist does. Where the first and the third axis fall together, the
hand cannot be turned about the direction across both, and is held in it all the more.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from sdh_sim.poses import rotation_of
from sdh_sim.robot.arm import ARM, ARM_JOINTS
from sdh_sim.robot.hand import hand_kinematics
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.palm_motion import PalmMotion

# What a joint weighs beside the hand, and the angular frequency of its critically damped servo:
# 20 N move the hand by 5 µm, 2 N m turn it by 50 µrad, and a step of 5 ms resolves it.
INERTIA = (100.0, 1.0)  # along [kg], about [kg m^2]
FREQUENCY = 200.0  # [rad/s]
LIGHTEST = 1e-6  # of the base itself, as MuJoCo wants every body to have a mass [kg], [kg m^2]
SPEED_LIMIT = (1.0, math.pi)  # [m/s], [rad/s]
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 1), (0, 1, 0), (0, 0, 1))
_SLIDES = 3
POLE = 1e-9  # sine of the second angle below which the first and the third axis fall together


class FloatingBase(PalmMotion):
    """Every pose of the palm is within reach; joint positions are x, y, z [m] and angles [rad].

    Args:
        hand: on the base; None: the SDH-2.

    The hand starts at the grasp, since nothing stands in the way of a base that is not there.
    """

    standoff = 0.0

    def __init__(self, hand: Hand | None = None) -> None:
        self.speed_limit = np.repeat(SPEED_LIMIT, 3)
        position, quat = hand_kinematics(hand).palm_offset()
        self._offset, self._turn = position, rotation_of(quat)

    def palm_pose(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As ``PalmMotion`` says."""
        from scipy.spatial.transform import (
            Rotation,  # a fifth of a second, which most processes do not need
        )

        q = np.asarray(q, dtype=float)
        rotation = Rotation.from_euler("ZYZ", q[_SLIDES:]).as_matrix()
        return q[:_SLIDES] + rotation @ self._offset, rotation @ self._turn

    def solve(
        self, position: np.ndarray, rotation: np.ndarray, start: np.ndarray, steps: int = 60
    ) -> np.ndarray:
        """As ``PalmMotion`` says, in closed form; of all angles those nearest to the start's."""
        start = np.asarray(start, dtype=float)
        turned_back = np.asarray(rotation) @ self._turn.T  # rotation of the mounting face
        mount = np.asarray(position) - turned_back @ self._offset
        if np.allclose(self.palm_pose(start)[1], rotation, rtol=0.0, atol=1e-12):
            return np.concatenate((mount, start[_SLIDES:]))
        first, bend, last = _zyz(turned_back)
        twice = ((first, bend, last), (first + math.pi, -bend, last - math.pi))
        turned = [np.array(angles) for angles in twice]
        near = [a + 2 * math.pi * np.round((start[_SLIDES:] - a) / (2 * math.pi)) for a in turned]
        best = min(near, key=lambda angles: float(np.abs(angles - start[_SLIDES:]).max()))
        return np.concatenate((mount, best))

    def reach(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """As ``PalmMotion`` says."""
        return self.solve(position, rotation, np.zeros(6))


def _zyz(rotation: np.ndarray) -> tuple[float, float, float]:
    """Angles about z, y, z [rad] of a rotation (3, 3); the first is 0 where it is free."""
    sine = math.hypot(rotation[0, 2], rotation[1, 2])
    bend = math.atan2(sine, rotation[2, 2])
    if sine < POLE:
        return 0.0, bend, math.atan2(rotation[1, 0], rotation[1, 1])
    first = math.atan2(rotation[1, 2], rotation[0, 2])
    return first, bend, math.atan2(rotation[2, 1], -rotation[2, 0])


def add_floating_base(spec: mujoco.MjSpec) -> None:
    """Add the base to a cell, under the names of the arm: its joints, motors and flange."""
    body = spec.worldbody.add_body(name=f"{ARM}base")
    kinds = mujoco.mjtJoint
    for number, (name, axis) in enumerate(zip(ARM_JOINTS, AXES, strict=True)):
        inertia = INERTIA[number >= _SLIDES]
        stiffness = inertia * FREQUENCY**2
        damping = 2.0 * inertia * FREQUENCY
        kind = kinds.mjJNT_SLIDE if number < _SLIDES else kinds.mjJNT_HINGE
        body.add_joint(name=ARM + name, type=kind, axis=axis, armature=inertia)
        motor = spec.add_actuator(name=ARM + name, target=ARM + name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.set_to_position(kp=stiffness, kv=damping)
    body.mass, body.inertia, body.explicitinertial = LIGHTEST, np.full(3, LIGHTEST), True
    body.add_site(name=f"{ARM}flange")
