"""The interval of the area under the ROC curve keeps its promise; DeLong's test of two areas."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats

from sdh_sim.analysis.roc_area import auc, auc_interval, compare_areas

T, F = True, False


def test_newcombes_interval_of_a_perfect_separation():
    # At area 1 the sample's own variance is 0 and says nothing: the lower end x solves
    # (1 - x)^2 = 1.96^2 x (1 - x) (1 + half ((1 - x) / (2 - x) + x / (1 + x))) / (m n).
    success = np.arange(8) >= 2
    low, high = auc_interval(np.arange(8.0), success) or (0, 0)
    assert high == 1.0
    pairs = (1 - low) / (2 - low) + low / (1 + low)
    variance = low * (1 - low) * (1 + 3 * pairs) / 12
    assert (1 - low) ** 2 == pytest.approx(1.959963984540054**2 * variance)
    assert auc_interval(-np.arange(8.0), success) == pytest.approx((0.0, 1.0 - low))


def test_no_interval_without_both_outcomes():
    assert auc_interval(np.arange(3.0), np.array([T, T, T])) is None
    assert auc(np.arange(3.0), np.array([F, F, F])) is None
    low, high = auc_interval(np.array([0.0, 1.0]), np.array([F, T])) or (1, 0)
    assert low == pytest.approx(1 / (1 + 1.959963984540054**2))  # one pair says little
    assert high == 1.0


def test_interval_of_many_is_delongs():
    draw = np.random.default_rng(0)
    success = np.arange(4000) % 2 == 0
    scores = draw.normal(size=4000) * np.where(success, 0.3, 1.0) + success
    low, high = auc_interval(scores, success) or (0, 0)
    good, bad = scores[success], scores[~success]
    above = (good[:, None] > bad).mean(axis=1)
    below = (good[:, None] > bad).mean(axis=0)
    sd = np.sqrt(above.var(ddof=1) / 2000 + below.var(ddof=1) / 2000)
    assert high - low == pytest.approx(2 * 1.96 * sd, rel=0.02)


# Trials of either outcome; what is tested is that few of them get intervals wide enough.
@pytest.mark.parametrize("sizes", [(6, 2), (3, 10), (10, 10), (60, 3), (60, 40)])
@pytest.mark.parametrize("shape", ["even", "good", "separated", "wide", "many zeros"])
def test_coverage(sizes, shape):
    shift, spread = {
        "even": (0.0, 1.0), "good": (1.8, 1.0), "separated": (3.0, 1.0), "wide": (3.0, 3.3),
        "many zeros": (1.0, 1.0),
    }[shape]  # fmt: skip
    draw = np.random.default_rng(1)
    zeros = (0.05, 0.5) if shape == "many zeros" else (0.0, 0.0)
    ranked = scipy.stats.norm.cdf(shift / np.hypot(1.0, spread))
    (a, b) = zeros
    true = (1 - a) * (1 - b) * ranked + (1 - a) * b + 0.5 * a * b
    success = np.arange(sum(sizes)) < sizes[0]
    draws, held = 400, 0
    for _ in range(draws):
        good = np.exp(draw.normal(shift, spread, sizes[0])) * (draw.random(sizes[0]) >= a)
        bad = np.exp(draw.normal(0.0, 1.0, sizes[1])) * (draw.random(sizes[1]) >= b)
        low, high = auc_interval(np.r_[good, bad], success) or (1, 0)
        held += low <= true <= high
    # 90 % and more, three standard errors of this simulation below.
    assert held / draws > 0.9 - 3 * np.sqrt(0.9 * 0.1 / draws)


def test_delongs_test_keeps_its_level_and_finds_a_difference():
    draw = np.random.default_rng(2)
    success = np.arange(60) < 30
    rejected = 0
    for _ in range(400):
        common = draw.normal(size=60) + success
        first, second = common + draw.normal(size=60), common + draw.normal(size=60)
        found = compare_areas(first, second, success)
        assert found is not None
        assert found.p_value is not None
        assert found.interval is not None
        rejected += found.p_value < 0.05
        assert (found.p_value < 0.05) == (not found.interval[0] <= 0 <= found.interval[1])
    assert 0.02 < rejected / 400 < 0.09
    better = compare_areas(success + 0.1 * draw.normal(size=60), draw.normal(size=60), success)
    assert better is not None
    assert better.p_value is not None
    assert better.p_value < 1e-6
