"""Whole trials in both engines, from the open hand on: are snapshots, metrics and labels the same?

    python -m experiments.two_engines.snapshots RUN... [--trials 100]

The approach is left out: both engines start with the open hand around the object. The fingers
close, squeeze and rest under the trials' own finger control. Object, motors and taxels are then
compared with the snapshot of the trial, both snapshots are rated by the same metrics, and the
grasp that Drake made is lifted in Drake. Rows go to ``RUN/two_snapshots.csv`` as they are found.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from experiments.command_line import Parser, at_least, fail
from experiments.stored_runs import read_runs
from experiments.two_engines.drake import need_drake
from experiments.two_engines.table import RowTable
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cli.worker_pool import run_each
from sdh_sim.errors import Diverged, RecordError, RunError, SettingsError
from sdh_sim.records import NO_TRUTH
from sdh_sim.runs import Job

RATED = ("q_linf", "q_l1", "q_capability", "epsilon_linf")
SNAPSHOTS = RowTable(
    "two_snapshots.csv",
    {
        "trial": int, "object": str, "moved_mm": float, "turned_deg": float,
        "angles_off_rad": float, "torques_off_nm": float, "force_mujoco_n": float,
        "force_drake_n": float, "taxels_shared": float, "pads_shared": float,
        **{f"{name}_{engine}": float for name in RATED for engine in ("mujoco", "drake")},
        "failure_mujoco": str, "failure_drake": str,
        "displacement_mujoco_mm": float, "displacement_drake_mm": float,
    },
    ("trial",),
)  # fmt: skip
DIVERGED = "diverged"


def compare(task: tuple[Job, Mapping[str, Any]]) -> dict[str, Any]:
    """Close the hand in both engines, compare the snapshots, and lift in Drake.

    Args:
        task: the trial, and its row in the run's table.

    Returns:
        a row of ``SNAPSHOTS``: by how much the object ended elsewhere in the hand, the largest
        difference of a motor's position and torque, the sums of the normal forces on the object,
        the share of the taxels' force that both have at the same taxels and on the same pads (1:
        the same distribution), metrics of both snapshots from the pressures themselves, and what
        both lifts came to. Where Drake diverged its numbers are NaN.

    Raises:
        Diverged: MuJoCo did.
    """
    from experiments.two_engines.closing import close_in_drake, snapshot_in_drake
    from experiments.two_engines.outcomes import lift
    from sdh_sim.campaign.jobs import given_plan
    from sdh_sim.sensing import take_snapshot
    from sdh_sim.trial import Trial, classify
    from sdh_sim.trial.lift import LIFT_TIME
    from sdh_sim.trial.outcome import moved_between

    job, stored = task
    row = dict.fromkeys(SNAPSHOTS.columns, float("nan")) | {
        "trial": job.trial, "object": job.settings.object,
        "failure_mujoco": stored["failure"], "failure_drake": DIVERGED,
        "displacement_mujoco_mm": stored["displacement_mm"],
    }  # fmt: skip
    trial = Trial(job.settings, job.seed, **given_plan(job))
    trial.acquire()
    simulation, scene = trial.simulation, trial.scene
    try:
        found = close_in_drake(scene, trial.motion)
    except Diverged:
        return row
    ours, theirs = take_snapshot(simulation), snapshot_in_drake(found)
    row["moved_mm"], row["turned_deg"] = moved_between(
        ours.object_pose_hand, theirs.object_pose_hand, scene.obj.com_m
    )
    row["angles_off_rad"] = float(np.abs(theirs.joint_angles - ours.joint_angles).max())
    row["torques_off_nm"] = float(np.abs(theirs.motor_torques - ours.motor_torques).max())
    row["force_mujoco_n"] = sum(simulation.hand_force())
    row["force_drake_n"] = found.hand_force()
    row["taxels_shared"], row["pads_shared"] = shared(ours.tactile, theirs.tactile)
    for engine, snapshot in (("mujoco", ours), ("drake", theirs)):
        for name, value in _rated(trial, snapshot).items():
            row[f"{name}_{engine}"] = value
    try:
        motion = lift(found, scene.palm_motion.duration(trial.motion.lift, LIFT_TIME))
    except Diverged:
        return row
    row["failure_drake"] = classify(motion)
    row["displacement_drake_mm"] = motion.displacement_mm
    return row


def shared(ours: Mapping[str, np.ndarray], theirs: Mapping[str, np.ndarray]) -> tuple[float, float]:
    """Share of the readings that two snapshots have at the same taxels, and on the same pads."""
    pairs = [(ours[name], theirs[name]) for name in ours]  # by kind, pads × rows × columns
    taxels = np.concatenate([np.reshape(pair, (2, -1)) for pair in pairs], axis=1)
    # Taxels of a hand are all alike, so that readings add up as forces do.
    pads = np.concatenate([np.sum(pair, axis=(2, 3)) for pair in pairs], axis=1)
    total = taxels.sum(axis=1, keepdims=True)
    if not total.all():
        return float("nan"), float("nan")
    at_taxels, on_pads = (float((each / total).min(axis=0).sum()) for each in (taxels, pads))
    return at_taxels, on_pads


def _rated(trial: Any, snapshot: Any) -> dict[str, float]:
    from sdh_sim.metrics import predict
    from sdh_sim.robot import hand_kinematics

    scene, settings = trial.scene, trial.settings
    found = predict(
        snapshot, scene.obj, scene.torque_limit, settings.pads, hand_kinematics(scene.hand),
        settings.taxel_threshold,
    )  # fmt: skip
    return {name: found.values[name] for name in RATED}


def summary(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Lines with the distribution of every difference: median, and 10 and 90 % quantiles."""
    closed = [row for row in rows if row["moved_mm"] == row["moved_mm"]]
    columns = {
        "object elsewhere in the hand [mm]": [r["moved_mm"] for r in closed],
        "object turned [deg]": [r["turned_deg"] for r in closed],
        "largest difference of a motor's position [rad]": [r["angles_off_rad"] for r in closed],
        "largest difference of a motor's torque [N m]": [r["torques_off_nm"] for r in closed],
        "sum of normal forces, Drake over MuJoCo": [
            r["force_drake_n"] / r["force_mujoco_n"] for r in closed if r["force_mujoco_n"] > 0.0
        ],
        "share of the taxels' force at the same taxels": [r["taxels_shared"] for r in closed],
        "share of the taxels' force on the same pads": [r["pads_shared"] for r in closed],
    }
    for name in RATED:
        both = np.array([(r[f"{name}_mujoco"], r[f"{name}_drake"]) for r in closed])
        both = both[(both > 0.0).all(axis=1)]
        columns[f"{name}, Drake over MuJoCo ({len(both)} positive in both)"] = list(
            both[:, 1] / both[:, 0]
        )
    lines = [f"{len(rows)} grasps: median (10 to 90 %)"]
    for name, values in columns.items():
        if np.isfinite(values).any():
            low, middle, high = np.nanquantile(values, (0.1, 0.5, 0.9))
            lines.append(f"{name}: {middle:.3g} ({low:.3g} to {high:.3g})")
    for name in RATED[:2]:
        same = sum((r[f"{name}_mujoco"] > 1.0) == (r[f"{name}_drake"] > 1.0) for r in closed)
        lines.append(f"{name} on the same side of 1: {_percent(same, len(closed))}")
    same = sum((r["failure_mujoco"] == "none") == (r["failure_drake"] == "none") for r in rows)
    lines.append(f"closed and lifted in Drake, the same label: {_percent(same, len(rows))}")
    diverged = sum(r["failure_drake"] == DIVERGED for r in rows)
    return [*lines, f"diverged in Drake: {diverged}"] if diverged else lines


