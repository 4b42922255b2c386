"""The comparison's numbers against hand counts."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.comparison import compare_scores, compare_table
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.records import FAILURES, to_table

T, F = True, False


def test_hand_counted_confusion():
    #            tp   tp   fn   fp   tn   tn   tn   (1.0 is not above 1; null is 0)
    scores = [2.0, 1.5, 1.0, 1.1, 0.2, 0.9, np.nan]
    success = [T, T, T, F, F, F, F]
    result = compare_scores(np.array(scores), np.array(success))
    assert (result.tp, result.fn, result.fp, result.tn) == (2, 1, 1, 3)
    assert result.n == 7
    assert result.success.value == 3 / 7
    assert result.accuracy.value == 5 / 7
    assert result.true_positive_rate.value == 2 / 3
    assert result.false_positive_rate.value == 1 / 4
    assert result.missing == 1
    # Of the 12 pairs of a success and a failure only (1.0, 1.1) is in the wrong order.
    assert result.auc == 11 / 12


def test_a_missing_score_ranks_as_zero_not_below():
    result = compare_scores(np.array([0.0, np.nan]), np.array([T, F]))
    assert result.auc == 0.5


def test_infinite_scores_rank():
    result = compare_scores(np.array([np.inf, -np.inf, 0.5]), np.array([T, F, F]))
    assert result.auc == 1.0
    assert (result.tp, result.tn) == (1, 2)


def test_a_proportion_of_no_trials_is_undefined():
    assert Proportion(0, 0).value is None
    assert Proportion(0, 0).interval is None
    result = compare_scores(np.array([2.0, 0.5]), np.array([T, T]))
    assert result.false_positive_rate.value is None
    assert result.true_positive_rate.value == 0.5
    assert result.auc is None
    assert result.auc_interval is None
    empty = compare_scores(np.array([]), np.array([], dtype=bool))
    assert empty.n == 0
    assert empty.accuracy.value is None


def test_perfect_separation_and_its_mirror():
    scores, success = np.arange(8.0), np.arange(8) >= 4
    assert compare_scores(scores, success).auc == 1.0
    assert compare_scores(-scores, success).auc == 0.0


def test_shapes_that_do_not_match_are_refused():
    with pytest.raises(ValueError, match=r"\(2,\) and success \(3,\)"):
        compare_scores(np.zeros(2), np.zeros(3, dtype=bool))


def table(rows):
    return to_table(
        {
            "trial": i,
            "object": name,
            "seed": i,
            "success": failure == "none",
            "failure": failure,
            "q_linf": q_linf,
            "q_l1": q_l1,
        }
        for i, (name, failure, q_linf, q_l1) in enumerate(rows)
    )


ROWS = [
    ("box", "none", 2.0, 0.9),
    ("box", "slipped", 1.2, 0.4),
    ("box", "unstable_simulation", 9.0, 9.0),
    ("box", "no_contact", None, None),
    ("oval_bottle", "none", 0.8, 0.3),
    ("oval_bottle", "dropped", 0.5, 0.2),
]


def test_table_by_object_and_overall():
    results = compare_table(table(ROWS))
    assert [(r.group, r.metric) for r in results] == [
        (group, metric)
        for group in ("box", "oval_bottle", "overall")
        for metric in ("q_linf", "q_l1")
    ]
    box, _, bottle, _, overall, overall_l1 = results
    assert (box.tp, box.fp, box.tn, box.fn) == (1, 1, 1, 0)
    assert (box.unstable, box.missing) == (1, 1)
    assert (bottle.tp, bottle.fp, bottle.tn, bottle.fn) == (0, 0, 1, 1)
    assert bottle.auc == 1.0
    assert (overall.n, overall.unstable, overall.missing) == (5, 1, 1)
    assert overall.auc == pytest.approx(5 / 6)
    assert (overall_l1.tp, overall_l1.fp) == (0, 0)
    assert overall_l1.auc == pytest.approx(5 / 6)


def test_trials_without_contact_are_counted_apart():
    # Of the box's three trials two are predicted rightly; one of these never touched it.
    box, box_l1, bottle, *_ = compare_table(table(ROWS))
    assert (box.no_contact, box.no_contact_right) == (1, 1)
    assert (box.accuracy.k, box.accuracy.n) == (2, 3)
    assert (box.accuracy_touching.k, box.accuracy_touching.n) == (1, 2)
    assert (box_l1.accuracy_touching.k, box_l1.accuracy_touching.n) == (1, 2)
    assert box.carried  # 67 % with them, 50 % without
    assert (bottle.no_contact, bottle.carried) == (0, False)
    assert bottle.accuracy_touching == bottle.accuracy
    never = compare_table(table([("box", "no_contact", None, None)] * 3))[0]
    assert never.accuracy.value == 1.0
    assert never.accuracy_touching.value is None
    assert never.carried
    # A metric that predicts success without contact is wrong about it, and gains nothing.
    wrong = compare_table(table([*ROWS[:2], ("box", "no_contact", 3.0, 3.0)]))[0]
    assert (wrong.no_contact, wrong.no_contact_right, wrong.carried) == (1, 0, False)


def test_one_object_has_no_overall():
    assert [r.group for r in compare_table(table(ROWS[:4]))] == ["box", "box"]


def test_csv_row_matches_the_header():
    result = compare_table(table(ROWS))[0]
    cells = dict(zip(compare.CSV_HEADER, compare.csv_row(result), strict=True))
    assert cells["object"] == "box"
    assert cells["tp"] == "1"
    assert float(cells["accuracy"]) == 2 / 3
    assert cells["unstable_excluded"] == cells["missing_metric"] == "1"
    only = compare_table(table(ROWS[:1]))[0]
    cells = dict(zip(compare.CSV_HEADER, compare.csv_row(only), strict=True))
    assert cells["auc"] == cells["false_positive_rate"] == cells["fpr_low"] == ""


@pytest.mark.parametrize("failure", ["unstable_simulation", "error"])
def test_trials_without_an_outcome_do_not_count(failure):
    assert failure in FAILURES
    result = compare_table(table([*ROWS[:2], ("box", failure, 9.0, 9.0)]))[0]
    assert (result.n, result.unstable) == (2, 1)


def test_rates_of_failures_add_up():
    result = compare_scores(np.array([2.0, 0.5, 3.0]), np.array([T, F, F]))
    assert (result.true_negative_rate.k, result.false_positive_rate.k) == (1, 1)
    assert result.true_negative_rate.n == 2
    cells = dict(zip(compare.CSV_HEADER, compare.csv_row(result), strict=True))
    assert cells["true_negative_rate"] == "0.5"


def test_a_volume_has_no_boundary_and_no_zero():
    full = to_table(
        {"trial": i, "object": "box", "seed": i, "success": i > 1,
         "failure": "none" if i > 1 else "dropped", "volume_l1": (None, 2.0, 1.0, 3.0)[i]}
        for i in range(4)
    )  # fmt: skip
    (result,) = compare_table(full, ("volume_l1",))
    assert (result.n, result.missing, result.auc) == (3, 1, 0.5)
    assert not result.has_boundary
    cells = dict(zip(compare.CSV_HEADER, compare.csv_row(result), strict=True))
    assert cells["threshold"] == cells["accuracy"] == cells["tp"] == ""
    assert cells["n"] == "3"


def test_infeasible_trials_are_counted_apart():
    rows = [*ROWS[:2], ("box", "error", 9.0, 9.0), *[("box", "infeasible", None, None)] * 2]
    result = compare_table(table(rows))[0]
    assert (result.n, result.unstable, result.infeasible) == (2, 1, 2)
    cells = dict(zip(compare.CSV_HEADER, compare.csv_row(result), strict=True))
    assert (cells["unstable_excluded"], cells["infeasible_excluded"]) == ("1", "2")
    nothing_tried = compare_table(table([("box", "infeasible", None, None)] * 2))[0]
    assert (nothing_tried.n, nothing_tried.infeasible, nothing_tried.auc) == (0, 2, None)


def test_a_trial_without_an_outcome_is_no_surplus():
    # Tables of earlier versions flag both; the second is one that diverged, and counts as that.
    rows = [
        {"trial": k, "object": "box", "seed": k, "success": False, "failure": failure}
        | {"q_linf": 1.0, "q_l1": 1.0, "surplus": surplus}
        for k, (failure, surplus) in enumerate(
            [("slipped", True), ("unstable_simulation", True), ("slipped", False)]
        )
    ]
    first = compare_table(to_table(rows))[0]
    assert (first.n, first.unstable) == (1, 1)
