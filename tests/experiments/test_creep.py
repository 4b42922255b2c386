"""Creep of held objects: in inverse proportion to impratio, and mostly friction."""

from __future__ import annotations

import pytest

from experiments import creep
from experiments.creep import Creep, Job, table_of, watch


def test_creep_is_in_inverse_proportion_to_impratio():
    found = {ratio: watch(Job("box", None, 3, ratio)) for ratio in creep.RATIOS}
    slow, fast = found[1000.0], found[100.0]
    assert slow is not None
    assert fast is not None
    assert fast.speed / slow.speed == pytest.approx(10.0, rel=0.25)
    assert slow.speed < 10.0
    # The object moves past the fingers, which hardly move.
    assert fast.fingers < 0.3 * fast.speed


def test_a_grasp_that_does_not_hold_is_left_out():
    assert watch(Job("cylindrical_bottle", None, 3, 1000.0)) is None


def test_the_table_has_medians_and_the_worst():
    found = [Creep("box", 100.0, speed, 1.0, 0.5, 1) for speed in (1.0, 2.0, 9.0)]
    (_, _, held, speed, *_) = [list(c.cells)[0] for c in table_of(found, 1).columns]
    assert (held, speed) == ("3", "2.0 (9.0)")


def test_a_folder_that_is_none_is_refused(tmp_path):
    with pytest.raises(SystemExit):
        creep.main(["--object", str(tmp_path / "nothing")])
