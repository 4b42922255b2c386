"""One trial: grasp, snapshot, prediction, lift, verdict, and the tests after it."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from sdh_sim.cell import Observer, Scene, Simulation, scene_of
from sdh_sim.errors import Diverged
from sdh_sim.grasping import MotionPlan, acquire, place, plan_motion
from sdh_sim.metrics import Prediction, predict, user_metrics
from sdh_sim.records import TrialRow
from sdh_sim.sensing import (
    TactileFrames,
    TactileSensor,
    TactileSnapshot,
    add_tracking_error,
    take_snapshot,
)
from sdh_sim.sensing.tactile_sensor import PRESETS
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import load_test
from sdh_sim.trial.disturbance import disturb
from sdh_sim.trial.lift import lift
from sdh_sim.trial.outcome import Motion, classify

# Random streams of a trial beside the plan's own, so that an option changes nothing else.
_SENSOR, _TRACKING = 1, 2


class Trial:
    """One grasp-and-lift, step by step; settings and seed decide it completely.

    ``acquire``, ``snapshot``, ``lift``, ``disturb``, ``load`` and ``load_directions`` are called in
    that order, each where it is wanted; ``run`` calls those that the settings ask for. What each
    finds out is kept in ``row``.

    Args:
        settings: object, torque limits and so on.
        seed: of everything random in the trial.
        scene: to run in; None takes the one of the settings.
        motion: to run; None draws one from the seed.
        observers: of the simulation; they change nothing.

    Attributes:
        settings, seed, scene, motion: as above.
        simulation: the scene in motion.
        row: what is known so far.
        prediction: what the metrics say; None before the snapshot.
        diverged: state after the step in which the simulation diverged, by name; else None.

    Raises:
        SettingsError: no such object.
    """

    def __init__(
        self,
        settings: TrialSettings,
        seed: int,
        *,
        scene: Scene | None = None,
        motion: MotionPlan | None = None,
        observers: Iterable[Observer] = (),
    ) -> None:
        self.settings, self.seed = settings, seed
        self.scene = scene or scene_of(settings)
        self.motion = motion or plan_motion(self.scene, np.random.default_rng(seed))
        self.simulation = Simulation(self.scene, observers)
        self.prediction: Prediction | None = None
        self.diverged: dict[str, np.ndarray] | None = None
        self.row = TrialRow(object=settings.object, seed=seed)
        self._sensor = TactileSensor(PRESETS[settings.sensor], self._rng(_SENSOR))
        self._grasped: np.ndarray | None = None
        self._lifted: np.ndarray | None = None
        self._now: np.ndarray | None = None  # which of the two the simulation is at, if any

    def _rng(self, stream: int) -> np.random.Generator:
        return np.random.default_rng((self.seed, stream))

    def place(self) -> None:
        """The beginning: the object on the table, the open hand before it."""
        motion = self.motion
        place(self.scene, self.simulation.data, motion.grasp, motion.approach[0], motion.opening)

    def acquire(self) -> None:
        """Grasp the object and come to rest, the tactile arrays watched; raises Diverged."""
        with self.simulation.observed_by(TactileFrames(self._sensor)):
            acquire(self.simulation, self.motion)
        self._grasped = self._now = self.simulation.save()

    @property
    def touched(self) -> bool:
        """Whether any part of the hand bears on the object now."""
        return sum(self.simulation.hand_force()) > 0.0

    def snapshot(self) -> TactileSnapshot:
        """What the hand senses after ``acquire``, and what the metrics say of it."""
        snapshot = take_snapshot(self.simulation, self._sensor)
        row, settings = self.row, self.settings
        row.tactile_proximal, row.tactile_distal = snapshot.proximal, snapshot.distal
        row.joint_angles_rad = snapshot.joint_angles
        row.motor_torque_nm = snapshot.motor_torques
        row.object_pose_hand = snapshot.object_pose_hand
        row.hand_pose_world = snapshot.hand_pose_world
        row.sensed_force_n, row.unsensed_force_n = self.simulation.hand_force()
        row.unsensed_contact = row.unsensed_force_n > 0.0
        seen, known = add_tracking_error(snapshot, self.scene.obj, settings, self._rng(_TRACKING))
        row.perceived_pose_hand = seen.object_pose_hand
        row.perceived_mass_kg, row.perceived_friction = known.mass_kg, known.friction
        self.prediction = predict(seen, known, settings.torque_limit, settings.pads)
        row.update(self.prediction.values)
        row.update(user_metrics.evaluate_user_metrics(self.prediction.grasp, settings.metrics))
        row.q_reason = self.prediction.reason
        row.contacts = len(self.prediction.contacts)
        return snapshot

    def lift(self) -> Motion:
        """Lift and hold after ``acquire``; the motion in the hand since then. Raises Diverged."""
        motion = lift(self.simulation, self.motion, self.simulation.object_in_hand())
        self.row.displacement_mm, self.row.rotation_deg = motion[:2]
        self._lifted = self._now = self.simulation.save()
        return motion

    def disturb(self) -> Motion:
        """Turn or shake the lifted hand, as the settings say; raises Diverged."""
        self._go_to(self._lifted)
        motion = disturb(self.simulation, self.settings.disturbance)
        self.row.disturbance_failure = classify(motion)
        self.row.disturbance_displacement_mm = motion.displacement_mm
        self.row.disturbance_rotation_deg = motion.rotation_deg
        return motion

    def load(self, held: bool, speed: float = 1.0) -> load_test.Failure:
        """Scale the object's weight until it gives way (q_sim).

        Args:
            held: go on from the lifted object; otherwise from the grasp on the table, which is
                taken away, with no weight at first.
            speed: factor on the rates at which the load grows.

        Raises:
            Diverged: the simulation did.
        """
        self._go_to(self._lifted if held else self._grasped)
        result = load_test.gravity_factor(self.simulation, 1.0 if held else 0.0, speed)
        self.row.q_sim, self.row.q_sim_capped = result.load, result.capped
        return result

    def load_directions(self, speed: float = 1.0) -> np.ndarray:
        """Loads [N, N m] (9,) at which the lifted object gives way along each direction of
        ``load_test.DIRECTIONS``, inf where it never does; raises Diverged."""
        self._go_to(self._lifted)
        loads = load_test.direction_loads(self.simulation, speed)
        self._now = self._lifted  # where it leaves the simulation
        self.row.load_at_failure = loads
        return loads

    def _go_to(self, state: np.ndarray | None) -> None:
        """Bring the simulation to a state before something leads it away from there.

        Where it is there already nothing is restored: that would start the contact solver from
        other accelerations, and change last bits.
        """
        if state is None:
            raise RuntimeError("the trial has not come that far: acquire and lift come first")
        if state is not self._now:
            self.simulation.restore(state)
        self._now = None

    def grasp_and_lift(self) -> tuple[str, Motion]:
        """The bare trial, without snapshot or tests: how it failed (``none``: it held).

        Returns:
            the failure, and the motion in the hand: NaN where there was no contact or the
            simulation diverged.
        """
        try:
            self.acquire()
            if not self.touched:
                return "no_contact", Motion(math.nan, math.nan, True)
            motion = self.lift()
        except Diverged:
            return "unstable_simulation", Motion(math.nan, math.nan, True)
        return classify(motion), motion

    def run(self) -> TrialRow:
        """The whole trial, but for its copies; columns of what did not happen stay None."""
        row = self.row
        self._describe()
        try:
            row.failure = self._to_verdict()
        except Diverged:
            self.diverged = self.simulation.state()
            row.failure = "unstable_simulation"
            row.displacement_mm = row.rotation_deg = math.nan
        row.success = row.failure == "none"
        row.peak_torque_nm = self.simulation.peak
        row.sim_seconds = self.simulation.time
        return row

    def _to_verdict(self) -> str:
        loaded = self.settings.load_test != "none"
        self.acquire()
        self.snapshot()
        if not self.touched:
            if loaded:
                self.row.q_sim, self.row.q_sim_capped = 0.0, False
            return "no_contact"
        failure = classify(self.lift())
        held = failure == "none"
        if held and self.settings.disturbance != "none":
            self.disturb()
        if held and self.settings.load_test == "directions":
            self.load_directions()
        if loaded:
            self.load(held)
        return failure

    def _describe(self) -> None:
        """What the row says of the object, the limits and the plan."""
        row, obj, motion, grasp = self.row, self.scene.obj, self.motion, self.motion.grasp
        row.mass_kg, row.friction = obj.mass_kg, obj.friction
        row.torque_limit_nm = self.simulation.limits
        row.approach, row.preshape = grasp.approach, grasp.preshape
        row.plan_azimuth_rad, row.plan_roll_rad = grasp.azimuth, grasp.roll
        row.plan_tilt_rad = grasp.tilt
        row.plan_height_m, row.plan_depth_m = grasp.height, grasp.depth
        row.plan_offset_m, row.object_yaw_rad = grasp.offset, grasp.object_yaw
        row.resampled_unreachable, row.resampled_colliding = motion.unreachable, motion.colliding
