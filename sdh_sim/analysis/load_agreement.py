"""Predicted against simulated load: q* against q_sim of the load test.

Both are in weights of the object. q_sim is 0 for a grasp that does not hold the object without
further load. Where the grasp still held at the largest load tried, q_sim is that load: such a
trial counts in the rank correlation, but not in the ratio q*/q_sim.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.stats

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.resampling import RESAMPLES, Interval, interval


@dataclass(frozen=True)
class Agreement:
    """One metric q* against q_sim.

    Attributes:
        n: trials with both numbers.
        spearman: rank correlation; None where either is constant or n < 3.
        spearman_interval: its 95 % bootstrap interval.
        ratios: trials with both above 0, finite and q_sim below the largest load.
        median, low_quartile, high_quartile: of log(q*/q_sim) over those; None if there are none.
        median_interval: 95 % bootstrap interval of the median.
        spread: half the distance between the 16 % and 84 % quantiles of log(q*/q_sim); for a
            normal distribution its standard deviation.
        below: share of the trials with q* <= q_sim, those that held the largest load included.
        zero: trials where q* is not above 0 though the grasp held a load.
        dropped: trials where the grasp held no load though q* is above 0.
        capped: trials that held the largest load.
    """

    n: int
    spearman: float | None
    spearman_interval: Interval | None
    ratios: int
    median: float | None
    low_quartile: float | None
    high_quartile: float | None
    median_interval: Interval | None
    spread: float | None
    below: Proportion
    zero: int
    dropped: int
    capped: int

    @property
    def factor(self) -> float | None:
        """Median of q*/q_sim: above 1 where the metric overestimates the load."""
        return None if self.median is None else float(np.exp(self.median))


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
    # All resamples at once: scipy.stats.spearmanr takes one pair at a time, or correlates each
    # column with every other.
    drawn = rng.integers(len(x), size=(resamples, len(x)))
    a, b = scipy.stats.rankdata(x[drawn], axis=1), scipy.stats.rankdata(y[drawn], axis=1)
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    size = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    varied = size > 0  # undefined for a resample that is constant
    return interval((a * b).sum(axis=1)[varied] / size[varied])


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
    usable = (q > 0) & np.isfinite(q) & (q_sim > 0) & ~capped
    logs = np.log(q[usable] / q_sim[usable])
    correlation = spearman(q, q_sim)
    ranked = None if correlation is None else _spearman_interval(q, q_sim, rng, resamples)
    median = quarter = three = spread = bounds = None
    if len(logs):
        low, quarter, median, three, high = np.quantile(logs, [0.16, 0.25, 0.5, 0.75, 0.84])
        spread = float(high - low) / 2
        draws = rng.integers(len(logs), size=(resamples, len(logs)))
        bounds = interval(np.median(logs[draws], axis=1))
    return Agreement(
        n=len(q),
        spearman=correlation,
        spearman_interval=ranked,
        ratios=len(logs),
        median=None if median is None else float(median),
        low_quartile=None if quarter is None else float(quarter),
        high_quartile=None if three is None else float(three),
        median_interval=bounds,
        spread=spread,
        below=Proportion(int((q <= q_sim).sum()), len(q)),
        zero=int(((q <= 0) & (q_sim > 0)).sum()),
        dropped=int(((q > 0) & (q_sim <= 0)).sum()),
        capped=int(capped.sum()),
    )
