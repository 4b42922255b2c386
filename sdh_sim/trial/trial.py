"""One trial: grasp, snapshot, prediction, lift, verdict, and the tests after it."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from sdh_sim.cell.contacts import taxel_forces
from sdh_sim.cell.scene import Scene, build_scene
from sdh_sim.cell.simulation import Cell
from sdh_sim.errors import Diverged
from sdh_sim.grasping.acquire import acquire
from sdh_sim.grasping.motion_plan import Course, find_course, place, plan_columns
from sdh_sim.metrics import user_metrics
from sdh_sim.metrics.prediction import Prediction, predict
from sdh_sim.objects.catalogue import ObjectInfo, object_info
from sdh_sim.robot.hand import HandKinematics
from sdh_sim.robot.pads import arrays
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.sensing.tactile_sensor import PRESETS, TactileSensor
from sdh_sim.sensing.tracking_error import misperceive
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import load_test, outcome
from sdh_sim.trial.disturbance import disturb
from sdh_sim.trial.lift import lift
from sdh_sim.trial.repeats import repeat_trial
from sdh_sim.trial.trial_log import LogWriter, TrialLog

# Random streams of a trial beside the plan's own, so that an option changes nothing else.
_SENSOR, _PERCEPTION, _REPEATS = 1, 2, 3


@dataclass(frozen=True)
class TrialResult:
    """What a trial leaves.

    Attributes:
        row: its row of the table.
        log: its time series, if one was asked for.
        sim_seconds: simulated time [s].
        wall_seconds: real time [s].
        diverged: state after the step in which the simulation diverged, by name; else None.
    """

    row: dict[str, Any]
    log: TrialLog | None
    sim_seconds: float
    wall_seconds: float
    diverged: dict[str, np.ndarray] | None = None


@lru_cache(maxsize=8)
def _scene(settings: TrialSettings) -> Scene:
    return build_scene(settings)


@lru_cache(maxsize=1)
def _hand() -> HandKinematics:
    return HandKinematics()


def run_trial(settings: TrialSettings, seed: int, log: bool = False) -> TrialResult:
    """Run one trial; settings and seed decide it completely, a log changes nothing.

    Args:
        settings: object, torque limits and so on.
        seed: of everything random in the trial.
        log: keep poses, tactile arrays and torques at 30 Hz.

    Raises:
        SettingsError: no such object.
    """
    begin = time.perf_counter()
    scene, thing = _scene(settings), object_info(settings.object, settings.folder)
    course = find_course(scene, thing, np.random.default_rng(seed))
    writer = LogWriter(scene) if log else None
    run = _Run(Cell(scene, writer), thing, course, seed)
    row = {"object": settings.object, "seed": seed, **plan_columns(course), **run.execute()}
    if settings.repeats:
        share = repeat_trial(scene, thing, course, np.random.default_rng((seed, _REPEATS)))
        low, high = share.interval or (math.nan, math.nan)
        row |= {"repeats": share.n, "success_probability": share.value}
        row |= {"success_low": low, "success_high": high}
    record = writer.finish(row, run.prediction) if writer is not None else None
    seconds = time.perf_counter() - begin
    return TrialResult(row, record, run.cell.time, seconds, run.diverged)


def cell_before_grasp(settings: TrialSettings, seed: int) -> Cell:
    """The cell of a trial at its beginning: the object on the table, the open hand before it."""
    scene, thing = _scene(settings), object_info(settings.object, settings.folder)
    course = find_course(scene, thing, np.random.default_rng(seed))
    cell = Cell(scene)
    place(scene, cell.data, thing, course.plan, course.approach[0], course.opening)
    return cell


class _Run:
    """One simulation from the table to the verdict and the tests after it."""

    def __init__(self, cell: Cell, thing: ObjectInfo, course: Course, seed: int) -> None:
        self.cell, self.thing, self.course, self.seed = cell, thing, course, seed
        self.settings = cell.scene.settings
        self.prediction: Prediction | None = None
        self.diverged: dict[str, np.ndarray] | None = None
        self.row: dict[str, Any] = {
            "mass_kg": thing.mass_kg,
            "friction": thing.friction,
            "torque_limit_nm": cell.limits,
            "failure": "unstable_simulation",
        }

    def execute(self) -> dict[str, Any]:
        """Run it all; columns of what did not happen are missing."""
        try:
            self._to_verdict()
        except Diverged:
            self.diverged = self.cell.state()
            self.row["failure"] = "unstable_simulation"
            self.row["displacement_mm"] = self.row["rotation_deg"] = math.nan
        self.row |= {
            "success": self.row["failure"] == "none",
            "peak_torque_nm": self.cell.peak,
            "sim_seconds": self.cell.time,
        }
        return self.row

    def _to_verdict(self) -> None:
        cell, thing, row = self.cell, self.thing, self.row
        cell.sensor = TactileSensor(PRESETS[self.settings.sensor], self._rng(_SENSOR))
        acquire(cell, thing, self.course)
        snapshot = self._snapshot()
        cell.sensor = None
        grasped = cell.save()
        if not row["sensed_force_n"] and not row["unsensed_force_n"]:
            row["failure"] = "no_contact"
            if self.settings.load_test != "none":
                row |= {"q_sim": 0.0, "q_sim_capped": False}
            return
        moved, turned, fell = lift(cell, thing, self.course, snapshot.object_pose_hand)
        row |= {"displacement_mm": moved, "rotation_deg": turned}
        failure = outcome.classify(True, fell, moved, turned)
        if failure == "none":
            self._after_lift(cell.save())
        elif self.settings.load_test != "none":
            cell.restore(grasped)
            self._gravity_load(0.0)
        # Last, since a diverged test after it would leave the verdict in doubt.
        row["failure"] = failure

    def _after_lift(self, lifted: np.ndarray) -> None:
        cell, thing, row = self.cell, self.thing, self.row
        if self.settings.disturbance != "none":
            moved, turned, fell = disturb(cell, thing, self.settings.disturbance)
            row |= {
                "disturbance_failure": outcome.classify(True, fell, moved, turned),
                "disturbance_displacement_mm": moved,
                "disturbance_rotation_deg": turned,
            }
            cell.restore(lifted)
        if self.settings.load_test == "directions":
            row["load_at_failure"] = load_test.direction_loads(cell, thing)
        if self.settings.load_test != "none":
            self._gravity_load(1.0)

    def _gravity_load(self, start: float) -> None:
        result = load_test.gravity_factor(self.cell, self.thing, start)
        self.row |= {"q_sim": result.load, "q_sim_capped": result.capped}

    def _snapshot(self) -> TactileSnapshot:
        cell, row = self.cell, self.row
        snapshot = take_snapshot(cell)
        sensed, unsensed = cell.hand_touch()
        row |= {
            "tactile_proximal": snapshot.proximal,
            "tactile_distal": snapshot.distal,
            "joint_angles_rad": snapshot.joint_angles,
            "motor_torque_nm": snapshot.motor_torques,
            "object_pose_hand": snapshot.object_pose_hand,
            "hand_pose_world": snapshot.hand_pose_world,
            "sensed_force_n": sensed,
            "unsensed_force_n": unsensed,
            "unsensed_contact": unsensed > 0.0,
        }
        seen, known = misperceive(snapshot, self.thing, self.settings, self._rng(_PERCEPTION))
        row |= {
            "perceived_pose_hand": seen.object_pose_hand,
            "perceived_mass_kg": known.mass_kg,
            "perceived_friction": known.friction,
        }
        settings = self.settings
        self.prediction = predict(seen, known, settings.torque_limit, settings.pads, _hand())
        row |= self.prediction.values
        row |= user_metrics.evaluate(self.prediction.grasp, settings.metrics)
        row |= {"q_reason": self.prediction.reason, "contacts": len(self.prediction.contacts)}
        return snapshot

    def _rng(self, stream: int) -> np.random.Generator:
        return np.random.default_rng((self.seed, stream))


def take_snapshot(cell: Cell) -> TactileSnapshot:
    """What the hand senses now; a cell without sensor is read by an ideal one."""
    data, scene = cell.data, cell.scene
    sensor = cell.sensor
    if sensor is None:
        sensor = TactileSensor(None, np.random.default_rng(0))
        sensor.frame(taxel_forces(scene, data))
    proximal, distal = arrays(sensor.read())
    return TactileSnapshot(
        proximal=proximal,
        distal=distal,
        joint_angles=data.qpos[scene.motor_qpos].copy(),
        motor_torques=data.actuator_force[scene.motors].copy(),
        object_pose_hand=cell.object_in_hand(),
        hand_pose_world=np.concatenate((data.xpos[scene.palm], data.xquat[scene.palm])),
    )
