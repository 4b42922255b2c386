"""Settling against the lift: verdict, motion, load, metrics where the grasp settles, and CPU time.

    python -m experiments.settling RUN [--trials N] [--variants] [--sensitivity]

Every trial of RUN that has a snapshot is settled from its row alone. ``--variants`` adds settling
with half the increment, and with the contacts kept that the snapshot has. ``--sensitivity`` settles
again with one assumption wrong that settling shares with the simulation.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console

from experiments.command_line import Parser, at_least, fail
from experiments.perceived_lift import Job, jobs_of, scores_of
from experiments.score_table import score_table
from experiments.stored_runs import read_runs
from sdh_sim.analysis.comparison import Comparison, compare_scores, name_of
from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.metrics import evaluate, grasp_of
from sdh_sim.robot import HandKinematics, hand_in, hand_kinematics
from sdh_sim.sensing import PerceivedGrasp, add_tracking_error
from sdh_sim.settings import TrialSettings
from sdh_sim.settling import Allowed, Rubber, Settling, settle, settle_grasp
from sdh_sim.settling.process import STEP
from sdh_sim.trial.outcome import MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG, Motion

METRICS = ("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand")
ALLOWED = Allowed(MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG)


class Found(NamedTuple):
    """What settling says of one grasp.

    Attributes:
        motion: in the hand.
        load: at which it gives way [weights].
        metrics: where it settles, by column name; 0 where it does not.
        seconds: CPU time of all of that [s].
        variants: settled with half the increment, and with kept contacts; None: not asked for.
    """

    motion: Motion
    load: float
    metrics: dict[str, float]
    seconds: float
    variants: tuple[Settling, Settling] | None


def settle_job(job: Job, variants: bool) -> Found:
    """Settle the grasp of one row."""
    grasp, kinematics, rubber = known(job)
    start = time.process_time()
    found = settle_grasp(grasp, kinematics, rubber, ALLOWED, job.settings.pads)
    values: dict[str, float] = {metric: 0.0 for metric in METRICS}
    if found.held:
        values = evaluate(found.grasp)
    seconds = time.process_time() - start
    others = None
    if variants:
        finer = settle(grasp, kinematics, rubber, ALLOWED, step=STEP / 2)
        others = finer, settle(grasp, kinematics, rubber, ALLOWED, frozen=True)
    motion = _motion(found.displacement_mm, found.rotation_deg, found.held)
    return Found(motion, found.ramp.load, values, seconds, others)


def _friction(grasp: PerceivedGrasp, rng: np.random.Generator) -> PerceivedGrasp:
    factor = 1.0 + 0.1 * rng.standard_normal()
    return replace(grasp, obj=replace(grasp.obj, friction=factor * grasp.obj.friction))


def _mass(grasp: PerceivedGrasp, rng: np.random.Generator) -> PerceivedGrasp:
    factor = 1.0 + 0.1 * rng.standard_normal()
    return replace(grasp, obj=replace(grasp.obj, mass_kg=factor * grasp.obj.mass_kg))


def _torques(grasp: PerceivedGrasp, rng: np.random.Generator) -> PerceivedGrasp:
    torques = grasp.snapshot.motor_torques
    wrong = torques * (1.0 + 0.1 * rng.standard_normal(torques.shape))
    return replace(grasp, snapshot=replace(grasp.snapshot, motor_torques=wrong))


def _pose(grasp: PerceivedGrasp, rng: np.random.Generator) -> PerceivedGrasp:
    settings = TrialSettings("box", position_error=3e-3, angle_error=math.radians(2.0))
    snapshot, _ = add_tracking_error(grasp.snapshot, grasp.obj, settings, rng)
    return replace(grasp, snapshot=snapshot)


ERRORS: dict[str, Callable[[PerceivedGrasp, np.random.Generator], PerceivedGrasp]] = {
    "friction off by 10 %": _friction,
    "mass off by 10 %": _mass,
    "torques off by 10 %": _torques,
    "pose off by 3 mm and 2° per axis": _pose,
}
"""What may be assumed wrongly; shares are standard deviations, drawn from the trial's seed."""
RUBBERS = {"rubber twice as stiff": 2.0, "rubber half as stiff": 0.5}


def wrongly_assumed(jobs: list[Job]) -> dict[str, Comparison]:
    """The verdict with one assumption wrong at a time."""
    success = np.array([job.row["success"] for job in jobs])
    lines = {}
    for name in (*ERRORS, *RUBBERS):
        motions = []
        for job in jobs:
            grasp, kinematics, rubber = known(job)
            if name in ERRORS:
                grasp = ERRORS[name](grasp, np.random.default_rng(job.row["seed"]))
            rubber = rubber._replace(modulus=RUBBERS.get(name, 1.0) * rubber.modulus)
            way = settle(grasp, kinematics, rubber, ALLOWED)
            motions.append(_motion(way.displacement_mm, way.rotation_deg, way.held))
        lines[name] = compare_scores(scores_of(motions), success)
    return lines


