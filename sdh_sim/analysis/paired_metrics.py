"""Two metrics on the same trials: McNemar's test, who is right where they disagree, areas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.stats

from sdh_sim.analysis.proportion import Rate
from sdh_sim.analysis.resampling import RESAMPLES, Interval, Ladder, interval, stratified_weights


@dataclass(frozen=True)
class Paired:
    """Predictions of two metrics at one threshold.

    Attributes:
        n: trials.
        disagree: share of the trials for which they predict different ends.
        only_first_right, only_second_right: trials that one of them alone predicts rightly.
        first_optimistic: trials that the first alone predicts to succeed, and the share that did.
        second_optimistic: the same for the second.
        p_value: McNemar's exact test, two-sided: both err equally often.
        area_difference: area under the ROC curve, first less second; None where a class has
            fewer than two members.
        area_interval: its 95 % interval from paired resamples.
    """

    n: int
    disagree: Rate
    only_first_right: int
    only_second_right: int
    first_optimistic: Rate
    second_optimistic: Rate
    p_value: float
    area_difference: float | None
    area_interval: Interval | None


def mcnemar(only_first: int, only_second: int) -> float:
    """Exact two-sided p-value that either is as likely to be the only right one.

    Args:
        only_first, only_second: trials on which one alone is right.

    Returns:
        the binomial test of one count among both at a half; 1 where they never differ.
    """
    total = only_first + only_second
    return float(scipy.stats.binomtest(only_first, total).pvalue) if total else 1.0


def compare_pair(
    first: np.ndarray,
    second: np.ndarray,
    success: np.ndarray,
    threshold: float,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Paired:
    """Compare two metrics on the same trials.

    Args:
        first, second: (n,) without NaN.
        success: (n,) bool.
        threshold: success is predicted above it by both.
        rng, resamples: of the bootstrap, each class by itself.
    """
    a, b = first > threshold, second > threshold
    only_a, only_b = (a == success) & (b != success), (b == success) & (a != success)
    difference = bounds = None
    if success.sum() >= 2 and (~success).sum() >= 2:
        ladders = Ladder.of(first, success), Ladder.of(second, success)
        difference = float(ladders[0].roc_areas()[0] - ladders[1].roc_areas()[0])
        bounds = interval(
            np.concatenate(
                [
                    ladders[0].roc_areas(weights) - ladders[1].roc_areas(weights)
                    for weights in stratified_weights(success, rng, resamples)
                ]
            )
        )
    return Paired(
        n=len(success),
        disagree=Rate(int((a != b).sum()), len(success)),
        only_first_right=int(only_a.sum()),
        only_second_right=int(only_b.sum()),
        first_optimistic=Rate(int((a & ~b & success).sum()), int((a & ~b).sum())),
        second_optimistic=Rate(int((b & ~a & success).sum()), int((b & ~a).sum())),
        p_value=mcnemar(int(only_a.sum()), int(only_b.sum())),
        area_difference=difference,
        area_interval=bounds,
    )
