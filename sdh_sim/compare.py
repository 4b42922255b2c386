"""Predicted against simulated success: what a threshold on q* gets right, and how well q* ranks.

A grasp is predicted to succeed when q* > 1, as section IV-B of the paper does. Trials that ended
as ``unstable_simulation`` have no truth to compare with: they are left out and counted. A trial
without q* (no pad had a reading, or no solution was found) counts as q* = 0, a predicted failure:
a predictor that sees nothing promises nothing, and leaving such trials out would flatter it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from sdh_sim import records
from sdh_sim.rate import Rate

METRICS = ("q_linf", "q_l1")
THRESHOLD = 1.0
RESAMPLES = 2000
_CHUNK = 2_000_000  # elements of one block of the bootstrap


@dataclass(frozen=True)
class Comparison:
    """One metric against the outcomes of one group of trials.

    Attributes:
        group: object name, or ``overall``.
        metric: column of the metric.
        threshold: success is predicted above it.
        tp, fp, tn, fn: trials predicted to succeed that did, did not; to fail that did, did not.
        auc: area under the ROC curve, None where one class is empty.
        auc_interval: its 95 % bootstrap interval, or None.
        missing: trials without the metric, counted as 0.
        unstable: trials left out because the simulation was unstable.
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
    missing: int
    unstable: int

    @property
    def n(self) -> int:
        """Trials compared."""
        return self.tp + self.fp + self.tn + self.fn

    @property
    def success(self) -> Rate:
        """Share of trials that succeeded."""
        return Rate(self.tp + self.fn, self.n)

    @property
    def accuracy(self) -> Rate:
        """Share of trials predicted rightly."""
        return Rate(self.tp + self.tn, self.n)

    @property
    def true_positive_rate(self) -> Rate:
        """Share of the successes that were predicted."""
        return Rate(self.tp, self.tp + self.fn)

    @property
    def false_positive_rate(self) -> Rate:
        """Share of the failures that were predicted to succeed."""
        return Rate(self.fp, self.fp + self.tn)


def auc(scores: np.ndarray, success: np.ndarray) -> float | None:
    """Area under the ROC curve: P(score of a success > of a failure) + P(equal) / 2.

    Args:
        scores: (n,) any real numbers, infinities included.
        success: (n,) bool.

    Returns:
        Mann-Whitney U over the number of pairs; None where one class is empty.
    """
    good, bad = scores[success], scores[~success]
    if not len(good) or not len(bad):
        return None
    return float(_placements(good, bad).mean())


def _placements(good: np.ndarray, bad: np.ndarray) -> np.ndarray:
    """For each success the share of failures below it, ties half; (number of successes,)."""
    order = np.sort(bad)
    below = np.searchsorted(order, good, side="left") + np.searchsorted(order, good, side="right")
    return below / (2 * len(bad))


def auc_interval(
    scores: np.ndarray,
    success: np.ndarray,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> tuple[float, float] | None:
    """95 % percentile bootstrap of the area under the curve, each class resampled by itself.

    None where a class has fewer than two members: resampling one grasp says nothing.
    """
    good, bad = scores[success], scores[~success]
    if len(good) < 2 or len(bad) < 2:
        return None
    # A resample is how often each grasp was drawn. With the failures sorted, the weight of those
    # below a success is one entry of a cumulative sum, so that no matrix of pairs is needed.
    order = np.sort(bad)
    left = np.searchsorted(order, good, side="left")
    right = np.searchsorted(order, good, side="right")
    areas: list[np.ndarray] = []
    block = max(1, _CHUNK // (len(good) + len(bad)))
    for start in range(0, resamples, block):
        rows = min(block, resamples - start)
        weights_bad = rng.multinomial(len(bad), np.full(len(bad), 1 / len(bad)), size=rows)
        weights_good = rng.multinomial(len(good), np.full(len(good), 1 / len(good)), size=rows)
        below = np.concatenate(
            [np.zeros((rows, 1), dtype=np.int64), np.cumsum(weights_bad, axis=1)], axis=1
        )
        wins = below[:, left] + below[:, right]
        areas.append((weights_good * wins).sum(axis=1) / (2 * len(good) * len(bad)))
    low, high = np.quantile(np.concatenate(areas), [0.025, 0.975])
    return float(low), float(high)


def compare_scores(
    scores: np.ndarray,
    success: np.ndarray,
    *,
    group: str = "overall",
    metric: str = "q_linf",
    threshold: float = THRESHOLD,
    unstable: int = 0,
) -> Comparison:
    """Compare one metric with the outcomes.

    Args:
        scores: (n,) the metric; NaN where a trial has none, counted as 0.
        success: (n,) bool, the outcomes.
        group, metric, threshold, unstable: see ``Comparison``.
    """
    success = np.asarray(success, dtype=bool)
    scores = np.asarray(scores, dtype=float)
    if scores.shape != success.shape or scores.ndim != 1:
        raise ValueError(f"scores {scores.shape} and success {success.shape} must be (n,) both")
    missing = np.isnan(scores)
    scores = np.where(missing, 0.0, scores)
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
        # A seed of its own: the same trials give the same interval, whatever else is compared.
        auc_interval=auc_interval(scores, success, np.random.default_rng(0)),
        missing=int(missing.sum()),
        unstable=unstable,
    )


def compare_table(table: pa.Table, metrics: Sequence[str] = METRICS) -> list[Comparison]:
    """Every object of a table of trials, in the order they appear, and ``overall`` at the end.

    ``overall`` is left out where there is one object only.
    """
    names = np.array(table.column("object").to_pylist(), dtype=object)
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    unstable = np.array(table.column("failure").to_pylist(), dtype=object) == "unstable_simulation"
    scores = {metric: records.stack(table, metric) for metric in metrics}
    groups = [(name, names == name) for name in dict.fromkeys(names)]
    if len(groups) != 1:
        groups.append(("overall", np.ones(len(names), dtype=bool)))
    return [
        compare_scores(
            scores[metric][members & ~unstable],
            success[members & ~unstable],
            group=group,
            metric=metric,
            unstable=int(np.sum(members & unstable)),
        )
        for group, members in groups
        for metric in metrics
    ]


def read_trials(paths: Sequence[Path]) -> pa.Table:
    """The columns that the comparison needs, of several tables one after the other."""
    columns = ("object", "success", "failure", *METRICS)
    return pa.concat_tables([records.read_table(path, columns) for path in paths])


CSV_HEADER = (
    *("object", "metric", "threshold", "n", "successes", "success_share"),
    *("accuracy", "accuracy_low", "accuracy_high"),
    *("true_positive_rate", "tpr_low", "tpr_high"),
    *("false_positive_rate", "fpr_low", "fpr_high"),
    *("auc", "auc_low", "auc_high"),
    *("tp", "fp", "tn", "fn", "missing_metric", "unstable_excluded"),
)


def csv_row(c: Comparison) -> list[str]:
    """The comparison as the cells of ``CSV_HEADER``; what is undefined is an empty cell."""
    rates = [c.accuracy, c.true_positive_rate, c.false_positive_rate]
    cells: list[object] = [c.group, c.metric, c.threshold, c.n, c.success.k, c.success.value]
    for rate in rates:
        cells += [rate.value, *(rate.interval or (None, None))]
    cells += [c.auc, *(c.auc_interval or (None, None))]
    cells += [c.tp, c.fp, c.tn, c.fn, c.missing, c.unstable]
    return ["" if cell is None else str(cell) for cell in cells]
