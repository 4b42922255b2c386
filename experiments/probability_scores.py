"""How good predicted probabilities are, against shares of successes of several copies each.

Trial i was repeated n_i times, k_i of them held. All scores are over the copies, trials drawn
together with their copies in the bootstrap: copies of one trial are not independent of each other.

Brier: Verification of forecasts expressed in terms of probability, Monthly Weather Review 78,
1950; Murphy: A new vector partition of the probability score, J. Applied Meteorology 12, 1973;
Stephenson, Coelho, Jolliffe: Two extra components in the Brier score decomposition, Weather and
Forecasting 23, 2008; Platt: Probabilistic outputs for support vector machines, 1999.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sdh_sim.analysis.resampling import RESAMPLES, Interval, interval

BINS = 5  # of equal width between 0 and 1
STEPS, RIDGE = 50, 1e-3  # of Newton's iteration; on the slope, so that separable trials end it


class Shares(NamedTuple):
    """What the copies of each trial did.

    Attributes:
        held: copies that held (n,).
        copies: how many ran, at least 1 (n,).
    """

    held: np.ndarray
    copies: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """Shares of successes (n,)."""
        return self.held / self.copies


class Brier(NamedTuple):
    """Mean squared error of predicted probabilities, and what it consists of.

    ``score = reliability - resolution + uncertainty + within``.

    Attributes:
        score: 0 is perfect; low is good.
        reliability: mean squared distance of predicted and observed shares of a bin; low is good.
        resolution: mean squared distance of a bin's share from that of all; high is good.
        uncertainty: that of predicting the share of all copies every time.
        within: from predictions that differ within a bin.
    """

    score: float
    reliability: float
    resolution: float
    uncertainty: float
    within: float


class Bin(NamedTuple):
    """Trials whose predictions are alike.

    Attributes:
        members: which trials (n,) bool.
        predicted: mean prediction, over copies.
        observed: share of copies that held.
        copies: how many.
    """

    members: np.ndarray
    predicted: float
    observed: float
    copies: int


def bins_of(predicted: np.ndarray, shares: Shares, bins: int = BINS) -> list[Bin]:
    """The bins of equal width that have trials, lowest first; 1 belongs to the last."""
    place = np.minimum((predicted * bins).astype(int), bins - 1)
    found = []
    for k in np.unique(place):
        own = place == k
        weights = shares.copies[own]
        total = int(weights.sum())
        mean = float((weights * predicted[own]).sum() / total)
        found.append(Bin(own, mean, float(shares.held[own].sum() / total), total))
    return found


def brier(predicted: np.ndarray, shares: Shares, bins: int = BINS) -> Brier:
    """Brier score over all copies, decomposed.

    Args:
        predicted: probability of success of each trial's copies (n,), in [0, 1].
        shares: what they did.
        bins: of the decomposition.
    """
    total = float(shares.copies.sum())
    base = float(shares.held.sum() / total)
    found = bins_of(predicted, shares, bins)
    reliability = sum(b.copies * (b.predicted - b.observed) ** 2 for b in found) / total
    resolution = sum(b.copies * (b.observed - base) ** 2 for b in found) / total
    score = _score(predicted, shares)
    uncertainty = base * (1.0 - base)
    within = score - (reliability - resolution + uncertainty)
    return Brier(score, reliability, resolution, uncertainty, within)


def least_brier(shares: Shares) -> float:
    """The score of predicting each trial's own share: no prediction for all its copies has less."""
    return _score(shares.value, shares)


def brier_interval(
    predicted: np.ndarray, shares: Shares, rng: np.random.Generator, resamples: int = RESAMPLES
) -> Interval:
    """95 % bootstrap interval of the Brier score, trials resampled with their copies."""
    weights = trial_weights(len(predicted), rng, resamples)
    losses = shares.held * (1.0 - predicted) ** 2 + (shares.copies - shares.held) * predicted**2
    return interval((weights @ losses) / (weights @ shares.copies))


def trial_weights(count: int, rng: np.random.Generator, resamples: int = RESAMPLES) -> np.ndarray:
    """How often each trial is drawn in each resample (resamples, count)."""
    return rng.multinomial(count, np.full(count, 1.0 / count), size=resamples)


def copies_auc(scores: np.ndarray, shares: Shares, weights: np.ndarray | None = None) -> np.ndarray:
    """P(score of a copy that held > of one that did not) + P(equal)/2, over all pairs of copies.

    Args:
        scores: of each trial (n,), which all its copies have.
        shares: what they did.
        weights: how often each trial counts, in each row (r, n); None: once.

    Returns:
        (r,), NaN where all copies did the same.
    """
    if weights is None:
        weights = np.ones((1, len(scores)), dtype=np.int64)
    order = np.argsort(-scores, kind="stable")
    ends = np.flatnonzero(np.append(np.diff(scores[order]) != 0.0, True))
    good, bad = (
        np.cumsum((weights * n)[:, order], axis=1)[:, ends].astype(float)
        for n in (shares.held, shares.copies - shares.held)
    )
    zero = np.zeros((len(weights), 1))
    good, bad = np.hstack([zero, good]), np.hstack([zero, bad])
    pairs = good[:, -1] * bad[:, -1]
    area = np.asarray(np.trapezoid(good, bad, axis=1))
    return np.divide(area, pairs, out=np.full(len(area), np.nan), where=pairs > 0.0)


def calibrated(values: np.ndarray, shares: Shares, fold: np.ndarray) -> np.ndarray:
    """Probabilities (n,) by logistic regression on log(1 + v/median), each from the other folds.

    Args:
        values: a metric (n,), at least 0; infinite ones count as the largest finite one.
        shares: what the copies did.
        fold: of each trial (n,).
    """
    finite = np.isfinite(values)
    clipped = np.where(finite, values, values[finite].max(initial=0.0))
    positive = clipped[clipped > 0.0]
    feature = np.log1p(np.maximum(clipped, 0.0) / (np.median(positive) if positive.size else 1.0))
    result = np.empty(len(values))
    for k in np.unique(fold):
        own = fold == k
        intercept, slope = fit_logistic(feature[~own], Shares(*(n[~own] for n in shares)))
        result[own] = 1.0 / (1.0 + np.exp(-(intercept + slope * feature[own])))
    return result


def fit_logistic(feature: np.ndarray, shares: Shares) -> tuple[float, float]:
    """Intercept and slope of the most likely logistic curve, by Newton's method.

    Args:
        feature: of each trial (n,).
        shares: what its copies did.
    """
    spread = float(feature.std()) or 1.0
    centre = float(feature.mean())
    design = np.column_stack([np.ones(len(feature)), (feature - centre) / spread])
    penalty = RIDGE * float(shares.copies.sum()) * np.array([1e-6, 1.0])
    beta = np.zeros(2)
    for _ in range(STEPS):
        p = 1.0 / (1.0 + np.exp(-np.clip(design @ beta, -30.0, 30.0)))
        gradient = design.T @ (shares.held - shares.copies * p) - penalty * beta
        curvature = (design.T * (shares.copies * p * (1.0 - p))) @ design + np.diag(penalty)
        step = np.linalg.solve(curvature, gradient)
        beta += step / max(1.0, float(np.abs(step).max()))
        if np.abs(step).max() < 1e-9:
            break
    slope = float(beta[1]) / spread
    return float(beta[0]) - slope * centre, slope


def _score(predicted: np.ndarray, shares: Shares) -> float:
    losses = shares.held * (1.0 - predicted) ** 2 + (shares.copies - shares.held) * predicted**2
    return float(losses.sum() / shares.copies.sum())
