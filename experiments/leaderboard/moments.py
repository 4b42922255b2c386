"""The grasps of some trials at the moments that metrics can be asked at."""

from __future__ import annotations

from typing import Any

import numpy as np

from sdh_sim.analysis.leaderboard import Entrant
from sdh_sim.cli.field_comparison import RatedTrials, jobs_of, rate
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.metrics.field_scores import (
    GraspScores,
    ScoreJob,
    grasp_in,
    metrics_of,
    score_grasp,
)
from sdh_sim.metrics.stored_grasps import at_lift_off
from sdh_sim.settings import TrialSettings
from sdh_sim.settling import Allowed, Rubber, settle_grasp
from sdh_sim.trial.outcome import MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG
from sdh_sim.user_references import UserMetric

BEFORE, LIFT_OFF, SETTLED = "before the lift", "at lift-off", "where it settles"
_ALLOWED = Allowed(MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG)


def moments_of(trials: RatedTrials) -> list[str]:
    """The moments that the runs looked at, in order."""
    there = set(trials.table.column_names)
    found = [BEFORE]
    if "liftoff_object_pose_hand" in there:
        found.append(LIFT_OFF)
    return [*found, SETTLED] if "settled" in there else found


def scores_at(
    moment: str,
    trials: RatedTrials,
    known: tuple[str, ...],
    own: tuple[UserMetric, ...],
    workers: int | None,
) -> list[GraspScores | None]:
    """Every metric of every trial's grasp at a moment.

    None where there is no snapshot. A grasp that does not settle has every metric's worst value.

    Args:
        moment: one of ``moments_of``.
        trials: the trials.
        known, own: the metrics.
        workers: processes; None: one per core.
    """
    rows: list[dict[str, Any] | None] = list(trials.rows)
    if moment == LIFT_OFF:
        rows = [at_lift_off(row) for row in trials.rows]
    jobs = jobs_of(trials, known, own, rows)
    if moment != SETTLED:
        return rate(jobs, f"metrics {moment}", workers)
    wanted = [(k, (job, _rubber(trials, k))) for k, job in enumerate(jobs) if job is not None]
    done = run_all(settled_scores, [job for _, job in wanted], f"metrics {moment}", workers)
    found: list[GraspScores | None] = [None] * len(jobs)
    for (k, _), scores in zip(wanted, done, strict=True):
        found[k] = scores
    return found


def _rubber(trials: RatedTrials, number: int) -> Rubber:
    plan = trials.runs[number].plan
    settings = TrialSettings if plan is None else plan.settings
    return Rubber(settings.pad_modulus, settings.pad_thickness)


def settled_scores(job: tuple[ScoreJob, Rubber]) -> GraspScores | None:
    """Metrics where a stored grasp settles; None where the trial ended before its snapshot."""
    asked, rubber = job
    grasp = grasp_in(asked)
    if grasp is None:
        return None
    metrics = metrics_of(asked.known, asked.own)
    if not grasp.contacts and not grasp.others:
        return score_grasp(grasp, metrics)
    assert grasp.kinematics is not None  # perceive puts it there
    settled = settle_grasp(grasp, grasp.kinematics, rubber, _ALLOWED, asked.pads)
    if settled.held:
        return score_grasp(settled.grasp, metrics)
    worst = np.array([metric.worst for metric in metrics])
    return GraspScores(worst, np.full(len(metrics), np.nan), {}, False)


def of_settling(trials: RatedTrials) -> Entrant | None:
    """The load that settling predicts, stored with the trials; None where it is not."""
    if "q_settled" not in trials.table.column_names:
        return None
    values = [row.get("q_settled") for row in trials.rows]
    loads = np.array([0.0 if v is None else v for v in values], dtype=float)
    return Entrant("q_settled", "q settling", "settling", loads, threshold=1.0)
