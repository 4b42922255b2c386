"""Predicted against simulated success: confusion matrix at a threshold, area under the ROC curve.

A grasp is predicted to succeed when q* > 1, as in section IV-B of the paper. Trials that ended
as ``infeasible``, ``unstable_simulation`` or ``error`` have no outcome to compare with: they are
left out and counted. A trial without q* (no pad had a reading, or no solution was found) counts as
q* = 0, a predicted failure; leaving such trials out would make the metric look better than it is.

A hand that never touches the object (``no_contact``) has q* = 0 and fails: every metric predicts
that, and many such trials make all of them look good. So they are counted apart, and the accuracy
is given without them, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.roc_area import auc, auc_interval
from sdh_sim.analysis.trial_tables import (
    COMPARED,
    groups_of,
    infeasible_of,
    without_surplus,
    without_truth,
)
from sdh_sim.records import LIFT_OFF, METRIC, SETTLED, is_metric, stack

METRICS = COMPARED
ALL_METRICS = (
    *METRICS,
    *("q_capability", "q_held", "q_whole_hand", "q_settled"),
    *("epsilon_linf", "epsilon_l1", "volume_linf", "volume_l1"),
)
NAMES = {
    "q_linf": "q* L∞",
    "q_l1": "q* L1",
    "q_capability": "q* capability",
    "q_held": "q* held",
    "q_whole_hand": "q* whole hand",
    "q_settled": "q settling",
    "epsilon_linf": "ε L∞",
    "epsilon_l1": "ε L1",
    "volume_linf": "V L∞",
    "volume_l1": "V L1",
}
THRESHOLD = 1.0
CARRIED = 0.05  # of accuracy that trials without contact may add before a warning says so


def name_of(metric: str) -> str:
    """What a metric is called in tables: a user's by the name that the user gave it."""
    for prefix, moment in ((LIFT_OFF, "lift-off"), (SETTLED, "settled")):
        if metric.startswith(prefix):
            return f"{name_of(metric.removeprefix(prefix))}, {moment}"
    return NAMES.get(metric) or metric.removeprefix(METRIC)


@dataclass(frozen=True)
class Comparison:
    """One metric against the outcomes of one group of trials.

    Attributes:
        group: object name, or ``overall``.
        metric: column of the metric.
        threshold: success is predicted above it; NaN where a user's metric states none.
        tp, fp: trials predicted to succeed that did; that did not.
        tn, fn: trials predicted to fail that did; that succeeded.
        auc: area under the ROC curve, None where one class is empty.
        auc_interval: its 95 % score interval, None where ``auc`` is.
        no_contact: trials among them in which the hand did not touch the object.
        no_contact_right: those of them that were predicted to fail.
        missing: trials without the metric; see ``drops_missing`` for what becomes of them.
        unstable: trials left out because the simulation was unstable or broke off.
        infeasible: trials left out because the given grasp could not be tried.
    """

    group: str
    metric: str
    threshold: float
    tp: int
    fp: int
    tn: int
    fn: int
    auc: float | None
    auc_interval: tuple[float, float] | None
    no_contact: int
    no_contact_right: int
    missing: int
    unstable: int
    infeasible: int

    @property
    def n(self) -> int:
        """Trials compared."""
        return self.tp + self.fp + self.tn + self.fn

    @property
    def success(self) -> Proportion:
        """Share of trials that succeeded."""
        return Proportion(self.tp + self.fn, self.n)

    @property
    def accuracy(self) -> Proportion:
        """Share of trials predicted correctly."""
        return Proportion(self.tp + self.tn, self.n)

    def area(self, digits: int = 2) -> str:
        """Area under the ROC curve with its interval, as in "0.86 (0.80–0.91)"; a dash for none."""
        if self.auc is None:
            return "-"
        if self.auc_interval is None:
            return f"{self.auc:.{digits}f}"
        low, high = self.auc_interval
        return f"{self.auc:.{digits}f} ({low:.{digits}f}–{high:.{digits}f})"

    @property
    def accuracy_touching(self) -> Proportion:
        """Share predicted correctly of the trials in which the hand touched the object."""
        right = self.tp + self.tn - self.no_contact_right
        return Proportion(right, self.n - self.no_contact)

    @property
    def carried(self) -> bool:
        """Whether trials without contact make the accuracy look much better than it is."""
        with_them, without = self.accuracy.value, self.accuracy_touching.value
        if not self.no_contact or with_them is None:
            return False
        return without is None or with_them - without > CARRIED

    @property
    def true_positive_rate(self) -> Proportion:
        """Share of the successes that were predicted."""
        return Proportion(self.tp, self.tp + self.fn)

    @property
    def false_positive_rate(self) -> Proportion:
        """Share of the failures that were predicted to succeed."""
        return Proportion(self.fp, self.fp + self.tn)

    @property
    def true_negative_rate(self) -> Proportion:
        """Share of the failures that were predicted to fail."""
        return Proportion(self.tn, self.fp + self.tn)

    @property
    def has_boundary(self) -> bool:
        """Whether success is predicted above the threshold.

        It is for q*, a number of weights, and for a user's metric that states a threshold. ε and
        V have units: no value of theirs is known to divide grasps that hold from those that do not.
        """
        if is_metric(self.metric):
            return not math.isnan(self.threshold)
        return self.metric.startswith("q_")


