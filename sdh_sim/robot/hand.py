"""The hand as the controller and the metrics know it: kinematics, pads, Jacobians."""

from __future__ import annotations

from functools import lru_cache

import mujoco
import numpy as np

from sdh_sim.model_files import models_dir
from sdh_sim.robot import sdh2_constants as c

HAND = "hand/"  # prefix of its names in a workcell
MOTOR_NAMES = tuple(m.name for m in c.MOTORS)
FINGER_NAMES = tuple(f.name for f in c.FINGERS)
MOTOR_FINGER = np.array([FINGER_NAMES.index(m.finger) for m in c.MOTORS])
"""Index of the finger that each motor moves (7,)."""


def torque_limits(limit: tuple[float, float]) -> np.ndarray:
    """Limits of the 7 motors (7,) [N m] from (spread and proximal, distal)."""
    return np.array([limit[1] if m.kind == "distal" else limit[0] for m in c.MOTORS])


def joint_table() -> list[tuple[str, str, float, tuple[float, float], float]]:
    """Rows (joint, motor, data-sheet torque [N m], range [rad], greatest speed [rad/s])."""
    rows = []
    for index, m in enumerate(c.MOTORS):
        reach = c.SPREAD_RANGE if m.kind == "spread" else c.PHALANX_RANGE
        torque, speed = c.DATASHEET_TORQUE[m.kind], c.MAX_SPEED[m.kind]
        rows.append((m.name, str(index), torque, reach, speed))
        if m.kind == "spread":
            rows.append((c.COUPLED_JOINT, f"{index} (coupled)", torque, reach, speed))
    return rows


class HandKinematics:
    """Forward kinematics and Jacobians of the hand alone, by MuJoCo on the hand's own MJCF.

    Attributes:
        model: the hand without taxel geoms; its world frame is the mounting face.
    """

    def __init__(self) -> None:
        spec = mujoco.MjSpec.from_file(str(models_dir() / "schunk_sdh2" / "sdh2.xml"))
        strip_taxels(spec)
        self.model = spec.compile()
        joints = [self.model.joint(name).qposadr[0] for name in MOTOR_NAMES]
        coupled = self.model.joint(c.COUPLED_JOINT).qposadr[0]
        # qpos = selection @ motor angles; the same matrix takes joint to motor Jacobians.
        self.selection = np.zeros((self.model.nq, len(MOTOR_NAMES)))
        self.selection[joints, np.arange(len(joints))] = 1.0
        self.selection[coupled, MOTOR_NAMES.index("spread")] = 1.0
        self.selection.setflags(write=False)

    def at(self, angles: np.ndarray) -> HandPosture:
        """The hand at motor angles (7,) [rad]."""
        return HandPosture(self, angles)

    def joint_positions(self, angles: np.ndarray) -> np.ndarray:
        """Positions of all joints, the coupled one too, in the MJCF's order (8,) [rad]."""
        return self.selection @ angles


@lru_cache(maxsize=1)
def hand_kinematics() -> HandKinematics:
    """The hand, compiled once per process."""
    return HandKinematics()


class HandPosture:
    """The hand at one posture: where its links are, and how they move with its motors.

    Args:
        kinematics: the hand.
        angles: of its motors (7,) [rad].
    """

    def __init__(self, kinematics: HandKinematics, angles: np.ndarray) -> None:
        self._model, self._selection = kinematics.model, kinematics.selection
        self._data = mujoco.MjData(self._model)
        self._data.qpos[:] = kinematics.joint_positions(angles)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        palm = self._model.body("palm").id
        self._origin = self._data.xpos[palm].copy()
        self._axes = self._data.xmat[palm].reshape(3, 3).copy()

    def link(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Position (3,) [m] and rotation (3, 3) of a body's frame in the palm frame."""
        index = self._model.body(body).id
        offset = self._data.xpos[index] - self._origin
        return self._axes.T @ offset, self._axes.T @ self._data.xmat[index].reshape(3, 3)

    def jacobian(self, body: str, point: np.ndarray) -> np.ndarray:
        """Velocity of a point of a body per motor velocity, in the palm frame (3, 7) [m/rad].

        Args:
            body: body that the point is fixed to.
            point: the point in the palm frame (3,) [m].
        """
        world = self._origin + self._axes @ point
        full = np.zeros((3, self._model.nv))
        mujoco.mj_jac(self._model, self._data, full, None, world, self._model.body(body).id)
        return self._axes.T @ full @ self._selection

    def spin_jacobian(self, body: str) -> np.ndarray:
        """Angular velocity of a body per motor velocity, in the palm frame (3, 7) [rad/rad]."""
        full = np.zeros((3, self._model.nv))
        mujoco.mj_jacBody(self._model, self._data, None, full, self._model.body(body).id)
        return self._axes.T @ full @ self._selection


def strip_taxels(spec: mujoco.MjSpec) -> None:
    """Remove the taxel geoms from a spec: kinematics and drawings do without them."""
    for geom in list(spec.geoms):
        if geom.classname.name.endswith("sdh2_taxel"):
            spec.delete(geom)
