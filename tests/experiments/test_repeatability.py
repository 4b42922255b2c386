"""How sure labels are: what is counted as a flip, and that the copies are the trials'."""

from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from experiments import repeatability
from experiments.repeatability import VARIANTS, Label, Pair
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial


def shown(pairs: list[Pair]) -> list[list[str]]:
    out = io.StringIO()
    Console(file=out, width=200).print(repeatability.step_table(pairs, 0))
    rows = [line for line in out.getvalue().splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in row.strip("│").split("│")] for row in rows]


def test_motions_are_alike_within_a_millimetre_and_a_degree():
    a = Label(True, 9.5, 3.0)
    assert a.near(Label(False, 10.4, 3.9))
    assert not a.near(Label(False, 10.6, 3.0))
    assert not a.near(Label(False, 9.5, 4.1))
    assert not a.near(Label(False, float("nan"), float("nan")))


def test_the_table_counts_flips_and_how_far_held_objects_moved():
    same = Label(True, 1.0, 0.5)
    straddles, falls = Label(False, 1.9, 0.5), Label(False, 80.0, 40.0)
    further = Label(True, 1.3, 0.5)
    rest = (same,) * (len(VARIANTS) - 1)
    pairs = [Pair(same, (other, *rest)) for other in (straddles, falls, further, same)]
    rows = shown(pairs)
    assert [row[0] for row in rows] == [v.name for v in VARIANTS]
    assert rows[0][1:4] == ["2 of 4", "15.0 to 85.0 %", "1"]
    assert float(rows[0][4]) == pytest.approx(0.15)  # median of 0.3 and 0 mm
    for row in rows[1:]:
        assert row[1] == "0 of 4"
        assert row[3] == "0"
        assert float(row[4]) == 0.0


def test_a_pair_is_the_trial_and_its_variants():
    job = ("cylindrical_bottle", 1)
    found = repeatability.pair(job)
    row = run_trial(TrialSettings(job[0]), job[1]).row
    expected = (row["success"], row["displacement_mm"], row["rotation_deg"])
    assert tuple(found.usual) == expected
    assert len(found.others) == len(VARIANTS)
    # Every variant is another simulation; a sure grasp stays sure.
    moved = [found.usual.moved, *(other.moved for other in found.others)]
    assert len(set(moved)) == len(moved)
    assert np.ptp(moved) < 1.0
    assert found.usual.held
    assert all(other.held for other in found.others)
    finer = run_trial(TrialSettings(job[0], timestep=0.001), job[1]).row
    assert found.others[0].moved == finer["displacement_mm"]
