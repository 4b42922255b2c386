"""All statistics of some trials: the numbers behind every figure and table of the report."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa

from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis import trial_tables
from sdh_sim.analysis.cases import ASIDE, Case, cases_of
from sdh_sim.analysis.comparison import METRICS, THRESHOLD, Comparison
from sdh_sim.analysis.curves import Curve, precision_recall, roc
from sdh_sim.analysis.load_agreement import (
    Agreement,
    Nearest,
    agree,
    find_nearest,
    load_ratios,
)
from sdh_sim.analysis.moments import (
    MOMENT_COLUMNS,
    MOMENT_METRICS,
    TwoMoments,
    compare_moments,
)
from sdh_sim.analysis.paired_metrics import Paired, compare_pair
from sdh_sim.analysis.resampling import RESAMPLES
from sdh_sim.analysis.thresholds import (
    Calibration,
    CrossValidated,
    assign_folds,
    calibrate,
    cross_validate,
)
from sdh_sim.records import columns_of, stack

LOAD = ("q_sim", "q_sim_capped")
EVERY, SEEN, HELD, LOST = "all", "no unseen contact", "held", "not held"
"""Subsets of the load test's trials: the last two by the outcome of the lift."""


@dataclass(frozen=True)
class Scored:
    """One metric and the outcomes of one group of trials.

    Attributes:
        scores: (n,) without NaN.
        success: (n,) bool.
        fold: (n,) fold of each trial.
    """

    scores: np.ndarray
    success: np.ndarray
    fold: np.ndarray

    @property
    def two_sided(self) -> bool:
        """Whether both outcomes occur at least twice, without which no threshold is chosen."""
        return bool(self.success.sum() >= 2 and (~self.success).sum() >= 2)


@dataclass(frozen=True)
class Finding:
    """The statistics of one metric on one group of trials.

    Attributes:
        comparison: confusion matrix at the metric's threshold, area under the ROC curve.
        scored: the scores and outcomes of the trials.
        roc, precision_recall: None where an outcome is too rare.
        best: threshold chosen by cross-validation, or None.
        calibration: threshold against desired false positive rate, or None.
    """

    comparison: Comparison
    scored: Scored
    roc: Curve | None
    precision_recall: Curve | None
    best: CrossValidated | None
    calibration: Calibration | None


class LoadTested(NamedTuple):
    """One metric on the trials that were load-tested.

    Attributes:
        q: (n,) the metric [weights].
        q_sim: (n,) load held [weights].
        capped: (n,) bool, whether the grasp still held at the largest load tried.
        unsensed: (n,) bool, whether a contact bore force that no pad measured.
    """

    q: np.ndarray
    q_sim: np.ndarray
    capped: np.ndarray
    unsensed: np.ndarray


@dataclass(frozen=True)
class Study:
    """The statistics of the trials of one or several runs.

    Attributes:
        metrics: columns compared.
        groups: object names in order, ``overall`` last where there is more than one object.
        findings: by group and metric.
        paired: L-infinity against L1 at threshold 1, by group.
        agreement: q* against q_sim by group, metric and subset; empty without load tests.
        load: the trials that were load-tested, by metric; empty without load tests.
        nearest: the metric whose median of q*/q_sim is nearest to 1; None without load tests.
        moments: every q* before the lift and at later moments; empty where none was looked at.
        surplus: number of trials left out because they exceed their object's share in a preset.
        read: number of trials read, those left out included.
        compared: number of trials with an outcome that are no surplus; a metric that lacks values
            is compared on fewer.
        cases: every trial but the surplus; empty where the table does not say which they are.
    """

    metrics: tuple[str, ...]
    groups: tuple[str, ...]
    findings: dict[tuple[str, str], Finding]
    paired: dict[str, Paired]
    agreement: dict[tuple[str, str, str], Agreement]
    load: dict[str, LoadTested]
    nearest: Nearest | None
    moments: tuple[TwoMoments, ...]
    surplus: int
    read: int
    compared: int
    cases: tuple[Case, ...] = ()

    @property
    def main(self) -> str:
        """The group of all trials."""
        return self.groups[-1]

    @property
    def scalings(self) -> list[str]:
        """The metrics with the decision boundary 1: the task scalings."""
        return [m for m in self.metrics if m.startswith("q_")]

    @property
    def comparisons(self) -> list[Comparison]:
        """Every comparison, group by group."""
        return [self.findings[g, m].comparison for g in self.groups for m in self.metrics]


def read_study(
    paths: Sequence[Path],
    metrics: Sequence[str] = METRICS,
    resamples: int = RESAMPLES,
    by_hand: bool = False,
) -> Study:
    """The study of the trials in some files.

    Metrics that one of the files lacks are left out; users' metrics that all of them have are
    added at the end. ``by_hand`` is as in ``trial_tables.read_trials``.

    Raises:
        RecordError: a file is no table of trials, or they are of several hands unasked.
    """
    own = trial_tables.user_metrics(paths)
    later = columns_of(paths, MOMENT_COLUMNS)
    before = columns_of(paths, MOMENT_METRICS) if later else ()
    extra = columns_of(paths, (*metrics, *own, *LOAD, "unsensed_contact"))
    extra = tuple(dict.fromkeys((*extra, *before, *later)))
    extra = (*extra, *columns_of(paths, ASIDE))
    table = trial_tables.read_trials(paths, extra, by_hand)
    wanted = tuple(m for m in (*metrics, *own) if m in table.column_names)
    thresholds = {name: value for name, value in own.items() if value is not None}
    return study_of(table, wanted, resamples, thresholds)


