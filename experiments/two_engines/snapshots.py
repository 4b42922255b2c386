"""Whole grasps in both engines, from the open hand on: are the snapshots the same?

    python -m experiments.two_engines.snapshots RUN [--trials 40]

The approach is left out: both engines start with the open hand around the object. The fingers
close, squeeze and rest under the trials' own finger control. Object, motors and taxels are then
compared with the snapshot of the trial, grasp by grasp. Rows go to ``RUN/two_snapshots.csv``.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from experiments.command_line import Parser, at_least, fail
from experiments.stored_runs import read_runs
from sdh_sim.errors import Diverged, RecordError, RunError, SettingsError
from sdh_sim.records import NO_TRUTH
from sdh_sim.runs import Job

NAME = "two_snapshots.csv"
COLUMNS = (
    "trial", "object", "moved_mm", "turned_deg", "angles_off_rad", "torques_off_nm",
    "force_mujoco_n", "force_drake_n", "taxels_shared",
)  # fmt: skip


def compare(job: Job) -> dict[str, Any]:
    """Close the hand in both engines.

    Returns:
        by how much the object ended elsewhere in the hand, the largest difference of a motor's
        position and torque, the sums of the normal forces on the object, and the share of the
        taxels' force that both have at the same taxels (1: the same distribution).

    Raises:
        Diverged: one of the engines did.
    """
    from experiments.two_engines.closing import close_in_drake, taxel_forces_in_drake
    from sdh_sim.campaign.jobs import given_plan
    from sdh_sim.cell.contacts import taxel_forces
    from sdh_sim.trial import Trial
    from sdh_sim.trial.outcome import moved_between

    trial = Trial(job.settings, job.seed, **given_plan(job))
    found = close_in_drake(trial.scene, trial.motion)
    trial.acquire()
    simulation, scene = trial.simulation, trial.scene
    moved, turned = moved_between(
        simulation.object_in_hand(), found.object_in_hand(), scene.obj.com_m
    )
    ours, theirs = taxel_forces(scene, simulation.data), taxel_forces_in_drake(found)
    sums = float(ours.sum()), float(theirs.sum())
    shared = np.nan
    if min(sums) > 0.0:
        shared = float(np.minimum(ours / sums[0], theirs / sums[1]).sum())
    angles = found.motor_positions() - scene.motor_positions(simulation.data)
    torques = found.motor_torques() - simulation.data.actuator_force[scene.motors]
    return {
        "trial": job.trial, "object": job.settings.object, "moved_mm": moved,
        "turned_deg": turned, "angles_off_rad": float(np.abs(angles).max()),
        "torques_off_nm": float(np.abs(torques).max()),
        "force_mujoco_n": sum(simulation.hand_force()), "force_drake_n": found.hand_force(),
        "taxels_shared": shared,
    }  # fmt: skip


def summary(rows: list[Mapping[str, Any]]) -> list[str]:
    """Lines with the distribution of every difference: median, and 10 and 90 % quantiles."""
    ratios = [float(r["force_drake_n"]) / float(r["force_mujoco_n"]) for r in rows]
    columns = {
        "object elsewhere in the hand [mm]": [float(r["moved_mm"]) for r in rows],
        "object turned [deg]": [float(r["turned_deg"]) for r in rows],
        "largest difference of a motor's position [rad]": [
            float(r["angles_off_rad"]) for r in rows
        ],
        "largest difference of a motor's torque [N m]": [float(r["torques_off_nm"]) for r in rows],
        "sum of normal forces, Drake over MuJoCo": ratios,
        "share of the taxels' force at the same taxels": [float(r["taxels_shared"]) for r in rows],
    }
    lines = [f"{len(rows)} grasps: median (10 to 90 %)"]
    for name, values in columns.items():
        low, middle, high = np.nanquantile(values, (0.1, 0.5, 0.9))
        lines.append(f"{name}: {middle:.3g} ({low:.3g} to {high:.3g})")
    return lines


def main(argv: list[str] | None = None) -> None:
    """Compute what is missing, and print the distributions."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder of sdh-sim lift")
    parser.add_argument("--trials", type=int, default=40, help="new trials at most [40]")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=0)
    if find_spec("pydrake") is None:
        fail('the second engine, Drake, is not installed: pip install -e ".[crosscheck]"')
    try:
        stored = read_runs([args.run])
        plan = stored.plan
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    path = args.run / NAME
    there = {int(row["trial"]) for row in _read(path)}
    rows = [r for r in stored.rows if r["failure"] not in (*NO_TRUTH, "no_contact")]
    waiting = [r["trial"] for r in rows if r["trial"] not in there]
    every = max(1, len(waiting) // max(1, args.trials))  # spread over the objects
    for number in waiting[::every][: args.trials]:
        try:
            _append(path, compare(plan.job(number)))
        except Diverged:
            print(f"trial {number}: an engine diverged")
    for line in summary(_read(path)):
        print(line)


def _read(path: Path) -> list[Mapping[str, Any]]:
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["taxels_shared"] is not None]


def _append(path: Path, row: Mapping[str, Any]) -> None:
    new = not path.exists()
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if new:
            writer.writerow(COLUMNS)
        writer.writerow([row[name] for name in COLUMNS])


if __name__ == "__main__":
    main()
