"""Receiver operating characteristic and precision-recall curves with their bootstrap bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdh_sim.analysis.resampling import (
    RESAMPLES,
    Interval,
    RankedScores,
    interval,
    stratified_weights,
)

GRID = np.linspace(0.0, 1.0, 101)
GRID.setflags(write=False)


@dataclass(frozen=True)
class Curve:
    """A curve over all thresholds.

    Attributes:
        thresholds: (m,) falling; success is predicted for scores of at least this much; of
            the ROC curve the first is +inf, where no trial is predicted to succeed.
        x, y: (m,) the curve at each threshold.
        low, high: (101,) 95 % band of y at the x of ``GRID``.
        area: area under it.
        area_interval: its 95 % interval.
    """

    thresholds: np.ndarray
    x: np.ndarray
    y: np.ndarray
    low: np.ndarray
    high: np.ndarray
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
    bands, areas = [], []
    for weights in stratified_weights(success, rng, resamples):
        xs, ys = ranked.roc_points(weights)
        # Where the curve steps, the band takes the upper end of the step.
        bands.append([np.interp(GRID, _strictly_rising(a), b) for a, b in zip(xs, ys, strict=True)])
        areas.append(np.trapezoid(ys, xs, axis=1))
    low, high = np.quantile(np.concatenate(bands), [0.025, 0.975], axis=0)
    area = float(np.trapezoid(y[0], x[0]))
    thresholds = np.concatenate(([np.inf], ranked.levels))
    return Curve(thresholds, x[0], y[0], low, high, area, interval(np.concatenate(areas)))


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

    Arguments as for ``roc``; None with fewer than two successes.
    """
    if success.sum() < 2:
        return None
    ranked = RankedScores.of(scores, success)
    x, y = _precision(*ranked.counts())
    bands, areas = [], []
    for weights in stratified_weights(success, rng, resamples):
        xs, ys = _precision(*ranked.counts(weights))
        for recall, precision in zip(xs, ys, strict=True):
            # The precision at a recall is that of the first threshold that reaches it.
            first = np.searchsorted(recall, GRID - 1e-12)
            bands.append(precision[np.minimum(first, len(recall) - 1)])
        areas.append(_average_precision(xs, ys))
    low, high = np.quantile(np.array(bands), [0.025, 0.975], axis=0)
    area = float(_average_precision(x, y)[0])
    return Curve(ranked.levels, x[0], y[0], low, high, area, interval(np.concatenate(areas)))


def _precision(good: np.ndarray, bad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    drawn = good + bad
    # Where none of the trials at the highest scores was drawn, nothing is predicted to succeed,
    # and nothing wrongly: the precision is set to 1.
    return good / good[:, -1:], np.where(drawn > 0, good / np.maximum(drawn, 1), 1.0)


def _average_precision(recall: np.ndarray, precision: np.ndarray) -> np.ndarray:
    return (np.diff(recall, axis=1, prepend=0.0) * precision).sum(axis=1)