def known(job: Job) -> tuple[PerceivedGrasp, HandKinematics, Rubber]:
    """What is known of the grasp of one row, its hand and the hand's rubber."""
    kinematics = hand_kinematics(hand_in(job.settings))
    folders = {job.settings.object: job.settings.folder} if job.settings.folder else None
    grasp = grasp_of(job.row, job.settings.pads, kinematics, folders)
    assert grasp is not None
    return grasp, kinematics, Rubber(job.settings.pad_modulus, job.settings.pad_thickness)


def _motion(displacement_mm: float, rotation_deg: float, held: bool) -> Motion:
    """A motion that is classified as settling did: what did not come to rest counts as fallen."""
    return Motion(displacement_mm, rotation_deg, not held)


def compare_all(jobs: list[Job], found: list[Found]) -> dict[str, Comparison]:
    """Settling and the metrics, before and where the grasp settles, against the outcomes."""
    success = np.array([job.row["success"] for job in jobs])
    lines = {"settling": compare_scores(scores_of([f.motion for f in found]), success)}
    loads = np.array([f.load for f in found])
    lines["q settled"] = compare_scores(loads, success)
    for metric in METRICS:
        before = np.array([job.row[metric] for job in jobs], dtype=float)
        after = np.array([f.metrics[metric] for f in found], dtype=float)
        lines[name_of(metric)] = compare_scores(before, success, metric=metric)
        lines[f"{name_of(metric)}, settled"] = compare_scores(after, success, metric=metric)
    kinds = ("half the increment", "kept contacts")
    for k, kind in enumerate(kinds if found[0].variants else ()):
        ways = [f.variants[k] for f in found if f.variants]
        motions = [_motion(way.displacement_mm, way.rotation_deg, way.held) for way in ways]
        lines[f"settling, {kind}"] = compare_scores(scores_of(motions), success)
    return lines


def notes(jobs: list[Job], found: list[Found]) -> list[str]:
    """Sentences on motion, load, time and increments."""
    held = [
        (job.row, f)
        for job, f in zip(jobs, found, strict=True)
        if job.row["success"] and not f.motion.fell
    ]
    lines = []
    if held:
        truth = np.array([row["displacement_mm"] for row, _ in held])
        moved = np.array([f.motion.displacement_mm for _, f in held])
        off, bias = np.median(np.abs(moved - truth)), np.median(moved - truth)
        lines.append(
            f"of {len(held)} held grasps, which moved {np.median(truth):.2f} mm, the predicted "
            f"motion is off by {off:.2f} mm in the median (with its sign {bias:+.2f} mm)"
        )
    ratios = [
        f.load / row["q_sim"] for row, f in held if row.get("q_sim") and not row["q_sim_capped"]
    ]
    if ratios:
        low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9))
        lines.append(f"q_settled/q_sim of held grasps: {middle:.2f} ({low:.2f} to {high:.2f})")
    both = [(f.motion, f.variants[0]) for _, f in held if f.variants and f.variants[0].held]
    if both:
        change = np.array([abs(m.displacement_mm - way.displacement_mm) for m, way in both])
        middle, most = 1e3 * np.quantile(change, (0.5, 0.9))
        lines.append(
            f"half the increment changes the motion of {len(both)} of them by {middle:.0f} µm in "
            f"the median, by less than {most:.0f} µm for nine in ten"
        )
    seconds = np.array([f.seconds for f in found])
    lines.append(
        f"CPU time of a grasp with its load ramp and metrics: mean {seconds.mean():.3f} s, "
        f"{np.quantile(seconds, 0.95):.3f} s for 19 in 20"
    )
    return lines


def main(argv: list[str] | None = None) -> None:
    """Print the table and the sentences."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder")
    parser.add_argument("--trials", type=int, default=0, help="at most so many (default: all)")
    parser.add_argument("--variants", action="store_true", help="finer and with kept contacts, too")
    parser.add_argument("--sensitivity", action="store_true", help="with wrong assumptions, too")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=0)
    try:
        stored = read_runs([args.run])
        jobs = jobs_of(stored.plan.settings, stored.rows, stored.folders)
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    jobs = jobs[: args.trials] if args.trials else jobs
    if not jobs:
        fail(f"{args.run} holds no trial with a snapshot")
    settle_job(jobs[0], False)  # compiles
    found = [settle_job(job, args.variants) for job in jobs]
    Console(width=110).print(score_table(compare_all(jobs, found)))
    if args.sensitivity:
        Console(width=110).print(score_table(wrongly_assumed(jobs)))
    for line in notes(jobs, found):
        print(line)


if __name__ == "__main__":
    main()
