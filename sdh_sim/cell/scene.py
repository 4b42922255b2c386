"""The workcell as a compiled MuJoCo model, and where its parts are in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from sdh_sim.cell.drives import Drives
from sdh_sim.objects import ObjectInfo
from sdh_sim.settings import TrialSettings

if TYPE_CHECKING:
    from sdh_sim.robot import Hand, PalmMotion

OTHER, OBJECT_GEOM, TABLE_GEOM, HAND_GEOM, ARM_GEOM = range(5)
"""Groups of geoms, as in ``Scene.geom_group``."""
GROUP_NAMES = ("the cell", "the object", "the table", "the hand itself", "the arm")
"""Of those groups, for messages about the hand."""


@dataclass(frozen=True)
class Scene:
    """A compiled workcell and where its parts are.

    Attributes:
        model: the compiled model.
        settings: what it was built for.
        obj: the object in it.
        hand: the hand in it.
        palm_motion: motion of what carries the hand.
        motors: actuator ids of the hand's motors (n,).
        motor_qpos, motor_dof: addresses of the motor joints (n,); -1 where a motor drives a tendon,
            or a joint through a gear.
        hand_qpos: addresses of all joints of the hand, in the order of its own model.
        joint_positions: gives their positions from the motors' (n,).
        arm_motors: actuator ids (6,).
        arm_qpos, arm_dof: addresses of the arm's joints (6,).
        arm_speed_limit: [rad/s] (6,).
        palm: body id of the palm, whose frame is the hand frame.
        object_body: body id of the object.
        object_qpos, object_dof: first addresses of its free joint.
        table: geom id of the table top.
        fixture: equality that holds the object where there is no table, else -1.
        taxel: per geom, index into the flat tactile vector, -1 where it is no taxel (ngeom,).
        geom_group: per geom 0 other, 1 object, 2 table, 3 hand (with taxels), 4 arm (ngeom,).
        geom_finger: per geom, index of the finger it is part of, -1 where of none (ngeom,).
        drives: of the hand's motors.
    """

    model: mujoco.MjModel
    settings: TrialSettings
    obj: ObjectInfo
    hand: Hand
    palm_motion: PalmMotion
    motors: np.ndarray
    motor_qpos: np.ndarray
    motor_dof: np.ndarray
    hand_qpos: np.ndarray
    joint_positions: Callable[[np.ndarray], np.ndarray]
    arm_motors: np.ndarray
    arm_qpos: np.ndarray
    arm_dof: np.ndarray
    arm_speed_limit: np.ndarray
    palm: int
    object_body: int
    object_qpos: int
    object_dof: int
    table: int
    fixture: int
    taxel: np.ndarray
    geom_group: np.ndarray
    geom_finger: np.ndarray
    drives: Drives = field(default_factory=Drives)

    @property
    def torque_limit(self) -> tuple[float, ...]:
        """Limits of the groups of motors [N m or N]: the settings', or the rated ones."""
        return self.settings.torque_limit or self.hand.rated_limits

    def motor_positions(self, data: mujoco.MjData) -> np.ndarray:
        """Positions of the hand's motors (n,) [rad or m]."""
        if (self.motor_qpos < 0).any():
            return data.actuator_length[self.motors].copy()
        return data.qpos[self.motor_qpos].copy()

    def motor_damping(self) -> np.ndarray:
        """Damping of the motors' joints (n,) [N m s/rad or N s/m], 0 behind tendon or gear."""
        return np.where(self.motor_dof < 0, 0.0, self.model.dof_damping[self.motor_dof])

    def pose_hand(self, data: mujoco.MjData, angles: np.ndarray) -> None:
        """Put the joints of the hand where its motors at positions (n,) [rad or m] have them."""
        data.qpos[self.hand_qpos] = self.joint_positions(angles)
