"""The comparison of two moments, on a table made by hand."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from sdh_sim.analysis.moments import compare_moments

BEFORE = [2.0, 2.0, 0.5, 0.5, 2.0, 0.2]
AFTER = [2.0, 1.5, 1.2, 0.5, 0.5, None]
SUCCESS = [True, True, True, False, False, False]


def table() -> pa.Table:
    return pa.table(
        {
            "success": SUCCESS,
            "q_linf": pa.array(BEFORE, pa.float64()),
            "liftoff_q_linf": pa.array(AFTER, pa.float64()),
            "liftoff_on_table": pa.array([False, False, False, True, True, None], pa.bool_()),
            "q_l1": pa.array(BEFORE, pa.float64()),  # not there at lift-off: not compared
        }
    )


def test_both_moments_are_compared_on_the_same_trials():
    (found,) = compare_moments(table(), np.ones(6, dtype=bool))
    assert (found.before.metric, found.after.metric) == ("q_linf", "liftoff_q_linf")
    # The last trial has no second snapshot.
    assert found.before.n == found.after.n == 5
    assert (found.before.accuracy.k, found.after.accuracy.k) == (3, 5)
    assert (found.before.fp, found.after.fp) == (1, 0)
    assert found.after.auc == 1.0
    assert found.before.auc is not None
    assert found.after.auc is not None
    # Pairs of a success and a failure: (2, 2, 0.5) against (0.5, 2) has 2 won, 3 tied of 6.
    assert found.before.auc == pytest.approx((2 + 0.5 * 3) / 6)
    assert (found.paired.only_first_right, found.paired.only_second_right) == (2, 0)
    assert found.paired.areas is not None
    assert found.paired.areas.value == pytest.approx(found.after.auc - found.before.auc)


def test_where_a_grasp_settles_is_a_moment_too():
    more = table().append_column("settled", pa.array([True] * 5 + [None], pa.bool_()))
    more = more.append_column("settled_q_l1", pa.array(AFTER, pa.float64()))
    found = compare_moments(more, np.ones(6, dtype=bool))
    assert [m.moment for m in found] == ["liftoff_", "settled_"]
    assert found[1].after.metric == "settled_q_l1"
    assert found[1].after.accuracy == found[0].after.accuracy


def test_trials_without_an_outcome_are_left_out():
    usable = np.array([True, True, True, True, False, True])
    (found,) = compare_moments(table(), usable)
    assert found.before.n == 4
