"""Jobs in worker processes: their results in order, or as they are found."""

from __future__ import annotations

import math

import pytest

from sdh_sim.cli.worker_pool import run_all, run_each


def test_results_come_in_the_order_of_the_jobs_or_as_they_are_found():
    assert run_all(abs, [-3, 2, -1], "jobs", 2) == [3, 2, 1]
    assert sorted(run_each(abs, [-3, 2, -1], "jobs", 2)) == [1, 2, 3]
    assert list(run_each(abs, [], "jobs")) == []


def test_what_a_job_raises_comes_after_what_was_found_before_it():
    found = run_each(math.sqrt, [4.0, -1.0, 9.0], "jobs", 1)
    assert next(found) == 2.0
    with pytest.raises(ValueError, match=r"domain|nonnegative"):
        list(found)