def study_of(
    table: pa.Table,
    metrics: Sequence[str] = METRICS,
    resamples: int = RESAMPLES,
    thresholds: Mapping[str, float] | None = None,
) -> Study:
    """The study of one table that has the columns ``read_trials`` asks for.

    The same trials give the same numbers, whatever else is compared: every bootstrap and every
    division into folds starts from a fixed seed.
    """
    read = table.num_rows
    table = trial_tables.without_surplus(table)
    groups = trial_tables.groups_of(table)
    compared = compare.compare_table(table, metrics, thresholds)
    comparisons = {(c.group, c.metric): c for c in compared}
    usable = ~trial_tables.without_truth(table)
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    fold = np.full(len(success), -1)
    fold[usable] = stratified_folds(table.filter(pa.array(usable)))
    columns = {metric: stack(table, metric) for metric in metrics}
    findings, paired = {}, {}
    for group, members in groups.items():
        for metric in metrics:
            keep = members & usable
            if compare.drops_missing(metric):
                keep = keep & ~np.isnan(columns[metric])
            scored = Scored(_filled(columns[metric])[keep], success[keep], fold[keep])
            findings[group, metric] = _finding(comparisons[group, metric], scored, resamples)
        first, second = (findings[group, m].scored for m in METRICS)
        paired[group] = compare_pair(first.scores, second.scores, first.success, THRESHOLD)
    agreement, load = _load(table, groups, metrics, columns, usable, resamples)
    ratios = {m: load_ratios(t.q, t.q_sim, t.capped) for m, t in load.items()}
    return Study(
        metrics=tuple(metrics),
        groups=tuple(groups),
        findings=findings,
        paired=paired,
        agreement=agreement,
        load=load,
        nearest=find_nearest(ratios, seeded("nearest"), resamples),
        moments=compare_moments(table, usable),
        surplus=read - table.num_rows,
        read=read,
        compared=int(usable.sum()),
        cases=cases_of(table, metrics),
    )


def _finding(comparison: Comparison, scored: Scored, resamples: int) -> Finding:
    scores, success, fold = scored.scores, scored.success, scored.fold
    return Finding(
        comparison=comparison,
        scored=scored,
        roc=roc(scores, success, np.random.default_rng(0), resamples),
        precision_recall=precision_recall(scores, success, np.random.default_rng(0), resamples),
        best=cross_validate(scores, success, fold) if scored.two_sided else None,
        calibration=calibrate(scores, success, fold, seeded("calibration"), resamples),
    )


def _load(
    table: pa.Table,
    groups: dict[str, np.ndarray],
    metrics: Sequence[str],
    columns: dict[str, np.ndarray],
    usable: np.ndarray,
    resamples: int,
) -> tuple[dict, dict]:
    if not all(name in table.column_names for name in LOAD):
        return {}, {}
    q_sim = stack(table, "q_sim")
    capped = _flags(table.column("q_sim_capped"))
    unsensed = np.zeros(len(q_sim), dtype=bool)
    if "unsensed_contact" in table.column_names:
        unsensed = _flags(table.column("unsensed_contact"))
    success = _flags(table.column("success"))
    tested = usable & ~np.isnan(q_sim)
    if not tested.any():
        return {}, {}
    agreement, load = {}, {}
    for metric in (m for m in metrics if m.startswith("q_")):
        q = _filled(columns[metric])
        load[metric] = LoadTested(q[tested], q_sim[tested], capped[tested], unsensed[tested])
        for group, members in groups.items():
            for subset, part in (
                *((EVERY, tested), (SEEN, tested & ~unsensed)),
                *((HELD, tested & success), (LOST, tested & ~success)),
            ):
                keep = members & part
                agreement[group, metric, subset] = agree(
                    q[keep], q_sim[keep], capped[keep], seeded("agreement"), resamples
                )
    return agreement, load


def stratified_folds(table: pa.Table) -> np.ndarray:
    """Fold of every trial (n,), stratified by object and outcome; the same for every metric."""
    names, success = table.column("object").to_pylist(), table.column("success").to_pylist()
    strata = np.array([f"{n} {s}" for n, s in zip(names, success, strict=True)], dtype=object)
    return assign_folds(strata, seeded("folds"))


def seeded(purpose: str) -> np.random.Generator:
    """A random generator whose seed is made of the purpose's name."""
    return np.random.default_rng(zlib.crc32(purpose.encode()))


def _filled(scores: np.ndarray) -> np.ndarray:
    return np.where(np.isnan(scores), 0.0, scores)


def _flags(column: pa.ChunkedArray) -> np.ndarray:
    return np.array([bool(value) for value in column.to_pylist()], dtype=bool)
