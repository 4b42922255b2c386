"""Receiver operating characteristic and precision-recall curves with their bootstrap bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdh_sim.analysis.proportion import wilson_interval
from sdh_sim.analysis.resampling import RESAMPLES, Interval, RankedScores, stratified_weights
from sdh_sim.analysis.roc_area import FEWEST, auc_interval

GRID = np.linspace(0.0, 1.0, 101)
GRID.setflags(write=False)


@dataclass(frozen=True)
class Curve:
    """A curve over all thresholds.

    Attributes:
        thresholds: (m,) falling; success is predicted for scores of at least this much; of
            the ROC curve the first is +inf, where no trial is predicted to succeed.
        x, y: (m,) the curve at each threshold.
        band: lower and upper end, (101,) each, of the 95 % bootstrap band of y at the x of
            ``GRID``; None with fewer than ten of an outcome, where it would promise too much.
        area: area under it.
        area_interval: its 95 % interval.
    """

    thresholds: np.ndarray
    x: np.ndarray
    y: np.ndarray
    band: tuple[np.ndarray, np.ndarray] | None
    area: float
    area_interval: Interval


def roc(
    scores: np.ndarray,
    success: np.ndarray,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Curve | None:
    """True positive rate over false positive rate; None with fewer than two of either outcome.

    Args:
        scores: (n,) without NaN.
        success: (n,) bool.
        rng, resamples: of the bootstrap, successes and failures separately.
    """
    if success.sum() < 2 or (~success).sum() < 2:
        return None
    ranked = RankedScores.of(scores, success)
    x, y = ranked.roc_points()
    bands = []
    for weights in stratified_weights(success, rng, resamples):
        xs, ys = ranked.roc_points(weights)
        # Where the curve steps, the band takes the upper end of the step.
        bands += [np.interp(GRID, _strictly_rising(a), b) for a, b in zip(xs, ys, strict=True)]
    area = float(np.trapezoid(y[0], x[0]))
    thresholds = np.concatenate(([np.inf], ranked.levels))
    bounds = auc_interval(scores, success)
    assert bounds is not None  # both outcomes occur
    return Curve(thresholds, x[0], y[0], _band(bands, success), area, bounds)


def _band(curves: list[np.ndarray], success: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """The band of resampled curves (101,) each."""
    if min(success.sum(), (~success).sum()) < FEWEST:
        return None
    low, high = np.quantile(np.array(curves), [0.025, 0.975], axis=0)
    return low, high


def _strictly_rising(x: np.ndarray) -> np.ndarray:
    """Nondecreasing x made strictly rising, by 1e-12 a step, the last one unchanged."""
    return x - np.arange(len(x))[::-1] * 1e-12


def precision_recall(
    scores: np.ndarray,
    success: np.ndarray,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Curve | None:
    """Precision over recall; the area is the average precision Σ (R_k - R_{k-1}) P_k.

    Its interval is Wilson's of a share of the successes: K. Boyd, K. H. Eng and C. D. Page, Area
    under the precision-recall curve: point estimates and confidence intervals, ECML PKDD 2013, with
    Wilson's in the place of their binomial interval, which is a point where the area is 1.

    Arguments as for ``roc``; None with fewer than two successes.
    """
    if success.sum() < 2:
        return None
    ranked = RankedScores.of(scores, success)
    x, y = _precision(*ranked.counts())
    bands = []
    for weights in stratified_weights(success, rng, resamples):
        xs, ys = _precision(*ranked.counts(weights))
        for recall, precision in zip(xs, ys, strict=True):
            # The precision at a recall is that of the first threshold that reaches it.
            first = np.searchsorted(recall, GRID - 1e-12)
            bands.append(precision[np.minimum(first, len(recall) - 1)])
    area = min(float(_average_precision(x, y)[0]), 1.0)  # a sum of shares, rounded
    bounds = wilson_interval(area * success.sum(), int(success.sum()))
    return Curve(ranked.levels, x[0], y[0], _band(bands, success), area, bounds)


def _precision(good: np.ndarray, bad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    drawn = good + bad
    # Where none of the trials at the highest scores was drawn, nothing is predicted to succeed,
    # and nothing wrongly: the precision is set to 1.
    return good / good[:, -1:], np.where(drawn > 0, good / np.maximum(drawn, 1), 1.0)


def _average_precision(recall: np.ndarray, precision: np.ndarray) -> np.ndarray:
    return (np.diff(recall, axis=1, prepend=0.0) * precision).sum(axis=1)
