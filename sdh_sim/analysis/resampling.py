"""Resamples of scored trials: each class by itself, as weights, so that nothing is copied."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

RESAMPLES = 2000
_CHUNK = 2_000_000  # elements of one block of weights

Interval = tuple[float, float]


def interval(samples: np.ndarray) -> Interval:
    """95 % percentile interval of bootstrapped values (r,)."""
    low, high = np.quantile(samples, [0.025, 0.975])
    return float(low), float(high)


def stratified_weights(
    success: np.ndarray, rng: np.random.Generator, resamples: int = RESAMPLES
) -> Iterator[np.ndarray]:
    """How often each trial is drawn, successes and failures resampled each among themselves.

    Args:
        success: (n,) bool.
        rng: source of the resamples.
        resamples: how many in all.

    Yields:
        blocks (rows, n) of counts; each row sums to the class sizes in each class.
    """
    block = max(1, _CHUNK // max(1, len(success)))
    for start in range(0, resamples, block):
        rows = min(block, resamples - start)
        weights = np.empty((rows, len(success)), dtype=np.int64)
        for members in (success, ~success):
            count = int(members.sum())
            if count:
                weights[:, members] = rng.multinomial(count, np.full(count, 1 / count), size=rows)
        yield weights


@dataclass(frozen=True)
class Ladder:
    """Trials sorted by falling score, for counting what lies above every distinct score.

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
    def of(cls, scores: np.ndarray, success: np.ndarray) -> Ladder:
        """Sort scores (n,), infinities included but no NaN, with their outcomes (n,) bool."""
        order = np.argsort(-scores, kind="stable")
        falling = scores[order]
        ends = np.flatnonzero(np.append(falling[1:] != falling[:-1], True)) if len(order) else order
        return cls(falling[ends], order, ends, success)

    def counts(self, weights: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Successes and failures with a score of at least each level.

        Args:
            weights: (r, n) how often each trial counts; None counts each once.

        Returns:
            true and false positives (r, m), with None (1, m).
        """
        if weights is None:
            weights = np.ones((1, len(self.order)), dtype=np.int64)
        good = np.cumsum((weights * self.success)[:, self.order], axis=1)[:, self.ends]
        bad = np.cumsum((weights * ~self.success)[:, self.order], axis=1)[:, self.ends]
        return good, bad

    def roc_points(self, weights: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """False and true positive rates (r, m + 1) from no trial predicted to all of them."""
        good, bad = self.counts(weights)
        zero = np.zeros((len(good), 1))
        x = np.concatenate((zero, bad / bad[:, -1:]), axis=1)
        y = np.concatenate((zero, good / good[:, -1:]), axis=1)
        return x, y

    def roc_areas(self, weights: np.ndarray | None = None) -> np.ndarray:
        """Area under the ROC curve for each row of weights (r,)."""
        x, y = self.roc_points(weights)
        return np.trapezoid(y, x, axis=1)
