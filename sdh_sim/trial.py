"""One trial: place, approach, close, squeeze, snapshot, lift, hold, verdict."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from sdh_sim import outcome
from sdh_sim.acquire import acquire
from sdh_sim.arm import along
from sdh_sim.cell import Cell, Diverged
from sdh_sim.course import Course, arm_kinematics, find_course, plan_columns
from sdh_sim.hand import HandKinematics
from sdh_sim.log import LogWriter, TrialLog
from sdh_sim.objects import ObjectInfo, object_info
from sdh_sim.prediction import Prediction, predict
from sdh_sim.scene import Scene, build_scene
from sdh_sim.settings import TrialSettings
from sdh_sim.tactile import TactileSnapshot, arrays, readings, taxel_forces

LIFT_TIME, HOLD_TIME = 1.5, 2.0  # [s]
GONE_MM = 80.0  # an object this far from its place in the hand has left it; no need to go on


@dataclass(frozen=True)
class TrialResult:
    """What a trial leaves: its row of the table, and the log if one was asked for."""

    row: dict[str, Any]
    log: TrialLog | None
    sim_seconds: float
    wall_seconds: float


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
    scene, thing = _scene(settings), object_info(settings.object)
    course = find_course(scene, thing, np.random.default_rng(seed))
    writer = LogWriter(scene) if log else None
    cell = Cell(scene, writer)
    row = {"object": settings.object, "seed": seed, **plan_columns(course)}
    prediction = _execute(cell, thing, course, row)
    record = writer.finish(row, prediction) if writer is not None else None
    return TrialResult(row, record, cell.time, time.perf_counter() - begin)


def _execute(
    cell: Cell, thing: ObjectInfo, course: Course, row: dict[str, Any]
) -> Prediction | None:
    """Run to the verdict and fill the row; the prediction is None when it never came to one."""
    settings = cell.scene.settings
    prediction = None
    failure, moved, turned = "unstable_simulation", math.nan, math.nan
    try:
        acquire(cell, thing, course)
        snapshot = take_snapshot(cell)
        sensed, unsensed = cell.hand_touch()
        row |= _snapshot_columns(snapshot)
        row |= {
            "sensed_force_n": sensed,
            "unsensed_force_n": unsensed,
            "unsensed_contact": unsensed > 0.0,
        }
        prediction = predict(snapshot, thing, settings.torque_limit, settings.pads, _hand())
        row |= prediction.values
        row |= {"q_reason": prediction.reason, "contacts": len(prediction.contacts)}
        if sensed > 0.0 or unsensed > 0.0:
            moved, turned, fell = lift(cell, thing, course, snapshot.object_pose_hand)
            failure = outcome.classify(True, fell, moved, turned)
        else:
            failure = "no_contact"
    except Diverged:
        moved = turned = math.nan
    row |= {
        "mass_kg": thing.mass_kg,
        "friction": thing.friction,
        "torque_limit_nm": cell.limits,
        "success": failure == "none",
        "failure": failure,
        "displacement_mm": moved,
        "rotation_deg": turned,
        "peak_torque_nm": cell.peak,
        "sim_seconds": cell.time,
    }
    return prediction


def take_snapshot(cell: Cell) -> TactileSnapshot:
    """What the hand senses now."""
    data, scene = cell.data, cell.scene
    proximal, distal = arrays(readings(taxel_forces(scene, data), scene.settings.sensor))
    return TactileSnapshot(
        proximal=proximal,
        distal=distal,
        joint_angles=data.qpos[scene.motor_qpos].copy(),
        motor_torques=data.actuator_force[scene.motors].copy(),
        object_pose_hand=cell.object_in_hand(),
        hand_pose_world=np.concatenate((data.xpos[scene.palm], data.xquat[scene.palm])),
    )


def _snapshot_columns(snapshot: TactileSnapshot) -> dict[str, Any]:
    return {
        "tactile_proximal": snapshot.proximal,
        "tactile_distal": snapshot.distal,
        "joint_angles_rad": snapshot.joint_angles,
        "motor_torque_nm": snapshot.motor_torques,
        "object_pose_hand": snapshot.object_pose_hand,
        "hand_pose_world": snapshot.hand_pose_world,
    }


def lift(
    cell: Cell, thing: ObjectInfo, course: Course, before: np.ndarray
) -> tuple[float, float, bool]:
    """Lift and hold.

    Args:
        cell: at the snapshot.
        thing: the object.
        course: with the arm's path.
        before: pose of the object in the hand at the snapshot (7,).

    Returns:
        greatest displacement [mm] and rotation [deg] of the object in the hand, whether it fell.

    Raises:
        Diverged: the simulation did.
    """
    duration = arm_kinematics().duration(course.lift, LIFT_TIME)
    moved = turned = 0.0
    for k in range(1, round((duration + HOLD_TIME) / cell.tick_time) + 1):
        share = k * cell.tick_time / duration
        cell.phase = "lift" if share <= 1.0 else "hold"
        cell.data.ctrl[cell.scene.arm_motors] = along(course.lift, share)
        cell.tick()
        step = outcome.motion(before, cell.object_in_hand(), thing.com_m)
        moved, turned = max(moved, step[0]), max(turned, step[1])
        if moved > GONE_MM:
            return moved, turned, True
    return moved, turned, cell.on_table()
