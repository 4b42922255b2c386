"""A rig at rest in an engine, as the closed forms read it: in MuJoCo here, elsewhere in another.

Checks that need no more of a simulation than this are the same for every engine.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import mujoco
import numpy as np

from experiments.validation.rig_readings import (
    Imprint,
    Touch,
    advance,
    copy,
    imprint,
    pressed,
    sphere_forces,
    squeezed,
    touches,
)
from experiments.validation.rigs import set_friction
from sdh_sim import poses
from sdh_sim.cell import Scene

GROWTH, WATCHED = 0.1, 0.3  # a load grows, and what it moves is watched for so long [s]


class Shift(NamedTuple):
    """What a load does to a test body within ``WATCHED``.

    Attributes:
        moved: of the body's frame (3,) [m].
        turned: angle [rad].
        normal: sum of the normal forces on the body at the beginning [N].
    """

    moved: np.ndarray
    turned: float
    normal: float


class RigAtRest(Protocol):
    """A rig that has come to rest; frames as in ``rig_readings``."""

    @property
    def scene(self) -> Scene:
        """The rig's."""
        ...

    @property
    def angles(self) -> np.ndarray:
        """Positions of the motors (n,) [rad or m]."""
        ...

    @property
    def torques(self) -> np.ndarray:
        """Of the motors (n,) [N m or N]."""
        ...

    @property
    def pressed_in(self) -> float:
        """How far the test body of a bench has moved into the pad [m]."""
        ...

    def touches(self) -> Touch:
        """Contacts of the hand with the test body."""
        ...

    def imprint(self, pad: str) -> Imprint:
        """Tactile array of a pad."""
        ...

    def sphere_forces(self, pad: str) -> np.ndarray:
        """Normal force on each sphere of a pad's rubber, rows × columns [N]."""
        ...

    def with_friction(self, friction: float) -> RigAtRest:
        """The same state with another coefficient of friction."""
        ...

    def loaded(self, force: np.ndarray, torque: np.ndarray, wait: float = 0.0) -> Shift:
        """Put more force and torque on the test body's frame; the rig stays as it is.

        Args:
            force, torque: in the world (3,) [N], (3,) [N m].
            wait: time between the load's growth and the watch [s].
        """
        ...


class RigEngine(Protocol):
    """Brings rigs to rest."""

    def pressed(self, scene: Scene, force: float) -> RigAtRest:
        """As ``rig_readings.pressed``."""
        ...

    def squeezed(
        self, scene: Scene, angles: np.ndarray, pushing: np.ndarray, seconds: float = 1.0
    ) -> RigAtRest:
        """As ``rig_readings.squeezed``."""
        ...


class MuJoCoRig:
    """A rig at rest in MuJoCo.

    Args:
        scene: the rig.
        data: its state.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData) -> None:
        self.scene, self.data = scene, data

    @property
    def angles(self) -> np.ndarray:
        """Positions of the motors (n,) [rad or m]."""
        return self.data.qpos[self.scene.motor_qpos]

    @property
    def torques(self) -> np.ndarray:
        """Of the motors (n,) [N m or N]."""
        return self.data.actuator_force[self.scene.motors]

    @property
    def pressed_in(self) -> float:
        """How far the test body of a bench has moved into the pad [m]."""
        return -float(self.data.qpos[self.scene.object_qpos])

    def touches(self) -> Touch:
        """Contacts of the hand with the test body."""
        return touches(self.scene, self.data)

    def imprint(self, pad: str) -> Imprint:
        """Tactile array of a pad."""
        return imprint(self.scene, self.data, pad)

    def sphere_forces(self, pad: str) -> np.ndarray:
        """Normal force on each sphere of a pad's rubber, rows × columns [N]."""
        return sphere_forces(self.scene, self.data, pad)

    def with_friction(self, friction: float) -> MuJoCoRig:
        """The same state with another coefficient of friction, which the scene keeps."""
        set_friction(self.scene, friction)
        return MuJoCoRig(self.scene, copy(self.scene, self.data))

    def loaded(self, force: np.ndarray, torque: np.ndarray, wait: float = 0.0) -> Shift:
        """As ``RigAtRest.loaded``."""
        scene, data = self.scene, copy(self.scene, self.data)
        for share in np.linspace(0.1, 1.0, 10):
            data.xfrc_applied[scene.object_body] = share * np.concatenate((force, torque))
            advance(scene, data, GROWTH / 10)
        advance(scene, data, wait)
        normal = float(touches(scene, data).normal.sum())
        before = poses.body_pose(data, scene.object_body)
        advance(scene, data, WATCHED)
        after = poses.body_pose(data, scene.object_body)
        return Shift(after[:3] - before[:3], poses.turn_between(before, after), normal)


class MuJoCo:
    """Brings rigs to rest in MuJoCo."""

    def pressed(self, scene: Scene, force: float) -> MuJoCoRig:
        """As ``rig_readings.pressed``."""
        return MuJoCoRig(scene, pressed(scene, force))

    def squeezed(
        self, scene: Scene, angles: np.ndarray, pushing: np.ndarray, seconds: float = 1.0
    ) -> MuJoCoRig:
        """As ``rig_readings.squeezed``."""
        return MuJoCoRig(scene, squeezed(scene, angles, pushing, seconds))


MUJOCO: RigEngine = MuJoCo()
