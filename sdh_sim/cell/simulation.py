"""The running cell: MuJoCo's state, stepped with the torque peaks and the divergence watched."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator

import mujoco
import numpy as np

from sdh_sim.cell.contacts import taxel_forces
from sdh_sim.cell.scene import HAND_GEOM, OBJECT_GEOM, TABLE_GEOM, Scene
from sdh_sim.errors import Diverged
from sdh_sim.robot.hand import torque_limits
from sdh_sim.sensing.tactile_sensor import FRAME_RATE, TactileSensor
from sdh_sim.trial.trial_log import LogWriter

TICK = 0.01  # control period [s]
MAX_SPEED = 1e3  # a generalised speed beyond this is a diverged simulation [m/s or rad/s]


class Cell:
    """A scene in motion.

    Attributes:
        scene: the compiled scene.
        data: MuJoCo's state.
        peak: largest motor torques so far (7,) [N m].
        limits: torque limits of the motors (7,) [N m].
        phase: name of what is going on, for the log.
        tick_time: length of a control period [s].
        sensor: the tactile arrays while they are watched, fed at their frame rate.
    """

    def __init__(self, scene: Scene, writer: LogWriter | None = None) -> None:
        self.scene, self.writer = scene, writer
        self.sensor: TactileSensor | None = None
        self._next_frame = 0.0
        self.data = mujoco.MjData(scene.model)
        self.steps = max(1, round(TICK / scene.settings.timestep))
        self.tick_time = self.steps * scene.settings.timestep
        self.peak = np.zeros(7)
        self.limits = torque_limits(scene.settings.torque_limit)
        self.phase = ""

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.data.time)

    def tick(self, arm: np.ndarray | None = None, hand: np.ndarray | None = None) -> None:
        """One control period; peaks and divergence are looked at in every step.

        References go to their new values evenly from step to step: in jumps they would shake
        the hand.

        Args:
            arm: references of the arm's joints at the end (6,) [rad]; None keeps them.
            hand: references of the hand's motors at the end (7,) [rad]; None keeps them.

        Raises:
            Diverged: a speed or acceleration is not finite, or a speed beyond any meaning.
        """
        model, data, motors, peak = self.scene.model, self.data, self.scene.motors, self.peak
        speed, acceleration, torque = data.qvel, data.qacc, data.actuator_force
        control = data.ctrl
        rise = None if arm is None and hand is None else self._rise(arm, hand)
        for _ in range(self.steps):
            if rise is not None:
                control += rise
            mujoco.mj_step(model, data)
            np.maximum(peak, np.abs(torque[motors]), out=peak)
            # The norm of a vector with NaN is NaN and fails the comparison too.
            if not (speed.dot(speed) < MAX_SPEED**2 and math.isfinite(acceleration.dot(speed))):
                raise Diverged
        if self.sensor is not None and data.time >= self._next_frame:
            self._next_frame += 1.0 / FRAME_RATE
            self.sensor.frame(taxel_forces(self.scene, data))
        if self.writer is not None:
            self.writer.sample(data, self.phase)

    def _rise(self, arm: np.ndarray | None, hand: np.ndarray | None) -> np.ndarray:
        """What every reference gains per step on the way to new ones."""
        target = self.data.ctrl.copy()
        if arm is not None:
            target[self.scene.arm_motors] = arm
        if hand is not None:
            target[self.scene.motors] = hand
        return (target - self.data.ctrl) / self.steps

    def save(self) -> np.ndarray:
        """The full state of the simulation, for ``restore``."""
        spec = mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(mujoco.mj_stateSize(self.scene.model, spec))
        mujoco.mj_getState(self.scene.model, self.data, state, spec)
        return state

    def state(self) -> dict[str, np.ndarray]:
        """The state by name, for a look at a simulation that went wrong."""
        names = ("qpos", "qvel", "qacc", "ctrl", "actuator_force", "time")
        return {name: np.array(getattr(self.data, name)) for name in names}

    def restore(self, state: np.ndarray) -> None:
        """Go back to a saved state; the clock runs on, as do the torque peaks."""
        now = self.data.time
        spec = mujoco.mjtState.mjSTATE_INTEGRATION
        mujoco.mj_setState(self.scene.model, self.data, state, spec)
        self.data.time = now
        mujoco.mj_forward(self.scene.model, self.data)

    @contextlib.contextmanager
    def without_table(self) -> Iterator[None]:
        """The object passes through the table within the block."""
        model, table = self.scene.model, self.scene.table
        types = model.geom_contype[table], model.geom_conaffinity[table]
        model.geom_contype[table] = model.geom_conaffinity[table] = 0
        try:
            yield
        finally:  # the compiled model is shared by all trials of the process
            model.geom_contype[table], model.geom_conaffinity[table] = types

    @contextlib.contextmanager
    def friction_scaled(self, factor: float) -> Iterator[None]:
        """Friction between hand and object is ``factor`` times the object's within the block."""
        model = self.scene.model
        touching = np.isin(self.scene.geom_group, (OBJECT_GEOM, HAND_GEOM))
        before = model.geom_friction[touching, 0].copy()
        model.geom_friction[touching, 0] = factor * before
        try:
            yield
        finally:
            model.geom_friction[touching, 0] = before

    def wait(self, duration: float) -> None:
        """Let time pass [s] with the references as they are."""
        for _ in range(round(duration / self.tick_time)):
            self.tick()

    def follow(self, path: Callable[[float], np.ndarray], duration: float) -> None:
        """Move the arm's references along ``path(share)``, share 0 to 1, within a duration [s]."""
        for k in range(1, round(duration / self.tick_time) + 1):
            self.tick(path(k * self.tick_time / duration))

    def touches(self, first: int, second: int) -> bool:
        """Whether geoms of two groups are in contact."""
        groups = np.sort(self.scene.geom_group[self.data.contact.geom], axis=1)
        return bool((groups == sorted((first, second))).all(axis=1).any())

    def on_table(self) -> bool:
        """Whether the object touches the table."""
        return self.touches(OBJECT_GEOM, TABLE_GEOM)

    def hand_touch(self) -> tuple[float, float]:
        """Normal force between object and hand: on taxels, on all other parts of the hand [N].

        A contact that bears no force counts for nothing.
        """
        contact, scene = self.data.contact, self.scene
        if self.data.ncon == 0:
            return 0.0, 0.0
        groups = np.sort(scene.geom_group[contact.geom], axis=1)
        alive = (groups == (OBJECT_GEOM, HAND_GEOM)).all(axis=1) & (contact.efc_address >= 0)
        force = self.data.efc_force[contact.efc_address[alive]]
        sensed = (scene.taxel[contact.geom[alive]] >= 0).any(axis=1)
        return float(force[sensed].sum()), float(force[~sensed].sum())

    def object_in_hand(self) -> np.ndarray:
        """Pose of the object in the palm frame, x y z qw qx qy qz (7,)."""
        data, palm, body = self.data, self.scene.palm, self.scene.object
        inverse, pose = np.empty(4), np.empty(7)
        mujoco.mju_negQuat(inverse, data.xquat[palm])
        mujoco.mju_rotVecQuat(pose[:3], data.xpos[body] - data.xpos[palm], inverse)
        mujoco.mju_mulQuat(pose[3:], inverse, data.xquat[body])
        return pose
