"""A scene in motion: MuJoCo's state, stepped with the torque peaks and divergence watched."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

import mujoco
import numpy as np

from sdh_sim import poses
from sdh_sim.cell import contacts
from sdh_sim.cell.current_poses import CurrentPoses
from sdh_sim.cell.drives import LOCK, SelfLocking
from sdh_sim.cell.scene import HAND_GEOM, OBJECT_GEOM, Scene
from sdh_sim.errors import Diverged

TICK = 0.01  # control period [s]
MAX_SPEED = 1e3  # a generalised speed beyond this is a diverged simulation [m/s or rad/s]


class Observer(Protocol):
    """What looks at a simulation after every tick; it may read everything and change nothing."""

    def after_tick(self, scene: Scene, data: mujoco.MjData, phase: str) -> None:
        """Look at the state at the end of a tick; ``phase`` names what is going on."""
        ...


class Simulation:
    """A scene in motion.

    Attributes:
        scene: the compiled scene.
        data: MuJoCo's state.
        observers: called after each tick, in this order.
        peak: largest motor torques so far (n,) [N m or N].
        limits: torque limits of the motors (n,) [N m or N].
        phase: name of what is going on, for observers.
        tick_time: length of a control period [s].
    """

    def __init__(self, scene: Scene, observers: Iterable[Observer] = ()) -> None:
        self.scene = scene
        self.observers = list(observers)
        self.data = mujoco.MjData(scene.model)
        self.steps = max(1, round(TICK / scene.settings.timestep))
        self.tick_time = self.steps * scene.settings.timestep
        self.peak = np.zeros(len(scene.motors))
        self.limits = scene.hand.torque_limits(scene.torque_limit)
        self.phase = ""
        self._current = CurrentPoses(scene.model)
        self._locking: SelfLocking | None = None
        if scene.drives.kind == LOCK:
            stops = scene.drives.stops
            self._locking = SelfLocking(scene.model, scene.motors, stops, self.tick_time)

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
            hand: references of the hand's motors at the end (n,) [rad or m]; None keeps them.

        Raises:
            Diverged: a speed or acceleration is not finite, or a speed beyond any meaning.
        """
        model, data, motors, peak = self.scene.model, self.data, self.scene.motors, self.peak
        speed, acceleration, torque = data.qvel, data.qacc, data.actuator_force
        control = data.ctrl
        rise = None if arm is None and hand is None else self._rise(arm, hand)
        if self._locking is not None:
            self._locking.before_tick(data)
        for _ in range(self.steps):
            if rise is not None:
                control += rise
            mujoco.mj_step(model, data)
            np.maximum(peak, np.abs(torque[motors]), out=peak)
            # The norm of a vector with NaN is NaN and fails the comparison too.
            if not (speed.dot(speed) < MAX_SPEED**2 and math.isfinite(acceleration.dot(speed))):
                raise Diverged
        for observer in self.observers:
            observer.after_tick(self.scene, data, self.phase)

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
        return state if self._locking is None else np.append(state, self._locking.state())

    def state(self) -> dict[str, np.ndarray]:
        """The state by name, for a look at a simulation that went wrong."""
        names = ("qpos", "qvel", "qacc", "ctrl", "actuator_force", "time")
        return {name: np.array(getattr(self.data, name)) for name in names}

    def restore(self, state: np.ndarray) -> None:
        """Go back to a saved state; the clock runs on, as do the torque peaks."""
        now = self.data.time
        spec = mujoco.mjtState.mjSTATE_INTEGRATION
        if self._locking is not None:
            state = self._locking.restore(state)
        mujoco.mj_setState(self.scene.model, self.data, state, spec)
        self.data.time = now
        mujoco.mj_forward(self.scene.model, self.data)

    def free_drives(self) -> None:
        """Tell self-locking drives that the joints have been put somewhere else."""
        if self._locking is not None:
            self._locking.free()

    def fix_object(self) -> None:
        """Hold the object where it is, in a scene without a table; elsewhere nothing happens."""
        if self.scene.fixture < 0:
            return
        pose = self.data.qpos[self.scene.object_qpos : self.scene.object_qpos + 7]
        # Anchor in the object's frame, and the object's pose in the world.
        self.scene.model.eq_data[self.scene.fixture, :10] = (0.0, 0.0, 0.0, *pose)
        self.data.eq_active[self.scene.fixture] = 1

    def release_object(self) -> None:
        """Let the object go that ``fix_object`` holds."""
        if self.scene.fixture >= 0:
            self.data.eq_active[self.scene.fixture] = 0

    @contextlib.contextmanager
    def observed_by(self, observer: Observer) -> Iterator[None]:
        """Call the observer too within the block, before the others."""
        self.observers.insert(0, observer)
        try:
            yield
        finally:
            self.observers.remove(observer)

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
        rubbing = np.isin(self.scene.geom_group, (OBJECT_GEOM, HAND_GEOM))
        before = model.geom_friction[rubbing, 0].copy()
        model.geom_friction[rubbing, 0] = factor * before
        try:
            yield
        finally:
            model.geom_friction[rubbing, 0] = before

    def wait(self, duration: float) -> None:
        """Let time pass [s] with the references as they are."""
        for _ in range(round(duration / self.tick_time)):
            self.tick()

    def follow(self, path: Callable[[float], np.ndarray], duration: float) -> None:
        """Move the arm's references along ``path(share)``, share 0 to 1, within a duration [s]."""
        for k in range(1, round(duration / self.tick_time) + 1):
            self.tick(path(k * self.tick_time / duration))

    def on_table(self) -> bool:
        """Whether the object touches the table."""
        return contacts.object_on_table(self.scene, self.data)

    def hand_force(self) -> tuple[float, float]:
        """Normal force between object and hand: that taxels feel, and all that none does [N]."""
        return contacts.hand_force(self.scene, self.data)

    def object_in_hand(self) -> np.ndarray:
        """Pose of the object in the palm frame, x y z qw qx qy qz (7,)."""
        now = self._current.of(self.data)
        palm = poses.body_pose(now, self.scene.palm)
        return poses.relative(palm, poses.body_pose(now, self.scene.object_body))

    def pose(self, body: int) -> np.ndarray:
        """Pose of a body in the world, x y z qw qx qy qz (7,)."""
        return poses.body_pose(self._current.of(self.data), body)
