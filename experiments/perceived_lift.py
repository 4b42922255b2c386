"""The ceiling of prediction: the simulator itself, started from what the hand perceives.

    python -m experiments.perceived_lift RUN [--workers 2]

For every trial of RUN a new simulation is set to the perceived snapshot: joint angles, motor
torques (which give the references of the servos), the tracked pose, the assumed mass and friction.
The hand stays where it is, on a stiff base, and the table recedes by the height of the lift. What
the object does is judged as in the trial. No metric can be expected to do better from the same
information; what is missing to 100 % is what the perception does not hold. Errors of perception are
the run's own (``--position-error`` and so on).
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from rich.console import Console

from experiments.command_line import Parser, fail
from experiments.score_table import score_table, verdict_scores
from experiments.stored_runs import read_runs
from sdh_sim import poses
from sdh_sim.analysis.comparison import compare_scores, name_of
from sdh_sim.analysis.trial_tables import SURPLUS
from sdh_sim.cell import Scene, Simulation, scene_of
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import Diverged, RecordError, RunError, SettingsError
from sdh_sim.metrics import snapshot_of
from sdh_sim.poses import rotation_of
from sdh_sim.records import NO_TRUTH
from sdh_sim.robot.palm_motion import minimum_jerk
from sdh_sim.sensing import TactileSnapshot
from sdh_sim.settings import TrialSettings
from sdh_sim.trial.lift import HOLD_TIME, LIFT_TIME
from sdh_sim.trial.outcome import Motion, classify, watch

FALL = 0.15  # by which the table recedes, the height of the lift [m]
CEILING = "MuJoCo from the snapshot"
BESIDE = ("q_whole_hand", "q_linf")


class Job(NamedTuple):
    """A trial to predict: its conditions, and its row of the table."""

    settings: TrialSettings
    row: Mapping[str, Any]


def predict_motion(job: Job) -> Motion:
    """How far the object moves in the hand when the table goes, from what was perceived.

    Returns:
        the motion; infinite where the simulation diverges.
    """
    snapshot = snapshot_of(job.row)
    assert snapshot is not None
    scene = scene_of(replace(job.settings, arm="none"))
    simulation = Simulation(scene)
    with _as_perceived(scene, job.row):
        set_to_snapshot(simulation, snapshot)
        try:
            return watch(simulation, snapshot.object_pose_hand, _receding(simulation))
        except Diverged:
            return Motion(np.inf, np.inf, True)
        finally:
            _put_table(scene, 0.0)


def set_to_snapshot(simulation: Simulation, snapshot: TactileSnapshot) -> None:
    """Bring hand, object and references where the snapshot has them; all is at rest."""
    scene, data = simulation.scene, simulation.data
    mujoco.mj_resetData(scene.model, data)
    palm = snapshot.hand_pose_world
    base = scene.palm_motion.reach(palm[:3], rotation_of(palm[3:]))
    assert base is not None  # a floating hand reaches all
    data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = base
    if snapshot.joints is None:
        scene.pose_hand(data, snapshot.joint_angles)
    else:
        data.qpos[scene.hand_qpos] = snapshot.joints
    at = slice(scene.object_qpos, scene.object_qpos + 7)
    data.qpos[at] = poses.compose(palm, snapshot.object_pose_hand)
    gains = scene.model.actuator_gainprm[scene.motors, 0]
    data.ctrl[scene.motors] = snapshot.joint_angles + snapshot.motor_torques / gains
    mujoco.mj_forward(scene.model, data)


def _receding(simulation: Simulation) -> Iterator[None]:
    """Let the table recede, tick by tick, and hold."""
    for k in range(1, round((LIFT_TIME + HOLD_TIME) / simulation.tick_time) + 1):
        share = minimum_jerk(k * simulation.tick_time / LIFT_TIME)
        _put_table(simulation.scene, -FALL * share)
        yield None


def _put_table(scene: Scene, height: float) -> None:
    """Move the table's top to a height [m] above its own place."""
    scene.model.body_pos[scene.model.geom_bodyid[scene.table], 2] = height


@contextlib.contextmanager
def _as_perceived(scene: Scene, row: Mapping[str, Any]) -> Iterator[None]:
    """Within the block the object has the mass and the friction that the hand assumes."""
    model, body = scene.model, scene.object_body
    mass, inertia = model.body_mass[body], model.body_inertia[body].copy()
    factor = row["perceived_mass_kg"] / scene.obj.mass_kg
    model.body_mass[body], model.body_inertia[body] = factor * mass, factor * inertia
    try:
        with Simulation(scene).friction_scaled(row["perceived_friction"] / scene.obj.friction):
            yield
    finally:
        model.body_mass[body], model.body_inertia[body] = mass, inertia


def scores_of(motions: list[Motion]) -> np.ndarray:
    """Scores (n,) above 1 where a grasp is predicted to hold, the higher the less it moves."""
    moved = np.array([max(m.displacement_mm, m.rotation_deg) for m in motions])
    return verdict_scores(np.array([classify(m) == "none" for m in motions]), moved)


def main(argv: list[str] | None = None) -> None:
    """Print the table."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder")
    parser.add_argument("--workers", type=int, help="processes (default: one per core)")
    args = parser.parse_args(argv)
    try:
        stored = read_runs([args.run])
        jobs = jobs_of(stored.plan.settings, stored.rows, stored.folders)
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    if not jobs:
        fail(f"{args.run} holds no trial with a snapshot")
    motions = run_all(predict_motion, jobs, "lifts", args.workers)
    success = np.array([job.row["success"] for job in jobs])
    found = {CEILING: compare_scores(scores_of(motions), success, metric=CEILING)}
    for metric in BESIDE:
        values = np.array([job.row[metric] for job in jobs], dtype=float)
        found[name_of(metric)] = compare_scores(values, success, metric=metric)
    Console(width=110).print(score_table(found))
    moved = np.array([m.displacement_mm for m in motions])[success]
    truth = np.array([job.row["displacement_mm"] for job in jobs], dtype=float)[success]
    print(
        f"of {success.sum()} grasps that held, the predicted displacement is off by "
        f"{np.median(np.abs(moved - truth)):.2f} mm in the median (they moved "
        f"{np.median(truth):.2f} mm)"
    )


def jobs_of(
    settings: TrialSettings, rows: list[dict[str, Any]], folders: Mapping[str, Any]
) -> list[Job]:
    """The trials with an outcome and a snapshot in which the hand touched the object."""
    of = functools.cache(
        lambda name: replace(settings, object=name, folder=folders.get(name), repeats=0)
    )
    return [
        Job(of(row["object"]), row)
        for row in rows
        if row["failure"] not in (*NO_TRUTH, "no_contact")
        and not row.get(SURPLUS)
        and snapshot_of(row) is not None
    ]


if __name__ == "__main__":
    main()
