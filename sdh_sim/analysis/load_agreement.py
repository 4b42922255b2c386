"""Predicted against simulated load: q* against q_sim of the load test.

Both are in weights of the object. q_sim is 0 for a grasp that does not hold the object even without
weight. The ratio q*/q_sim is then infinite, or 1 where q* says so too: every trial counts, so that
all metrics are compared on the same ones. Where the grasp still held at the largest load tried,
q_sim is that load: such a trial counts in the rank correlation, but has no ratio.

The counts of what a metric says add up to the trials: see ``Agreement``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.stats

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.resampling import RESAMPLES, Interval, drawn_indices, interval
from sdh_sim.analysis.roc_area import FEWEST


@dataclass(frozen=True)
class RatioSummary:
    """Ratios q*/q_sim of a metric; 0 and infinity are ratios too.

    Quantiles are ratios of the sample: between a number and infinity lies none.

    Attributes:
        n: number of ratios.
        median: above 1 where the metric overestimates the load.
        median_interval: its 95 % interval by order statistics (``median_interval``).
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


def median_interval(values: np.ndarray) -> Interval:
    """95 % interval of the median of the distribution that values (k,) are drawn from.

    Between two order statistics, exact for any distribution (the count below the median is
    binomial); from 0 to infinity for fewer than six values, none of which may be negative.
    """
    low = int(scipy.stats.binom.ppf(0.025, len(values), 0.5))
    if not low:
        return 0.0, math.inf
    ordered = np.sort(values)
    return float(ordered[low - 1]), float(ordered[-low])


def summarise_ratios(ratios: np.ndarray) -> RatioSummary | None:
    """Summary of ratios (k,), of which there may be 0 and infinity; None of none."""
    if not len(ratios):
        return None
    left, low, median, high, right = np.quantile(
        ratios, (0.16, 0.25, 0.5, 0.75, 0.84), method="nearest"
    )
    return RatioSummary(
        len(ratios),
        float(median),
        median_interval(ratios),
        (float(low), float(high)),
        math.sqrt(right / left) if left > 0.0 and math.isfinite(right) else math.inf,
    )


@dataclass(frozen=True)
class Agreement:
    """One metric q* against q_sim.

    Attributes:
        n: trials with both numbers.
        spearman: rank correlation; None where either is constant or n < 3.
        spearman_interval: its 95 % bootstrap interval; None for fewer than ten trials.
        ratio: summary of q*/q_sim over all trials that gave way; None if there are none.
        below: share of the trials with q* <= q_sim, those that held the largest load included.
        capped: trials that held the largest load. The others gave way, and of them
        both: trials where q* and q_sim are above 0.
        zero: trials where q* is not above 0 though the grasp held a load.
        dropped: trials where the grasp held no load though q* is above 0.
        neither: trials where the grasp held no load and q* is not above 0.
    """

    n: int
    spearman: float | None
    spearman_interval: Interval | None
    ratio: RatioSummary | None
    below: Proportion
    capped: int
    both: int
    zero: int
    dropped: int
    neither: int


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
    ranked = None
    if correlation is not None and len(q) >= FEWEST:
        ranked = _spearman_interval(q, q_sim, rng, resamples)
    promised, held, gave_way = q > 0, q_sim > 0, ~capped
    return Agreement(
        n=len(q),
        spearman=correlation,
        spearman_interval=ranked,
        ratio=summarise_ratios(load_ratios(q, q_sim, capped)),
        below=Proportion(int((q <= q_sim).sum()), len(q)),
        capped=int(capped.sum()),
        both=int((gave_way & promised & held).sum()),
        zero=int((gave_way & ~promised & held).sum()),
        dropped=int((gave_way & promised & ~held).sum()),
        neither=int((gave_way & ~promised & ~held).sum()),
    )


@dataclass(frozen=True)
class Nearest:
    """Which of several metrics is nearest to q_sim by the median of q*/q_sim.

    Attributes:
        metric: its name.
        share: of the resamples of the trials, the same for all metrics, in which it is so.
        runner_up: the metric that is nearest in most of the others; None where there are none.
    """

    metric: str
    share: float
    runner_up: str | None


def find_nearest(
    ratios: Mapping[str, np.ndarray], rng: np.random.Generator, resamples: int = RESAMPLES
) -> Nearest | None:
    """The metric whose median ratio is nearest to 1 as a factor; None of none.

    Args:
        ratios: by metric (k,), of the same trials in the same order.
        rng, resamples: of the bootstrap over trials.
    """
    names = list(ratios)
    if not names or not len(ratios[names[0]]):
        return None
    every = np.array([ratios[name] for name in names])
    with np.errstate(divide="ignore"):
        off = np.abs(np.log(np.quantile(every, 0.5, axis=1, method="nearest")))
        first = np.concatenate(
            [
                np.abs(np.log(np.quantile(every[:, drawn], 0.5, axis=2, method="nearest"))).argmin(
                    0
                )
                for drawn in drawn_indices(every.shape[1], rng, resamples)
            ]
        )
    wins = np.bincount(first, minlength=len(names)) / len(first)
    best = int(off.argmin())
    others = [k for k in np.argsort(-wins, kind="stable") if k != best and wins[k] > 0]
    return Nearest(names[best], float(wins[best]), names[others[0]] if others else None)
