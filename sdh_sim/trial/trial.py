"""One trial: grasp, snapshot, prediction, lift, verdict, and the tests after it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from sdh_sim.cell import Observer, Scene, Simulation, scene_of
from sdh_sim.errors import Diverged, InfeasibleGrasp, SettingsError
from sdh_sim.grasping import (
    GraspPlan,
    Infeasible,
    MotionPlan,
    acquire,
    place,
    plan_given,
    plan_motion,
)
from sdh_sim.metrics import Prediction, predict, user_metrics
from sdh_sim.poses import rotation_of
from sdh_sim.records import LIFT_OFF, TrialRow
from sdh_sim.robot import hand_kinematics
from sdh_sim.sensing import (
    TactileFrames,
    TactileSensor,
    TactileSnapshot,
    add_tracking_error,
    take_snapshot,
    touched_pose,
    unit_vector,
)
from sdh_sim.sensing.tactile_sensor import PRESETS
from sdh_sim.settings import FROM_FILE, TrialSettings
from sdh_sim.settling import Rubber, Settled
from sdh_sim.trial import load_test
from sdh_sim.trial.disturbance import disturb
from sdh_sim.trial.lift import lift, rise
from sdh_sim.trial.outcome import Motion, classify, further, moved_between
from sdh_sim.trial.plan_columns import describe_conditions, describe_grasp, describe_motion
from sdh_sim.trial.protocol import NO_CONTACT, to_verdict, weigh_all
from sdh_sim.trial.settling_row import rate_settled, settle_into
from sdh_sim.trial.snapshot_columns import describe_snapshot
from sdh_sim.trial.weigh import weigh

# Random streams of a trial beside the plan's own, so that an option changes nothing else.
_SENSOR, _TRACKING = 1, 2


class Trial:
    """One grasp-and-lift, step by step; settings and seed decide it completely.

    ``acquire``, ``snapshot``, ``settle``, ``lift_off``, ``lift`` (without a table ``weigh``),
    ``disturb``, ``load`` and ``load_directions`` are called in that order, each where it is wanted;
    ``run`` calls those that the settings ask for. What each finds out is kept in ``row``.

    Args:
        settings: object, torque limits and so on.
        seed: of everything random in the trial.
        plan: a given grasp; None draws one from the seed.
        scene: to run in; None takes the one of the settings.
        motion: to run; None finds that of the grasp.
        observers: of the simulation; they change nothing.

    Attributes:
        settings, seed, scene: as above.
        simulation: the scene in motion.
        row: what is known so far.
        prediction: what the metrics say; None before the snapshot.
        lifted_off: the same at lift-off; None before that.
        diverged: state after the step in which the simulation diverged, by name; else None.

    Raises:
        SettingsError: no such object, or no plan where grasps come from a file.
        NoFeasibleGrasp: none could be drawn.
    """

    def __init__(
        self,
        settings: TrialSettings,
        seed: int = 0,
        *,
        plan: GraspPlan | None = None,
        scene: Scene | None = None,
        motion: MotionPlan | None = None,
        observers: Iterable[Observer] = (),
    ) -> None:
        self.settings, self.seed = settings, seed
        self.scene = scene or scene_of(settings)
        self.plan = plan
        found: MotionPlan | Infeasible
        if motion is not None:
            found = motion
        elif plan is not None:
            found = plan_given(self.scene, plan)
        elif settings.grasps == FROM_FILE:
            raise SettingsError("grasps: a trial with grasps from a file needs one of them, plan")
        else:
            found = plan_motion(self.scene, np.random.default_rng(seed))
        self._found = found
        self.simulation = Simulation(self.scene, observers)
        self.prediction: Prediction | None = None
        self.lifted_off: Prediction | None = None
        self.diverged: dict[str, np.ndarray] | None = None
        self.row = TrialRow(object=settings.object, seed=seed)
        self._sensor = TactileSensor(PRESETS[settings.sensor], self._rng(_SENSOR), self.scene.hand)
        self._risen: tuple[Motion, float] = Motion(0.0, 0.0, False), 0.0
        self._grasped: np.ndarray | None = None
        self._lifted: np.ndarray | None = None
        self._now: np.ndarray | None = None  # which of these the simulation is at, if any

    def _rng(self, stream: int) -> np.random.Generator:
        return np.random.default_rng((self.seed, stream))

    @property
    def infeasible(self) -> Infeasible | None:
        """Why the given grasp cannot be tried; None where it can."""
        return self._found if isinstance(self._found, Infeasible) else None

    @property
    def motion(self) -> MotionPlan:
        """The grasp with the motion to it; raises InfeasibleGrasp where a given one has none."""
        if isinstance(self._found, Infeasible):
            raise InfeasibleGrasp(f"the grasp cannot be tried: {self._found.reason}")
        return self._found

    def place(self) -> None:
        """The beginning: the object on the table, the open hand before it."""
        motion = self.motion
        place(self.scene, self.simulation.data, motion.grasp, motion.approach[0], motion.opening)

    def acquire(self) -> None:
        """Grasp the object and come to rest, the tactile arrays watched; raises Diverged."""
        with self.simulation.observed_by(TactileFrames(self._sensor)):
            acquire(self.simulation, self.motion)
        self._grasped = self._now = self.simulation.save()
        self._in_hand = self.simulation.object_in_hand()
        self._grasped_rotation = rotation_of(self.simulation.pose(self.scene.object_body)[3:])

    @property
    def touched(self) -> bool:
        """Whether any part of the hand bears on the object now."""
        return sum(self.simulation.hand_force()) > 0.0

    def snapshot(self) -> TactileSnapshot:
        """What the hand senses after ``acquire``, and what the metrics say of it."""
        on_table = self.settings.support == "table"
        snapshot, self.prediction = self._look(self.row, on_table)
        self.row.perceived_mass_kg = self.prediction.grasp.obj.mass_kg
        self.row.perceived_friction = self.prediction.grasp.obj.friction
        self.row.taxel_threshold = self.settings.taxel_threshold
        return snapshot

    def settle(self) -> Settled:
        """Predict from the ``snapshot`` where the grasp settles when the table lets go."""
        if self.prediction is None:
            raise RuntimeError("the trial has not come that far: snapshot comes first")
        settings, kinematics = self.settings, hand_kinematics(self.scene.hand)
        rubber = Rubber(settings.pad_modulus, settings.pad_thickness)
        settled = settle_into(self.row, self.prediction.grasp, kinematics, rubber, settings.pads)
        if settings.settle == "metrics":
            rate_settled(self.row, settled, settings.metrics)
        return settled

    def lift_off(self) -> Motion:
        """Raise the hand after ``acquire`` until the object has left the table; a second snapshot.

        The lift then goes on from there.

        Returns:
            the motion in the hand since ``acquire``.

        Raises:
            Diverged: the simulation did.
        """
        before = self.simulation.pose(self.scene.palm)[2]
        with self.simulation.observed_by(TactileFrames(self._sensor, self.simulation.time)):
            self._risen = moved, _ = rise(self.simulation, self.motion, self._in_hand)
        self._now = None
        seen = TrialRow()
        _, self.lifted_off = self._look(seen, on_table=False)
        now, com = self.simulation.object_in_hand(), self.scene.obj.com_m
        seen.displacement_mm, seen.rotation_deg = moved_between(self._in_hand, now, com)
        known = {name: value for name, value in seen.items() if value is not None}
        known["rise_mm"] = 1e3 * (self.simulation.pose(self.scene.palm)[2] - before)
        known["on_table"] = self.simulation.on_table()
        self.row.update({LIFT_OFF + name: value for name, value in known.items()})
        return moved

    def _look(self, row: TrialRow, on_table: bool) -> tuple[TactileSnapshot, Prediction]:
        """What the hand senses now and what the metrics say of it, also put into a row."""
        snapshot, settings = take_snapshot(self.simulation, self._sensor), self.settings
        describe_snapshot(row, snapshot, self.simulation.hand_force())
        seen, known = add_tracking_error(snapshot, self.scene.obj, settings, self._rng(_TRACKING))
        kinematics = hand_kinematics(self.scene.hand)
        if settings.touch:
            errors = settings.position_error, settings.angle_error
            pose = touched_pose(seen, known, *errors, kinematics, on_table)
            seen = replace(seen, object_pose_hand=pose)
        row.perceived_pose_hand = seen.object_pose_hand
        limits, threshold = self.scene.torque_limit, settings.taxel_threshold
        prediction = predict(seen, known, limits, settings.pads, kinematics, threshold)
        row.update(prediction.values)
        row.update(user_metrics.evaluate_user_metrics(prediction.grasp, settings.metrics))
        row.q_reason = prediction.reason
        row.contacts = len(prediction.contacts)
        return snapshot, prediction

    def lift(self) -> Motion:
        """Lift and hold after ``acquire``; the motion in the hand since then. Raises Diverged."""
        moved, risen = self._risen
        motion = further(moved, lift(self.simulation, self.motion, self._in_hand, risen))
        self.row.displacement_mm, self.row.rotation_deg = motion[:2]
        self._lifted = self._now = self.simulation.save()
        return motion

    def weigh(self, direction: str) -> Motion:
        """Put the weight into the hand after ``acquire``, in a scene without a table.

        Args:
            direction: of the weight, a member of ``GRAVITY_DIRECTIONS``.

        Returns:
            the motion in the hand since then.

        Raises:
            Diverged: the simulation did.
        """
        self._go_to(self._grasped)
        before = self.simulation.object_in_hand()
        motion = weigh(self.simulation, self._down(direction), before)
        return motion

    def _down(self, direction: str) -> np.ndarray:
        """Direction in the world (3,) of a weight along one of the grasped object's axes."""
        return self._grasped_rotation @ unit_vector(direction)

    def disturb(self) -> Motion:
        """Turn or shake the lifted hand, as the settings say; raises Diverged."""
        self._go_to(self._lifted)
        motion = disturb(self.simulation, self.settings.disturbance)
        self.row.disturbance_failure = classify(motion)
        self.row.disturbance_displacement_mm = motion.displacement_mm
        self.row.disturbance_rotation_deg = motion.rotation_deg
        return motion

    def load(self, speed: float = 1.0, direction: str | None = None) -> load_test.Failure:
        """Take the table away and scale the object's weight until it gives way (q_sim).

        Args:
            speed: factor on the rates at which the load grows.
            direction: of the weight in a scene without a table, as ``weigh`` takes it.

        Raises:
            Diverged: the simulation did.
        """
        self._go_to(self._grasped)
        down = load_test.WORLD_DOWN if direction is None else self._down(direction)
        result = load_test.gravity_factor(self.simulation, speed, down)
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
                return NO_CONTACT, Motion(math.nan, math.nan, True)
            if self.settings.support == "none":
                return weigh_all(self, loaded=False)
            if self.settings.lift_off:
                self.lift_off()
            motion = self.lift()
        except Diverged:
            return "unstable_simulation", Motion(math.nan, math.nan, True)
        return classify(motion), motion

    def run(self) -> TrialRow:
        """The whole trial, but for its copies; columns of what did not happen stay None."""
        row = self.row
        self._describe()
        if self.infeasible is not None:
            row.failure, row.success = "infeasible", False
            row.infeasible_reason = self.infeasible.reason
            return row
        try:
            row.failure = to_verdict(self)
        except Diverged:
            self.diverged = self.simulation.state()
            row.failure = "unstable_simulation"
            row.displacement_mm = row.rotation_deg = math.nan
        row.success = row.failure == "none"
        row.peak_torque_nm = self.simulation.peak
        row.sim_seconds = self.simulation.time
        return row

    def _describe(self) -> None:
        """What the row says of the object, the limits and the plan."""
        row, obj, found = self.row, self.scene.obj, self._found
        describe_conditions(row, self.settings, obj, self.simulation.limits)
        if not isinstance(found, Infeasible):
            describe_grasp(row, found.grasp, obj)
            describe_motion(row, found)
        elif self.plan is not None:
            describe_grasp(row, self.plan, obj)
