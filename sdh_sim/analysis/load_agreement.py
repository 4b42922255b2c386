"""Predicted against simulated load: q* against q_sim of the load test.

Both are in weights of the object. q_sim is 0 for a grasp that does not hold the object even without
weight. The ratio q*/q_sim is then infinite, or 1 where q* says so too: every trial counts, so that
all metrics are compared on the same ones. Where the grasp still held at the largest load tried,
q_sim is that load: such a trial counts in the rank correlation, but has no ratio.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.stats

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.resampling import RESAMPLES, Interval, drawn_indices, interval


@dataclass(frozen=True)
class RatioSummary:
    """Ratios q*/q_sim of a metric; 0 and infinity are ratios too.

    Quantiles are ratios of the sample: between a number and infinity lies none.

    Attributes:
        n: number of ratios.
        median: above 1 where the metric overestimates the load.
        median_interval: its 95 % bootstrap interval.
        quartiles: the lower and the upper one.
        spread: factor to either side of the middle that spans 68 % of the ratios, infinite where 16
            % of them are 0 or infinite; for a log-normal distribution exp(standard deviation).
    """

    n: int
    median: float
    median_interval: Interval
    quartiles: tuple[float, float]
    spread: float


def load_ratios(q: np.ndarray, q_sim: np.ndarray, capped: np.ndarray) -> np.ndarray:
    """Ratios q*/q_sim (k,) of all trials that gave way, 1 where both loads are 0.

    Args:
        q: (n,) the metric [weights]; NaN and what is below 0 count as 0.
        q_sim: (n,) load held [weights], without NaN.
        capped: (n,) bool, whether the grasp still held at the largest load tried.
    """
    q, q_sim = np.maximum(np.nan_to_num(q, posinf=np.inf), 0.0)[~capped], q_sim[~capped]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((q == 0.0) & (q_sim == 0.0), 1.0, q / q_sim)


def summarise_ratios(
    ratios: np.ndarray, rng: np.random.Generator, resamples: int = RESAMPLES
) -> RatioSummary | None:
    """Summary of ratios (k,), of which there may be 0 and infinity; None of none."""
    if not len(ratios):
        return None
    left, low, median, high, right = np.quantile(
        ratios, (0.16, 0.25, 0.5, 0.75, 0.84), method="nearest"
    )
    medians = np.concatenate(
        [
            np.quantile(ratios[drawn], 0.5, axis=1, method="nearest")
            for drawn in drawn_indices(len(ratios), rng, resamples)
        ]
    )
    bounds = np.quantile(medians, (0.025, 0.975), method="nearest")
    return RatioSummary(
        len(ratios),
        float(median),
        (float(bounds[0]), float(bounds[1])),
        (float(low), float(high)),
        math.sqrt(right / left) if left > 0.0 and math.isfinite(right) else math.inf,
    )


@dataclass(frozen=True)
class Agreement:
    """One metric q* against q_sim.

    Attributes:
        n: trials with both numbers.
        spearman: rank correlation; None where either is constant or n < 3.
        spearman_interval: its 95 % bootstrap interval.
        ratio: summary of q*/q_sim over all trials that gave way; None if there are none.
        below: share of the trials with q* <= q_sim, those that held the largest load included.
        zero: trials where q* is not above 0 though the grasp held a load.
        dropped: trials where the grasp held no load though q* is above 0.
        capped: trials that held the largest load.
    """

    n: int
    spearman: float | None
    spearman_interval: Interval | None
    ratio: RatioSummary | None
    below: Proportion
    zero: int
    dropped: int
    capped: int


def spearman(x: np.ndarray, y: np.ndarray) -> float | None:
    """Spearman's rank correlation; None where x or y is constant, or for fewer than three."""
    if len(x) < 3 or (x == x[0]).all() or (y == y[0]).all():
        return None
    # Ranks, since SciPy 1.13 takes infinities of both signs for NaN.
    a, b = scipy.stats.rankdata(x), scipy.stats.rankdata(y)
    return float(scipy.stats.spearmanr(a, b).statistic)


def _spearman_interval(
    x: np.ndarray, y: np.ndarray, rng: np.random.Generator, resamples: int
) -> Interval:
    # A block of resamples at once: scipy.stats.spearmanr takes one pair at a time, or correlates
    # each column with every other.
    blocks = drawn_indices(len(x), rng, resamples)
    return interval(np.concatenate([_rank_correlations(x[drawn], y[drawn]) for drawn in blocks]))


def _rank_correlations(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Spearman's rank correlation of each row, without the rows in which x or y is constant."""
    a, b = scipy.stats.rankdata(x, axis=1), scipy.stats.rankdata(y, axis=1)
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    size = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    varied = size > 0
    return (a * b).sum(axis=1)[varied] / size[varied]


def agree(
    q: np.ndarray,
    q_sim: np.ndarray,
    capped: np.ndarray,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Agreement:
    """Compare a metric with the load test.

    Args:
        q: (n,) the metric [weights]; NaN counts as 0, -inf (no equilibrium) ranks below 0.
        q_sim: (n,) load held [weights], without NaN.
        capped: (n,) bool, whether the grasp still held at the largest load tried.
        rng, resamples: of the bootstrap over trials.
    """
    q = np.where(np.isnan(q), 0.0, q)
    correlation = spearman(q, q_sim)
    ranked = None if correlation is None else _spearman_interval(q, q_sim, rng, resamples)
    return Agreement(
        n=len(q),
        spearman=correlation,
        spearman_interval=ranked,
        ratio=summarise_ratios(load_ratios(q, q_sim, capped), rng, resamples),
        below=Proportion(int((q <= q_sim).sum()), len(q)),
        zero=int(((q <= 0) & (q_sim > 0)).sum()),
        dropped=int(((q > 0) & (q_sim <= 0)).sum()),
        capped=int(capped.sum()),
    )
