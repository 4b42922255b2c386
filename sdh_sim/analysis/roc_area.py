"""Area under the ROC curve, P(score of a success > of a failure) + P(equal) / 2, and its interval.

The resamples of a bootstrap cannot show what a small sample does not hold: where all of a few
successes rank above all failures, each resample does too, and the percentile interval is a point.
So the interval here is found as Wilson's is for a share: it holds every area that the sample would
not contradict.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.optimize
import scipy.stats

from sdh_sim.analysis.resampling import Interval

Z95 = 1.959963984540054  # 97.5 % quantile of the standard normal distribution
# Of the rarer outcome: with that many trials the variance that the sample shows and the one that
# its area alone suggests weigh the same (in their logarithms).
EQUAL_WEIGHT = 20


def auc(scores: np.ndarray, success: np.ndarray) -> float | None:
    """Area under the ROC curve.

    Args:
        scores: (n,) any real numbers, infinities included.
        success: (n,) bool.

    Returns:
        Mann-Whitney's U over the number of pairs; None where one class is empty.
    """
    if not success.any() or success.all():
        return None
    return float(_placements(scores, success)[0].mean())


def auc_interval(scores: np.ndarray, success: np.ndarray) -> Interval | None:
    """95 % score interval of the area: all areas x with |area - x| <= 1.96 sd(x).

    sd(x)² is the variance that an area x has with so many trials (Hanley and McNeil; Newcombe's
    method 5), times a factor for the shape of the scores' distributions: DeLong's variance of this
    sample over Newcombe's at its area, to a power that grows from 0 to 1 with the number of trials
    of the rarer outcome, since DeLong's says little of a few. Its coverage is tested by simulation.

    Sources: R. G. Newcombe, Confidence intervals for an effect size measure based on the
    Mann-Whitney statistic, part 2, Statistics in Medicine 25 (2006); E. R. DeLong and others,
    Biometrics 44 (1988).

    Args:
        scores: (n,) any real numbers, infinities included.
        success: (n,) bool.

    Returns:
        None where one class is empty.
    """
    good, bad = int(success.sum()), int((~success).sum())
    if not good or not bad:
        return None
    of_good, of_bad = _placements(scores, success)
    area = float(of_good.mean())
    factor, rarer = 1.0, min(good, bad)
    if rarer > 1 and 0.0 < area < 1.0:
        found = of_good.var(ddof=1) / good + of_bad.var(ddof=1) / bad
        expected = _variance(area, good, bad)
        factor = float(max(found / expected, 1e-9) ** (rarer / (rarer + EQUAL_WEIGHT)))

    def beyond(x: float) -> float:
        return (area - x) ** 2 - Z95**2 * factor * _variance(x, good, bad)

    tiny = 1e-9  # beside the area itself, where ``beyond`` is 0 at both ends of the scale
    low = 0.0 if area == 0.0 else _root(beyond, 0.0, area - tiny)
    high = 1.0 if area == 1.0 else _root(beyond, area + tiny, 1.0)
    return low, high


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return scipy.optimize.root_scalar(function, bracket=(low, high), method="brentq").root


def _variance(area: float, good: int, bad: int) -> float:
    """Of the estimated area, by Newcombe's method 5."""
    half = 0.5 * (good + bad) - 1.0
    pairs = (1.0 - area) / (2.0 - area) + area / (1.0 + area)
    return area * (1.0 - area) * (1.0 + half * pairs) / (good * bad)


def _placements(scores: np.ndarray, success: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Share of the failures below each success, and of the successes above each failure."""
    ranks = scipy.stats.rankdata(scores)
    good, bad = ranks[success], ranks[~success]
    above = (good - scipy.stats.rankdata(good)) / len(bad)
    below = 1.0 - (bad - scipy.stats.rankdata(bad)) / len(good)
    return above, below


class AreaDifference(NamedTuple):
    """Areas of two scores on the same trials.

    Attributes:
        value: the first less the second.
        interval: 95 %; None with fewer than ten of an outcome, where it would promise too much.
        p_value: of DeLong's two-sided test that the areas are equal; None as the interval.
    """

    value: float
    interval: Interval | None
    p_value: float | None


FEWEST = 10  # trials of each outcome for an interval that rests on a sample's own variance


def compare_areas(
    first: np.ndarray, second: np.ndarray, success: np.ndarray
) -> AreaDifference | None:
    """DeLong's test of the areas of two scores on the same trials; None where a class is empty.

    Args:
        first, second: (n,) scores of the same trials, without NaN.
        success: (n,) bool.
    """
    good, bad = int(success.sum()), int((~success).sum())
    if not good or not bad:
        return None
    a, b = _placements(first, success), _placements(second, success)
    value = float(a[0].mean() - b[0].mean())
    if min(good, bad) < FEWEST:
        return AreaDifference(value, None, None)
    spread = (a[0] - b[0]).var(ddof=1) / good + (a[1] - b[1]).var(ddof=1) / bad
    sd = math.sqrt(spread)
    if sd == 0.0:  # one ranks as the other does
        return AreaDifference(value, (value, value), 1.0)
    p = 2.0 * float(scipy.stats.norm.sf(abs(value) / sd))
    return AreaDifference(value, (value - Z95 * sd, value + Z95 * sd), p)
