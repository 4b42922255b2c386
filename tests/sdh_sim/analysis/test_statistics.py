"""Curves, thresholds, paired tests and ratios against numbers computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.curves import GRID, precision_recall, roc
from sdh_sim.analysis.load_agreement import (
    Nearest,
    agree,
    find_nearest,
    load_ratios,
    median_interval,
    summarise_ratios,
)
from sdh_sim.analysis.paired_metrics import compare_pair, mcnemar
from sdh_sim.analysis.proportion import wilson_interval
from sdh_sim.analysis.resampling import (
    RankedScores,
    drawn_indices,
    resamples_of,
    stratified_weights,
)
from sdh_sim.analysis.thresholds import (
    assign_folds,
    best_threshold,
    calibrate,
    cross_validate,
    threshold_for,
)

T, F = True, False
FEW = 200  # resamples where the interval is not what is tested


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def cases(rounded: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """80 trials with ties, successes higher by one on average."""
    draw = rng(5)
    success = np.repeat([F, T], [45, 35])
    scores = draw.normal(size=80) + success
    return (np.round(scores, 1) if rounded else scores), success


def test_resamples_keep_the_class_sizes():
    success = np.array([T, T, F, T, F])
    rows = np.concatenate(list(stratified_weights(success, rng(), 50)))
    assert rows.shape == (50, 5)
    assert (rows[:, success].sum(axis=1) == 3).all()
    assert (rows[:, ~success].sum(axis=1) == 2).all()
    assert len(np.unique(rows, axis=0)) > 10


def test_many_trials_are_resampled_less_often():
    assert [resamples_of(n) for n in (0, 3, 5000, 10_000, 10**7)] == [2000, 2000, 2000, 1000, 200]
    assert resamples_of(10**7, 50) == 50
    success = np.arange(20_000) % 2 == 0
    assert sum(len(rows) for rows in stratified_weights(success, rng())) == 500
    assert sum(len(rows) for rows in drawn_indices(20_000, rng())) == 500


def test_ranked_scores_count_by_hand():
    scores = np.array([1.0, 3.0, 1.0, 2.0, 3.0])
    ranked = RankedScores.of(scores, np.array([T, T, F, F, T]))
    assert ranked.levels.tolist() == [3, 2, 1]
    good, bad = ranked.counts()
    assert (good.tolist(), bad.tolist()) == ([[2, 2, 3]], [[0, 1, 2]])
    good, bad = ranked.counts(np.array([[5, 1, 0, 2, 0]]))
    assert (good.tolist(), bad.tolist()) == ([[1, 1, 6]], [[0, 2, 2]])


def test_roc_of_four_trials():
    curve = roc(np.array([3.0, 2.0, 1.0, 0.0]), np.array([T, F, T, F]), rng(), FEW)
    assert curve is not None
    assert curve.x.tolist() == [0, 0, 0.5, 0.5, 1]
    assert curve.y.tolist() == [0, 0.5, 0.5, 1, 1]
    assert curve.thresholds.tolist() == [np.inf, 3, 2, 1, 0]
    assert curve.area == 0.75


def test_roc_area_is_the_comparisons_area_and_interval():
    scores, success = cases()
    curve = roc(scores, success, rng(0))
    assert curve is not None
    assert curve.area == pytest.approx(compare.auc(scores, success), abs=1e-12)
    assert curve.area_interval == compare.auc_interval(scores, success)


def test_roc_band_contains_the_curve_and_is_that_of_a_plain_bootstrap():
    scores, success = cases(rounded=False)
    curve = roc(scores, success, rng(0), 1000)
    assert curve is not None
    assert curve.band is not None
    lowest, highest = curve.band
    middle = slice(5, 96)
    at = np.interp(GRID, curve.x + np.arange(len(curve.x)) * 1e-12, curve.y)
    assert (lowest[middle] <= at[middle] + 1e-9).all()
    assert (highest[middle] >= at[middle] - 1e-9).all()
    # At a fixed false positive rate of one half, by resampling trials one by one.
    values = []
    draw = rng(1)
    for _ in range(1500):
        good, bad = draw.choice(scores[success], 35), draw.choice(scores[~success], 45)
        values.append((good > np.sort(bad)[::-1][22]).mean())
    expected = np.quantile(values, [0.025, 0.975])
    assert (lowest[50], highest[50]) == pytest.approx(expected, abs=0.05)


def test_separated_classes_of_ten_have_bands_of_no_width_and_areas_that_may_be_less():
    scores, success = np.arange(20.0), np.arange(20) >= 10
    curve, pr = roc(scores, success, rng(), FEW), precision_recall(scores, success, rng(), FEW)
    assert curve is not None
    assert pr is not None
    assert curve.band is not None
    assert pr.band is not None
    assert (curve.band[0] == 1).all()
    assert (pr.band[0] == 1).all()
    assert (curve.area_interval[1], pr.area_interval[1]) == (1, 1)
    assert 0.7 < curve.area_interval[0] < 0.9
    assert pr.area_interval == wilson_interval(10, 10)


def test_few_of_an_outcome_have_no_band():
    scores, success = np.arange(19.0), np.arange(19) >= 10
    for draw in (roc, precision_recall):
        curve = draw(scores, success, rng(), FEW)
        assert curve is not None
        assert curve.band is None


def test_precision_recall_of_four_trials():
    # Precision 1 up to recall 1/2, then 2/3 up to recall 1: average 1/2 + 1/3.
    curve = precision_recall(np.array([3.0, 2.0, 1.0, 0.0]), np.array([T, F, T, F]), rng(), FEW)
    assert curve is not None
    assert curve.x.tolist() == [0.5, 0.5, 1, 1]
    assert curve.y == pytest.approx([1, 1 / 2, 2 / 3, 1 / 2])
    assert curve.area == pytest.approx(5 / 6)


def test_one_score_for_all_has_the_base_rate_as_precision():
    success = np.array([T, T, F, F, F])
    curve = precision_recall(np.zeros(5), success, rng(), FEW)
    assert curve is not None
    assert (curve.x.tolist(), curve.y.tolist(), curve.area) == ([1], [0.4], 0.4)
    assert curve.area_interval == wilson_interval(0.8, 2)


def test_curves_need_two_of_each():
    scores = np.array([1.0, 2.0, 3.0])
    assert roc(scores, np.array([T, F, F]), rng()) is None
    assert precision_recall(scores, np.array([T, F, F]), rng()) is None


@pytest.mark.parametrize(
    ("first", "second", "p"),
    [
        (0, 0, 1.0),
        (5, 5, 1.0),
        (1, 9, 22 / 1024),  # 2 (1 + 10) / 2^10
        (9, 1, 22 / 1024),
        (0, 6, 2 / 64),
        (3, 5, 2 * 93 / 256),  # 2 (1 + 8 + 28 + 56) / 2^8
    ],
)
def test_mcnemar_by_hand(first, second, p):
    assert mcnemar(first, second) == pytest.approx(p, rel=1e-12)


def test_pair_by_hand():
    first = np.array([2.0, 2.0, 2.0, 2.0, 0.5, 3.0])
    second = np.array([0.5, 0.5, 0.6, 1.5, 2.0, 0.1])
    success = np.array([T, F, T, T, F, T])
    pair = compare_pair(first, second, success, 1.0)
    # They agree on the fourth only.
    assert (pair.disagree.k, pair.n) == (5, 6)
    assert (pair.only_first_right, pair.only_second_right) == (4, 1)
    assert (pair.first_optimistic.k, pair.first_optimistic.n) == (3, 4)
    assert (pair.second_optimistic.k, pair.second_optimistic.n) == (0, 1)
    assert pair.p_value == pytest.approx(12 / 32)
    areas = [compare.auc(q, success) or 0.0 for q in (first, second)]
    assert pair.areas is not None
    assert pair.areas.value == pytest.approx(areas[0] - areas[1])
    assert pair.areas.interval is None  # of six trials


def test_area_difference_is_paired():
    scores, success = cases()
    same = compare_pair(scores, 0.5 * scores, success, 1.0)
    assert same.areas == (0.0, (0.0, 0.0), 1.0)
    ordered = np.arange(20.0)
    mirrored = compare_pair(ordered, -ordered, ordered >= 10, 1.0)
    assert mirrored.areas is not None
    assert mirrored.areas.value == 1.0


def test_best_threshold_of_separated_classes_is_the_middle():
    scores = np.array([0.0, 1, 2, 3, 10, 11, 12, 13])
    assert best_threshold(scores, scores > 5) == 6.5


def test_best_threshold_at_the_ends():
    scores = np.array([1.0, 2.0, 3.0])
    assert best_threshold(scores, np.array([T, T, T])) == -np.inf
    threshold = best_threshold(scores, np.array([F, F, F]))
    assert not (scores > threshold).any()


def test_best_threshold_between_infinite_scores():
    threshold = best_threshold(np.array([-np.inf, -np.inf, 2.0, 3.0]), np.array([F, F, T, T]))
    assert np.isfinite(threshold)
    assert threshold < 2.0
    assert best_threshold(np.array([1.0, 2.0, np.inf]), np.array([F, F, T])) == 2.0


@given(st.lists(st.tuples(st.integers(0, 6), st.booleans()), min_size=1, max_size=25))
def test_no_threshold_is_better_than_the_best(pairs):
    scores = np.array([float(score) for score, _ in pairs])
    success = np.array([flag for _, flag in pairs])
    best = np.mean((scores > best_threshold(scores, success)) == success)
    for threshold in np.arange(-1, 7, 0.5):
        assert np.mean((scores > threshold) == success) <= best


def test_cross_validation_finds_a_wide_gap():
    scores = np.concatenate((np.arange(20.0), np.arange(50.0, 70.0)))
    success = scores > 30
    found = cross_validate(scores, success, np.arange(40) % 10)
    assert found.accuracy.value == 1.0
    assert found.true_positive_rate.n == found.true_negative_rate.n == 20
    assert found.threshold == 34.5
    assert 19 < found.low <= found.high < 50


def test_cross_validation_does_not_see_the_fold_it_judges():
    # Each fold alone is separable, but at another place: the threshold of one is useless in the
    # other. On all trials together three of four would be right.
    scores, success = np.array([1.0, 2.0, 11.0, 12.0]), np.array([F, T, F, T])
    found = cross_validate(scores, success, np.array([0, 0, 1, 1]))
    assert found.accuracy.value == 0.5
    assert np.mean((scores > found.threshold) == success) == 0.75


def test_folds_spread_every_stratum():
    strata = np.array(["a"] * 23 + ["b"] * 8 + ["c"] * 19, dtype=object)
    fold = assign_folds(strata, rng(3), 10)
    for label in "abc":
        sizes = np.bincount(fold[strata == label], minlength=10)
        assert sizes.max() - sizes.min() <= 1
    sizes = np.bincount(fold, minlength=10)
    assert sizes.max() - sizes.min() <= 1
    assert (fold == assign_folds(strata, rng(3), 10)).all()
    assert (fold != assign_folds(strata, rng(4), 10)).any()


@pytest.mark.parametrize(
    ("target", "threshold"), [(0.0, 4.0), (0.24, 4.0), (0.25, 3.0), (0.5, 2.0), (1.0, -np.inf)]
)
def test_threshold_for_a_false_positive_rate(target, threshold):
    scores, success = np.array([1.0, 2, 3, 4, 9, 9]), np.array([F, F, F, F, T, T])
    assert threshold_for(scores, success, target) == threshold


def test_threshold_for_keeps_tied_failures_out():
    scores, success = np.array([2.0, 2.0, 2.0, 1.0]), np.array([F, F, F, F])
    assert threshold_for(scores, success, 0.5) == 2.0  # no half of a tie


def test_calibration_keeps_to_its_targets():
    scores, success = cases()
    fold = np.arange(80) % 10
    found = calibrate(scores, success, fold, rng(), FEW)
    assert found is not None
    for k, target in enumerate(found.targets):
        threshold = found.threshold[k]
        assert threshold == threshold_for(scores, success, target)
        assert (scores[~success] > threshold).mean() <= target + 1e-12
        assert found.tpr[k] == pytest.approx((scores[success] > threshold).mean())
        assert found.tpr_low[k] <= found.tpr[k] <= found.tpr_high[k]
    assert (np.diff(found.threshold) <= 0).all()
    assert (np.diff(found.tpr) >= 0).all()
    achieved = np.array([rate.value for rate in found.achieved], dtype=float)
    assert np.abs(achieved - found.targets).max() < 0.1
    assert all(rate.n == 45 for rate in found.achieved)


def test_a_bound_of_twice_the_load():
    load = np.linspace(0.5, 4.0, 30)
    found = agree(2 * load, load, np.zeros(30, dtype=bool), rng(), FEW)
    assert found.spearman == pytest.approx(1.0)
    assert found.ratio is not None
    assert (found.ratio.n, found.ratio.median) == (30, pytest.approx(2))
    assert found.ratio.median_interval == pytest.approx((2, 2))
    assert found.ratio.quartiles == pytest.approx((2, 2))
    assert found.ratio.spread == pytest.approx(1)
    assert found.below.k == 0


def test_zero_and_infinity_are_ratios():
    q = np.array([0.0, 2.0, -np.inf, 3.0, np.nan, 4.0])
    load = np.array([1.0, 0.0, 0.5, 6.0, 2.0, 20.0])
    capped = np.array([F, F, F, F, F, T])
    found = agree(q, load, capped, rng(), FEW)
    assert (found.n, found.capped) == (6, 1)
    assert (found.both, found.zero, found.dropped, found.neither) == (1, 3, 1, 0)
    assert (found.below.k, found.below.n) == (5, 6)
    assert sorted(load_ratios(q, load, capped)) == [0.0, 0.0, 0.0, 0.5, np.inf]
    assert found.ratio is not None
    assert (found.ratio.n, found.ratio.median) == (5, 0.0)
    assert found.ratio.spread == math.inf


def test_a_metric_that_says_zero_where_nothing_is_held_is_right():
    none = np.zeros(1, dtype=bool)
    assert load_ratios(np.array([-np.inf]), np.zeros(1), none) == [1.0]


def test_the_median_ratio_of_a_bound_that_is_always_zero_is_zero():
    # A selection of the trials with a ratio would show what few there are.
    q, load = np.r_[np.zeros(20), 1.2], np.ones(21)
    found = agree(q, load, np.zeros(21, dtype=bool), rng(), FEW)
    assert found.ratio is not None
    assert found.ratio.median == 0.0


def test_median_ratio_of_log_normal_ratios():
    # Median m and spread exp(s) of m exp(s N(0, 1)); quantiles at 16 and 84 % are about ±s.
    ratios = 0.7 * np.exp(0.3 * scipy.stats.norm.ppf((np.arange(4001) + 0.5) / 4001))
    found = summarise_ratios(ratios)
    assert found is not None
    assert found.median == pytest.approx(0.7, rel=1e-9)
    assert found.spread == pytest.approx(math.exp(0.3 * scipy.stats.norm.ppf(0.84)), rel=2e-3)
    low, high = found.median_interval
    assert low < 0.7 < high


def test_the_interval_of_a_median_is_that_of_the_binomial():
    # Of ten values the second and the ninth: 1 - 2 P(B(10, 1/2) <= 1) = 97.9 %.
    assert median_interval(np.arange(10.0)) == (1.0, 8.0)
    assert median_interval(np.arange(6.0)) == (0.0, 5.0)
    assert median_interval(np.arange(5.0)) == (0.0, math.inf)
    assert median_interval(np.r_[np.zeros(9), np.full(9, np.inf)]) == (0.0, math.inf)


def test_counts_of_what_a_metric_says_add_up():
    draw = rng(5)
    for _ in range(50):
        n = 30
        q = np.where(draw.random(n) < 0.4, draw.choice([0.0, -np.inf, np.nan], n), draw.random(n))
        load = np.where(draw.random(n) < 0.4, 0.0, draw.random(n))
        found = agree(q, load, draw.random(n) < 0.2, rng(), FEW)
        assert found.capped + found.both + found.zero + found.dropped + found.neither == found.n
        assert found.ratio is not None
        assert found.ratio.n == found.n - found.capped


def test_the_nearest_metric_is_told_with_its_certainty():
    near = {"a": np.full(30, 1.1), "b": np.full(30, 2.0)}
    assert find_nearest(near, rng(), FEW) == Nearest("a", 1.0, None)
    # One hair of difference in the median of noise: either may be nearest.
    noise = np.exp(rng(1).normal(size=31))
    found = find_nearest({"a": noise, "b": 1.001 / noise}, rng(), 500)
    assert found is not None
    assert found.share < 0.95
    assert find_nearest({}, rng()) is None


def test_success_can_be_predicted_throughout_with_scores_of_minus_infinity():
    # 77 successes, most of them at -inf, where the failures are above: nothing beats "all hold".
    scores = np.r_[np.full(77, -np.inf), np.arange(23.0)]
    success = np.arange(100) < 77
    assert best_threshold(scores, success) == -np.inf
    found = cross_validate(scores, success, np.arange(100) % 10)
    assert found.accuracy.value == 0.77
    # And a threshold can lie between -inf and the rest.
    lowest = best_threshold(np.r_[np.full(5, -np.inf), np.zeros(5)], np.arange(10) >= 5)
    assert -np.inf < lowest < 0
