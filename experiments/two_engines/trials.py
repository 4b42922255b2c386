"""One trial in both engines: the snapshot of MuJoCo, carried on in Drake."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from experiments.two_engines.alignment import GUESSED_DEMAND, Alignment
from experiments.two_engines.engine import DrakeSimulation
from experiments.two_engines.outcomes import gravity_factor, lift
from experiments.two_engines.translate import translate
from sdh_sim.campaign.jobs import given_plan
from sdh_sim.cell import Scene
from sdh_sim.errors import Diverged, RunError
from sdh_sim.runs import Job
from sdh_sim.trial import Trial, classify
from sdh_sim.trial.lift import LIFT_TIME
from sdh_sim.trial.outcome import Motion, moved_between

SAME_MM, SAME_DEG = 1e-3, 1e-3  # by which a repeated snapshot may be off the table's


class Task(NamedTuple):
    """What a worker does.

    Attributes:
        job: the trial.
        row: of the run's table.
        alignments: to carry it on with, by name.
        ramp: which of them get the load ramp.
    """

    job: Job
    row: Mapping[str, Any]
    alignments: Mapping[str, Alignment]
    ramp: tuple[str, ...]


@dataclass(frozen=True)
class Start:
    """MuJoCo's state at a snapshot.

    Attributes:
        scene: of it.
        palm, obj: poses in the world (7,).
        joints: positions of all joints of the model by id.
        angles, torques, references: of the motors (n,) [rad or m], [N m or N].
        lift_time: [s].
    """

    scene: Scene
    palm: np.ndarray
    obj: np.ndarray
    joints: dict[int, float]
    angles: np.ndarray
    torques: np.ndarray
    references: np.ndarray
    lift_time: float


def start_of(job: Job, row: Mapping[str, Any]) -> Start:
    """Repeat a trial to its snapshot.

    Raises:
        RunError: it is not the one of the table (another version, or another processor).
    """
    trial = Trial(job.settings, job.seed, **given_plan(job))
    trial.acquire()
    simulation, scene = trial.simulation, trial.scene
    pose = np.asarray(row["object_pose_hand"], dtype=float)
    off = moved_between(pose, simulation.object_in_hand(), scene.obj.com_m)
    if off[0] > SAME_MM or off[1] > SAME_DEG:
        raise RunError(
            f"trial {job.trial}: repeated, its snapshot is {off[0]:.3g} mm and {off[1]:.3g}° off "
            "the one of the table; run it again with the versions that are installed"
        )
    data, model = simulation.data, scene.model
    positions = {k: float(data.qpos[model.jnt_qposadr[k]]) for k in range(model.njnt)}
    return Start(
        scene=scene,
        palm=simulation.pose(scene.palm),
        obj=simulation.pose(scene.object_body),
        joints=positions,
        angles=scene.motor_positions(data),
        torques=data.actuator_force[scene.motors].copy(),
        references=data.ctrl[scene.motors].copy(),
        lift_time=scene.palm_motion.duration(trial.motion.lift, LIFT_TIME),
    )


def guessed_references(start: Start) -> np.ndarray:
    """References (n,) that angles and torques suggest, where those of the trial are not known."""
    model, motors = start.scene.model, start.scene.motors
    limits = model.actuator_forcerange[motors, 1]
    asked = np.where(
        np.abs(start.torques) > 0.999 * limits,
        GUESSED_DEMAND * np.sign(start.torques) * limits,
        start.torques,
    )
    return start.angles + asked / model.actuator_gainprm[motors, 0]


def set_off(start: Start, alignment: Alignment) -> DrakeSimulation:
    """Drake at the snapshot, all at rest."""
    simulation = DrakeSimulation(translate(start.scene, start.palm, start.obj, alignment))
    references = start.references if alignment.references else guessed_references(start)
    simulation.set_to(start.joints, start.obj, references)
    return simulation


def compare(task: Task) -> list[dict[str, Any]]:
    """Rows of a trial, one for each alignment: what Drake makes of the snapshot.

    Raises:
        RunError: as ``start_of``.
    """
    start, rows = start_of(task.job, task.row), []
    for name, alignment in task.alignments.items():
        begin = time.process_time()
        row: dict[str, Any] = {
            "trial": task.job.trial, "object": task.job.settings.object, "seed": task.job.seed,
            "alignment": name,
        }  # fmt: skip
        motion = _moved(start, alignment)
        row["failure"] = classify(motion)
        row["success"] = row["failure"] == "none"
        row["displacement_mm"], row["rotation_deg"] = motion[:2]
        row["q_sim"], row["q_sim_capped"] = math.nan, False
        if name in task.ramp:
            row["q_sim"], row["q_sim_capped"] = _load(start, alignment)
        row["seconds"] = time.process_time() - begin
        rows.append(row)
    return rows


def _moved(start: Start, alignment: Alignment) -> Motion:
    try:
        return lift(set_off(start, alignment), start.lift_time)
    except Diverged:
        return Motion(math.nan, math.nan, True)


def _load(start: Start, alignment: Alignment) -> tuple[float, bool]:
    try:
        found = gravity_factor(set_off(start, alignment))
    except Diverged:
        return math.nan, False
    return found.load, found.capped