def compare_scores(
    scores: np.ndarray,
    success: np.ndarray,
    *,
    group: str = "overall",
    metric: str = "q_linf",
    threshold: float = THRESHOLD,
    no_contact: np.ndarray | None = None,
    unstable: int = 0,
    infeasible: int = 0,
    drop_missing: bool = False,
) -> Comparison:
    """Compare one metric with the outcomes.

    Args:
        scores: (n,) the metric; NaN where a trial has none, counted as 0.
        success: (n,) bool, the outcomes.
        group, metric, threshold, unstable, infeasible: see ``Comparison``.
        no_contact: (n,) bool, trials in which the hand did not touch the object; None: none.
        drop_missing: leave trials without the metric out instead.
    """
    success = np.asarray(success, dtype=bool)
    scores = np.asarray(scores, dtype=float)
    if scores.shape != success.shape or scores.ndim != 1:
        raise ValueError(f"scores {scores.shape} and success {success.shape} must be (n,) both")
    apart = np.zeros(len(success), dtype=bool) if no_contact is None else np.asarray(no_contact)
    missing = np.isnan(scores)
    if drop_missing:
        scores, success, apart = scores[~missing], success[~missing], apart[~missing]
    scores = np.nan_to_num(scores, nan=0.0, posinf=np.inf, neginf=-np.inf)
    predicted = scores > threshold
    return Comparison(
        group=group,
        metric=metric,
        threshold=threshold,
        tp=int(np.sum(predicted & success)),
        fp=int(np.sum(predicted & ~success)),
        tn=int(np.sum(~predicted & ~success)),
        fn=int(np.sum(~predicted & success)),
        auc=auc(scores, success),
        auc_interval=auc_interval(scores, success),
        no_contact=int(apart.sum()),
        no_contact_right=int(np.sum(apart & ~predicted & ~success)),
        missing=int(missing.sum()),
        unstable=unstable,
        infeasible=infeasible,
    )


def drops_missing(metric: str) -> bool:
    """Whether trials without the metric are left out, rather than counted as 0.

    V is left out, as it is not computed for many contacts, and so is a user's metric, which may
    have failed.
    """
    return metric.startswith("volume_") or is_metric(metric)


def compare_table(
    table: pa.Table,
    metrics: Sequence[str] = METRICS,
    thresholds: Mapping[str, float] | None = None,
) -> list[Comparison]:
    """Every group of a table of trials (see ``groups_of``), every metric within it.

    Trials beyond their share of a preset are left out.

    Args:
        table: of trials.
        metrics: columns.
        thresholds: of users' metrics that state one, by column.
    """
    above = dict.fromkeys(metrics, THRESHOLD)
    above |= {m: (thresholds or {}).get(m, math.nan) for m in metrics if is_metric(m)}
    table = without_surplus(table)
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    left_out, infeasible = without_truth(table), infeasible_of(table)
    no_contact = np.array([f == "no_contact" for f in table.column("failure").to_pylist()], bool)
    scores = {metric: stack(table, metric) for metric in metrics}
    return [
        compare_scores(
            scores[metric][members & ~left_out],
            success[members & ~left_out],
            group=group,
            metric=metric,
            threshold=above[metric],
            no_contact=no_contact[members & ~left_out],
            unstable=int(np.sum(members & left_out & ~infeasible)),
            infeasible=int(np.sum(members & infeasible)),
            drop_missing=drops_missing(metric),
        )
        for group, members in groups_of(table).items()
        for metric in metrics
    ]


CSV_HEADER = (
    *("object", "metric", "threshold", "n", "successes", "success_share"),
    *("accuracy", "accuracy_low", "accuracy_high"),
    *("true_positive_rate", "tpr_low", "tpr_high"),
    *("false_positive_rate", "fpr_low", "fpr_high"),
    *("true_negative_rate", "tnr_low", "tnr_high"),
    *("auc", "auc_low", "auc_high"),
    *("tp", "fp", "tn", "fn", "missing_metric", "unstable_excluded"),
    *("no_contact", "accuracy_touching", "accuracy_touching_low", "accuracy_touching_high"),
    "infeasible_excluded",
)


def csv_values(c: Comparison) -> list[object]:
    """The comparison in the order of ``CSV_HEADER``; what is undefined is None."""
    threshold = c.threshold if c.has_boundary else None
    found: list[object] = [c.group, c.metric, threshold, c.n, c.success.k, c.success.value]
    rates = (c.accuracy, c.true_positive_rate, c.false_positive_rate, c.true_negative_rate)
    for rate in rates if c.has_boundary else (Proportion(0, 0),) * len(rates):
        found += [rate.value, *(rate.interval or (None, None))]
    found += [c.auc, *(c.auc_interval or (None, None))]
    found += [c.tp, c.fp, c.tn, c.fn] if c.has_boundary else [None] * 4
    touching = c.accuracy_touching if c.has_boundary else Proportion(0, 0)
    found += [c.missing, c.unstable, c.no_contact]
    return [*found, touching.value, *(touching.interval or (None, None)), c.infeasible]


def csv_row(c: Comparison) -> list[str]:
    """The values as text; what is undefined is empty."""
    return ["" if value is None else str(value) for value in csv_values(c)]
