"""Bootstrap resamples of scored trials, as weights of the trials: how often each was drawn.

The trials are sorted by score once; every statistic of a resample is then a cumulative sum of its
weights, for all resamples of a block together. Neither SciPy nor scikit-learn computes areas of
weighted ROC curves for thousands of resamples at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

RESAMPLES = 2000
FEWEST = 200  # resamples; the ends of an interval are then uncertain by a tenth of its half-width
_MOST_DRAWN = 10_000_000  # trials drawn in all by one bootstrap, unless that leaves too few
_CHUNK = 2_000_000  # elements of one block of weights

Interval = tuple[float, float]


def interval(samples: np.ndarray) -> Interval:
    """95 % percentile interval of bootstrapped values (r,)."""
    low, high = np.quantile(samples, [0.025, 0.975])
    return float(low), float(high)


def resamples_of(trials: int, resamples: int = RESAMPLES) -> int:
    """How many resamples of so many trials to draw: above 5000 fewer than were asked for.

    The interval narrows with the root of the number of trials while the share of it that a few
    resamples leave open stays; the time to draw them would grow without bound.
    """
    return min(resamples, max(FEWEST, _MOST_DRAWN // max(trials, 1)))


def stratified_weights(
    success: np.ndarray, rng: np.random.Generator, resamples: int = RESAMPLES
) -> Iterator[np.ndarray]:
    """How often each trial is drawn when successes and failures are resampled separately.

    Args:
        success: (n,) bool.
        rng: source of the resamples.
        resamples: how many in all, fewer where there are many trials (``resamples_of``).

    Yields:
        blocks (rows, n) of counts; in each row those of the successes add up to their number, and
        so do those of the failures.
    """
    resamples = resamples_of(len(success), resamples)
    block = max(1, _CHUNK // max(1, len(success)))
    for start in range(0, resamples, block):
        rows = min(block, resamples - start)
        weights = np.empty((rows, len(success)), dtype=np.int64)
        for members in (success, ~success):
            count = int(members.sum())
            if count:
                weights[:, members] = rng.multinomial(count, np.full(count, 1 / count), size=rows)
        yield weights


def drawn_indices(
    trials: int, rng: np.random.Generator, resamples: int = RESAMPLES
) -> Iterator[np.ndarray]:
    """Resamples of trials of one kind, as blocks (rows, trials) of indices; as many as above."""
    resamples = resamples_of(trials, resamples)
    block = max(1, _CHUNK // trials)
    for start in range(0, resamples, block):
        yield rng.integers(trials, size=(min(block, resamples - start), trials))


@dataclass(frozen=True)
class RankedScores:
    """Trials sorted by falling score, to count successes and failures above each score.

    Attributes:
        levels: distinct scores, falling (m,).
        order: indices of the trials by falling score (n,).
        ends: position of the last trial of each level in that order (m,).
        success: (n,) bool, in the trials' own order.
    """

    levels: np.ndarray
    order: np.ndarray
    ends: np.ndarray
    success: np.ndarray

    @classmethod
    def of(cls, scores: np.ndarray, success: np.ndarray) -> RankedScores:
        """Sort trials by their scores (n,), which may be infinite but not NaN.

        Args:
            scores: (n,).
            success: (n,) bool, the outcomes.
        """
        order = np.argsort(-scores, kind="stable")
        falling = scores[order]
        ends = np.flatnonzero(np.append(falling[1:] != falling[:-1], True)) if len(order) else order
        return cls(falling[ends], order, ends, success)

    def counts(self, weights: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Successes and failures with a score of at least each level.

        Args:
            weights: (r, n) how often each trial counts; None counts each once.

        Returns:
            true and false positives, (r, m) each; (1, m) without weights.
        """
        if weights is None:
            weights = np.ones((1, len(self.order)), dtype=np.int64)
        good = np.cumsum((weights * self.success)[:, self.order], axis=1)[:, self.ends]
        bad = np.cumsum((weights * ~self.success)[:, self.order], axis=1)[:, self.ends]
        return good, bad

    def roc_points(self, weights: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """False and true positive rates, (r, m + 1) each, for falling thresholds.

        At the first no trial is predicted to succeed, at the last every one.
        """
        good, bad = self.counts(weights)
        zero = np.zeros((len(good), 1))
        x = np.concatenate((zero, bad / bad[:, -1:]), axis=1)
        y = np.concatenate((zero, good / good[:, -1:]), axis=1)
        return x, y

    def roc_areas(self, weights: np.ndarray | None = None) -> np.ndarray:
        """Area under the ROC curve for each row of weights; (r,)."""
        x, y = self.roc_points(weights)
        return np.trapezoid(y, x, axis=1)
