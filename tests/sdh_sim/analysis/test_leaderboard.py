"""Metrics side by side: what each value counts as, and tests against the best, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sdh_sim.analysis.leaderboard import Entrant, Outcomes, holm, rank_all

N = 40
SUCCESS = np.arange(N) >= N // 2
ALL = {"overall": np.ones(N, dtype=bool)}


def outcomes(**changes) -> Outcomes:
    found = {
        "success": SUCCESS,
        "fold": np.arange(N) % 10,
        "q_sim": np.arange(N) / 10.0,
        "displacement_mm": np.where(SUCCESS, 1.0, 100.0) + 0.01 * np.arange(N),
        "sensed": np.ones(N, dtype=bool),
    }
    return Outcomes(**{**found, **changes})


def entrant(name: str, values: np.ndarray, **facts) -> Entrant:
    return Entrant(name, name, "own", np.asarray(values, dtype=float), **facts)


def standing(entrants, name, **changes):
    board = rank_all(entrants, outcomes(**changes), ALL)
    return next(s for s in board.standings["overall"] if s.entrant.name == name)


def test_low_is_turned_round():
    high = entrant("high", np.arange(N))
    low = entrant("low", -1.0 * np.arange(N), high_is_good=False, threshold=-19.5)
    for name in ("high", "low"):
        s = standing([high, low], name)
        assert (s.auc, s.rank_load) == (1.0, pytest.approx(1.0))
        assert s.rank_motion is not None
        assert s.rank_motion > 0  # what is rated higher moves less
    assert standing([high, low], "low").own.value == 1.0


def test_no_value_is_the_worst_and_said():
    values = np.arange(N, dtype=float)
    values[0] = np.nan
    s = standing([entrant("some", values)], "some")
    assert (s.auc, s.missing, s.remarks) == (1.0, 1, "no value for 1")
    values[-1] = np.nan  # a success without a value ranks below all failures but the other
    assert standing([entrant("some", values)], "some").auc == pytest.approx(1 - 19.5 / 400)
    turned = entrant("low", -values, high_is_good=False)
    assert standing([turned], "low").auc == pytest.approx(1 - 19.5 / 400)


def test_infinite_and_constant_rank_where_they_belong():
    values = np.where(SUCCESS, math.inf, -math.inf)
    s = standing([entrant("edges", values)], "edges")
    assert (s.auc, s.infinite) == (1.0, N)
    assert s.best is not None
    assert s.best.accuracy.value == 1.0
    flat = standing([entrant("flat", np.full(N, 3.0))], "flat")
    assert (flat.auc, flat.constant, flat.rank_load) == (0.5, True, None)
    assert flat.remarks == "constant"
    none = standing([entrant("none", np.full(N, np.nan), fault="ValueError: no")], "none")
    assert none.auc == 0.5
    assert none.remarks == f"failed (ValueError: no); no value for {N}"


def test_grasps_that_no_pad_feels_are_no_remark():
    sensed = np.arange(N) > 2
    values = np.where(sensed, np.arange(N), -math.inf)
    assert standing([entrant("metric", values)], "metric", sensed=sensed).remarks == ""


def test_each_is_tested_against_the_best_on_the_same_trials():
    draw = np.random.default_rng(0)
    best = entrant("best", SUCCESS + 0.2 * draw.normal(size=N))
    twin = entrant("twin", best.values * 2.0)
    noise = entrant("noise", draw.normal(size=N))
    board = rank_all([noise, twin, best], outcomes(), ALL)
    found = {s.entrant.name: s for s in board.standings["overall"]}
    assert board.standings["overall"][0].behind is None
    second = board.standings["overall"][1]
    assert second.behind is not None
    assert second.behind.value == 0.0
    assert second.holm_p == 1.0
    last, first = found["noise"], found["best"]
    assert last.holm_p is not None
    assert last.holm_p < 1e-4
    assert last.auc is not None
    assert first.auc is not None
    assert last.behind is not None
    assert last.behind.value == pytest.approx(last.auc - first.auc)


def test_holm_by_hand():
    # Sorted .01, .02, .03: 3 × .01, 2 × .02, and not less than that before.
    assert holm([0.03, None, 0.01, 0.02]) == pytest.approx([0.04, None, 0.03, 0.04])
    assert holm([0.9, 0.8]) == [1.0, 1.0]
    assert holm([]) == []


def test_without_load_tests_and_with_one_outcome():
    s = standing([entrant("metric", np.arange(N))], "metric", q_sim=None)
    assert s.rank_load is None
    one = standing([entrant("metric", np.arange(N))], "metric", success=np.ones(N, dtype=bool))
    assert (one.auc, one.auc_interval, one.best, one.behind) == (None, None, None, None)


def test_two_of_a_name_and_other_lengths_are_refused():
    with pytest.raises(ValueError, match="twice"):
        rank_all([entrant("a", np.zeros(N)), entrant("a", np.zeros(N))], outcomes(), ALL)
    with pytest.raises(ValueError, match="a: expected"):
        rank_all([entrant("a", np.zeros(3))], outcomes(), ALL)
