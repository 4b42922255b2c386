"""Two metrics on the same trials: which predicts correctly where they disagree, and their areas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.stats

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.roc_area import AreaDifference, compare_areas


@dataclass(frozen=True)
class Paired:
    """Predictions of two metrics at one threshold.

    Attributes:
        n: trials.
        disagree: share of the trials for which they predict different outcomes.
        only_first_right, only_second_right: trials that one of them alone predicts correctly.
        first_optimistic: of the trials that the first alone predicts to succeed, those that did.
        second_optimistic: the same for the second.
        p_value: of McNemar's exact two-sided test that both are wrong equally often.
        areas: area under the ROC curve, first less second; None where a class is empty.
    """

    n: int
    disagree: Proportion
    only_first_right: int
    only_second_right: int
    first_optimistic: Proportion
    second_optimistic: Proportion
    p_value: float
    areas: AreaDifference | None


def mcnemar(only_first: int, only_second: int) -> float:
    """p-value of McNemar's exact two-sided test: that two metrics are wrong equally often.

    Args:
        only_first, only_second: trials that one of them alone predicts correctly.

    Returns:
        that of the binomial test of ``only_first`` of their sum at one half; 1 if both are 0.
    """
    total = only_first + only_second
    return float(scipy.stats.binomtest(only_first, total).pvalue) if total else 1.0


def compare_pair(
    first: np.ndarray,
    second: np.ndarray,
    success: np.ndarray,
    threshold: float,
) -> Paired:
    """Compare two metrics on the same trials.

    Args:
        first, second: (n,) without NaN.
        success: (n,) bool.
        threshold: success is predicted above it by both.
    """
    a, b = first > threshold, second > threshold
    only_a, only_b = (a == success) & (b != success), (b == success) & (a != success)
    return Paired(
        n=len(success),
        disagree=Proportion(int((a != b).sum()), len(success)),
        only_first_right=int(only_a.sum()),
        only_second_right=int(only_b.sum()),
        first_optimistic=Proportion(int((a & ~b & success).sum()), int((a & ~b).sum())),
        second_optimistic=Proportion(int((b & ~a & success).sum()), int((b & ~a).sum())),
        p_value=mcnemar(int(only_a.sum()), int(only_b.sum())),
        areas=compare_areas(first, second, success),
    )
