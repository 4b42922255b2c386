"""Metrics evaluated anew on the stored grasps of runs, and ranked: ``compare --metrics``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from sdh_sim.analysis.leaderboard import Entrant, Leaderboard, Outcomes, rank_all
from sdh_sim.analysis.study import stratified_folds
from sdh_sim.analysis.trial_tables import groups_of, surplus_of, without_truth
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import RunError
from sdh_sim.metrics import read_stored
from sdh_sim.metrics.field import ALL, chosen, of_function, refuse_twice
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.metrics.field_scores import (
    GraspScores,
    ScoreJob,
    grasp_in,
    metrics_of,
    score_grasp,
    score_job,
)
from sdh_sim.runs import OpenedRun, open_runs
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.user_references import ObjectFolder, UserMetric


@dataclass(frozen=True)
class RatedTrials:
    """Trials with an outcome, to be rated.

    Attributes:
        table, rows: of them.
        runs: which of the runs each is of.
    """

    table: pa.Table
    rows: tuple[dict[str, Any], ...]
    runs: tuple[OpenedRun, ...]

    @property
    def groups(self) -> dict[str, np.ndarray]:
        """Which trials belong to each object, and to all of them together."""
        return groups_of(self.table)


def trials_of(opened: Sequence[OpenedRun]) -> RatedTrials:
    """The trials of runs that have an outcome and are no surplus.

    Raises:
        RecordError: a table lacks what a snapshot consists of.
        RunError: there are none.
    """
    table, rows = read_stored([run.table for run in opened])
    usable = ~without_truth(table) & ~surplus_of(table)
    if not usable.any():
        raise RunError(f"{opened[0].given} holds no trial with an outcome yet")
    owners = [run for run in opened for _ in range(run.rows)]
    kept = np.flatnonzero(usable)
    return RatedTrials(
        table.filter(pa.array(usable)),
        tuple(rows[k] for k in kept),
        tuple(owners[k] for k in kept),
    )


def jobs_of(
    trials: RatedTrials,
    known: tuple[str, ...],
    own: tuple[UserMetric, ...],
    rows: Sequence[Mapping[str, Any] | None] | None = None,
) -> list[ScoreJob | None]:
    """What workers are to rate.

    Args:
        trials: the trials.
        known, own: the metrics.
        rows: of another moment of the same trials; None where there is none.
    """
    found: list[ScoreJob | None] = []
    for row, run in zip(trials.rows if rows is None else rows, trials.runs, strict=True):
        if row is None:
            found.append(None)
            continue
        pads, hand, hand_folder = "all", None, None
        folders: Mapping[str, ObjectFolder] = {}
        if run.plan is not None:
            settings, folders = run.plan.settings, run.plan.folders
            pads, hand, hand_folder = settings.pads, settings.hand, settings.hand_folder
        found.append(ScoreJob(row, pads, hand, hand_folder, folders, known, own))
    return found


def outcomes_of(trials: RatedTrials, scores: Sequence[GraspScores | None]) -> Outcomes:
    """What became of the trials; ``scores`` tell which of them a pad felt."""
    table, rows = trials.table, trials.rows
    loads = None
    if "q_sim" in table.column_names:
        loads = _floats(rows, "q_sim")
        if np.isnan(loads).all():
            loads = None
    return Outcomes(
        success=np.array([bool(row["success"]) for row in rows]),
        fold=stratified_folds(table),
        q_sim=loads,
        displacement_mm=_floats(rows, "displacement_mm"),
        sensed=np.array([s is not None and s.sensed for s in scores]),
    )


def _floats(rows: Sequence[Mapping[str, Any]], name: str) -> np.ndarray:
    return np.array([math.nan if row.get(name) is None else row[name] for row in rows], float)


def entrants_of(
    metrics: Sequence[FieldMetric], scores: Sequence[GraspScores | None]
) -> list[Entrant]:
    """The metrics with their values; the worst where a trial has no snapshot.

    Args:
        metrics: in the order of the scores.
        scores: of the trials.
    """
    worst = np.array([metric.worst for metric in metrics])
    values = np.array([worst if s is None else s.values for s in scores])
    none = np.full(len(metrics), np.nan)
    seconds = np.array([none if s is None else s.seconds for s in scores])
    faults: dict[str, str] = {}
    for found in scores:
        faults = {**(found.faults if found else {}), **faults}
    return [
        Entrant(
            *(metric.name, metric.label, metric.family, values[:, k]),
            high_is_good=metric.high_is_good,
            threshold=metric.threshold,
            cost_us=1e6 * _median(seconds[:, k]),
            fault=faults.get(metric.name, ""),
        )
        for k, metric in enumerate(metrics)
    ]


def _median(values: np.ndarray) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) else math.nan


def rate(
    jobs: Sequence[ScoreJob | None], title: str, workers: int | None
) -> list[GraspScores | None]:
    """The scores of the jobs, by worker processes."""
    wanted = [(k, job) for k, job in enumerate(jobs) if job is not None]
    found: list[GraspScores | None] = [None] * len(jobs)
    done = run_all(score_job, [job for _, job in wanted], title, workers)
    for (k, _), scores in zip(wanted, done, strict=True):
        found[k] = scores
    return found


def compare_field(
    opened: Sequence[OpenedRun], asked: Sequence[str], workers: int | None = None
) -> Leaderboard:
    """Evaluate the metrics asked for on the runs' grasps before the lift, and rank them.

    Args:
        opened: the runs.
        asked: as ``sdh_sim.metrics.field.chosen`` takes them.
        workers: processes; None: one per core.

    Raises:
        SettingsError: no such metric, or two of one name.
        RunError, RecordError: runs that cannot be rated.
    """
    known, own = chosen(asked)
    trials = trials_of(opened)
    scores = rate(jobs_of(trials, known, own), "metrics", workers)
    entrants = entrants_of(metrics_of(known, own), scores)
    return rank_all(entrants, outcomes_of(trials, scores), trials.groups)


def leaderboard(
    runs: Path | str | Sequence[Path | str],
    metrics: Sequence[str | Callable[[PerceivedGrasp], float]] = (ALL,),
    workers: int | None = None,
) -> Leaderboard:
    """Rank metrics on the trials of runs, each evaluated on the grasps before the lift.

    Args:
        runs: folders that ``lift`` made, or files of trials.
        metrics: ``"all"``, ``"field"``, names, users' metrics as ``"file.py:function"``; or
            functions of a perceived grasp, whose attributes ``threshold`` and ``high_is_good`` say
            what they mean. With functions everything is computed in this process.
        workers: processes; None: one per core.

    Returns:
        standings by object and overall, the best first.

    Raises:
        SettingsError: no such metric, or two of one name.
        RunError, RecordError: runs that cannot be rated.
    """
    given = [runs] if isinstance(runs, (str, Path)) else runs
    functions = [metric for metric in metrics if callable(metric)]
    named = [metric for metric in metrics if isinstance(metric, str)]
    with open_runs([Path(run) for run in given]) as opened:
        if not functions:
            return compare_field(opened, named, workers)
        known, own = chosen(named) if named else ((), ())
        every = (*metrics_of(known, own), *map(of_function, functions))
        refuse_twice(metric.name for metric in every if metric.family == "own")
        trials = trials_of(opened)
    grasps = [None if job is None else grasp_in(job) for job in jobs_of(trials, (), ())]
    scores = [None if grasp is None else score_grasp(grasp, every) for grasp in grasps]
    return rank_all(entrants_of(every, scores), outcomes_of(trials, scores), trials.groups)
