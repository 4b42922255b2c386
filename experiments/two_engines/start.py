"""MuJoCo's state at the snapshot of a trial, from which both engines go on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.two_engines.alignment import GUESSED_DEMAND
from sdh_sim.campaign.jobs import given_plan
from sdh_sim.cell import Scene
from sdh_sim.errors import RunError
from sdh_sim.runs import Job
from sdh_sim.trial import Trial
from sdh_sim.trial.lift import LIFT_TIME
from sdh_sim.trial.outcome import moved_between

SAME_MM, SAME_DEG = 1e-3, 1e-3  # by which a repeated snapshot may be off the table's


@dataclass(frozen=True)
class Start:
    """MuJoCo's state at a snapshot.

    Attributes:
        scene: of it.
        palm, obj: poses in the world (7,).
        qpos: coordinates of the model.
        angles, torques, references: of the motors (n,) [rad or m], [N m or N].
        lift_time: [s].
    """

    scene: Scene
    palm: np.ndarray
    obj: np.ndarray
    qpos: np.ndarray
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
    return start_from(trial)


def start_from(trial: Trial) -> Start:
    """The state of a trial that has come to its snapshot."""
    simulation, scene = trial.simulation, trial.scene
    data = simulation.data
    return Start(
        scene=scene,
        palm=simulation.pose(scene.palm),
        obj=simulation.pose(scene.object_body),
        qpos=data.qpos.copy(),
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
