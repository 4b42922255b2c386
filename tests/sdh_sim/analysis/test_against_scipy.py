"""Proportions, areas and rank correlations against SciPy and their definitions, to 1e-12."""

from __future__ import annotations

import itertools
import subprocess
import sys

import numpy as np
import pytest
import scipy.stats
from hypothesis import example, given, settings
from hypothesis import strategies as st

from sdh_sim.analysis.comparison import auc
from sdh_sim.analysis.load_agreement import agree, spearman
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.resampling import RankedScores, stratified_weights

Z95 = 1.959963984540054  # 97.5 % quantile of the standard normal distribution
SCORES = st.sampled_from([-np.inf, 0.0, 0.5, 1.0, 1.5, 2.0, np.inf])
FEW = 300  # resamples


def bounds(k: int, n: int) -> tuple[float, float]:
    found = Proportion(k, n).interval
    assert found is not None
    return found


COUNTS = st.integers(1, 3000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@given(COUNTS)
@example((440, 584))
@settings(deadline=None)
def test_wilsons_interval_is_scipys(counts):
    expected = scipy.stats.binomtest(*counts).proportion_ci(0.95, method="wilson")
    assert bounds(*counts) == pytest.approx((expected.low, expected.high), abs=1e-12)


@given(COUNTS)
def test_wilsons_interval_holds_what_its_score_test_does_not_reject(counts):
    k, n = counts
    for p in bounds(k, n):
        assert (k / n - p) ** 2 == pytest.approx(Z95**2 * p * (1 - p) / n, abs=1e-12)
    low, high = bounds(k, n)
    assert 0 <= low <= k / n <= high <= 1
    assert (1 - high, 1 - low) == pytest.approx(bounds(n - k, n), abs=1e-12)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 10, 49, 100, 584, 4096, 99_991])
def test_wilsons_interval_is_exact_at_its_ends(n):
    width = Z95**2 / (n + Z95**2)
    assert bounds(0, n) == (0.0, pytest.approx(width, abs=1e-12))
    assert bounds(n, n) == (pytest.approx(1 - width, abs=1e-12), 1.0)


def test_a_proportion_does_not_wait_for_scipy():
    code = (
        "import sys; from sdh_sim.analysis.proportion import Proportion; "
        "assert Proportion(3, 4).interval; sys.exit('scipy' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@given(st.lists(st.tuples(SCORES, st.booleans()), min_size=2, max_size=40))
@settings(deadline=None)
def test_area_is_the_share_of_pairs_in_order(pairs):
    scores = np.array([score for score, _ in pairs])
    success = np.array([flag for _, flag in pairs])
    good, bad = scores[success], scores[~success]
    area = auc(scores, success)
    if not len(good) or not len(bad):
        assert area is None
        return
    by_pairs = np.mean([(g > b) + 0.5 * (g == b) for g, b in itertools.product(good, bad)])
    assert area == pytest.approx(by_pairs, abs=1e-12)
    assert RankedScores.of(scores, success).roc_areas() == pytest.approx(area, abs=1e-12)


@pytest.mark.parametrize("score", [0.0, 1.5, np.inf, -np.inf])
@pytest.mark.parametrize("successes", [1, 2, 5, 9])
def test_area_of_equal_scores_is_one_half(score, successes):
    assert auc(np.full(10, score), np.arange(10) < successes) == 0.5


def test_resampled_areas_are_those_of_mann_whitney():
    rng = np.random.default_rng(5)
    success = np.arange(80) % 3 == 0
    scores = np.round(rng.normal(size=80) + success, 1)  # rounded: ties
    (weights,) = stratified_weights(success, rng, FEW)
    areas = RankedScores.of(scores, success).roc_areas(weights)
    for row, area in zip(weights, areas, strict=True):
        good, bad = np.repeat(scores, row * success), np.repeat(scores, row * ~success)
        u = scipy.stats.mannwhitneyu(good, bad).statistic
        assert area == pytest.approx(u / (len(good) * len(bad)), abs=1e-12)


@given(st.lists(st.tuples(SCORES, st.sampled_from([0.0, 1.0, 2.0, 3.5])), max_size=30))
@settings(deadline=None)
def test_spearman_is_the_correlation_of_mean_ranks(pairs):
    x = np.array([a for a, _ in pairs])
    y = np.array([b for _, b in pairs])
    found = spearman(x, y)
    if len(pairs) < 3 or len(set(x)) == 1 or len(set(y)) == 1:
        assert found is None
        return
    ranks = [[(v < w).sum() + 0.5 * (v == w).sum() for w in v] for v in (x, y)]
    assert found == pytest.approx(np.corrcoef(ranks)[0, 1], abs=1e-12)


def test_spearman_with_ties_is_scipys():
    rng = np.random.default_rng(2)
    x = np.round(rng.normal(size=60), 1)
    y = np.round(x + rng.normal(size=60))
    assert spearman(x, y) == pytest.approx(scipy.stats.spearmanr(x, y).statistic, abs=1e-12)
    assert spearman(x, -x) == pytest.approx(-1.0, abs=1e-12)


def test_interval_of_the_rank_correlation_is_that_of_scipys_on_the_same_resamples():
    rng = np.random.default_rng(8)
    load = np.round(rng.uniform(0.5, 3, 40), 1)
    q = np.round(load * np.exp(0.5 * rng.normal(size=40)), 1)
    found = agree(q, load, np.zeros(40, dtype=bool), np.random.default_rng(1), FEW)
    draws = np.random.default_rng(1).integers(40, size=(FEW, 40))
    plain = [scipy.stats.spearmanr(q[drawn], load[drawn]).statistic for drawn in draws]
    assert found.spearman_interval == pytest.approx(np.quantile(plain, [0.025, 0.975]), abs=1e-12)