def _percent(k: int, n: int) -> str:
    return f"{Proportion(k, n).in_percent(1)} % of {n}"


def main(argv: list[str] | None = None) -> None:
    """Compute what is missing, and print the distributions."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, nargs="+", help="run folders of sdh-sim lift")
    parser.add_argument("--trials", type=int, default=100, help="new trials of a run at most [100]")
    parser.add_argument("--workers", type=int, default=0, help="processes (default: one per core)")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=0, workers=0)
    need_drake()
    found = []
    try:
        for run in args.run:
            jobs = _missing(run)[: args.trials]
            for row in run_each(compare, jobs, str(run), args.workers):
                SNAPSHOTS.append(run, [row])
            found += SNAPSHOTS.read(run)
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    for line in summary(found):
        print(line)


def _missing(run: Path) -> list[tuple[Job, Mapping[str, Any]]]:
    """Trials that the table lacks with their rows, of all objects in turn."""
    stored = read_runs([run])
    there = {row["trial"] for row in SNAPSHOTS.read(run)}
    by_object: dict[str, list[tuple[Job, Mapping[str, Any]]]] = {}
    for row in stored.rows:
        if row["failure"] not in (*NO_TRUTH, "no_contact") and row["trial"] not in there:
            task = stored.plan.job(row["trial"]), row
            by_object.setdefault(row["object"], []).append(task)
    return [task for turn in zip_longest(*by_object.values()) for task in turn if task]


if __name__ == "__main__":
    main()
