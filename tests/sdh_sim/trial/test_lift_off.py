"""The snapshot at lift-off: when it is taken, what it tells, and what it leaves alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sdh_sim.cell import build_scene
from sdh_sim.cell.contacts import forces_on_object
from sdh_sim.cell.scene import HAND_GEOM
from sdh_sim.cli import main
from sdh_sim.errors import SettingsError
from sdh_sim.records import LIFT_OFF, SNAPSHOT, TrialRow, read_rows
from sdh_sim.sensing import GRAVITY
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, lift, run_trial
from sdh_sim.trial.outcome import moved_between

PLAIN = TrialSettings("box", grasps="precision", pads="distal")
ASKED = replace(PLAIN, lift_off=True)
HELD, SLIPPED = 3, 8  # seeds: one leaves the table, one never does


@pytest.fixture(scope="module")
def held() -> TrialRow:
    return run_trial(ASKED, HELD).row


@pytest.fixture(scope="module")
def slipped() -> TrialRow:
    return run_trial(ASKED, SLIPPED).row


def test_the_first_snapshot_is_that_of_a_plain_trial(held: TrialRow):
    plain = run_trial(PLAIN, HELD).row
    for name in SNAPSHOT:
        assert np.array_equal(held[name], plain[name]) or held[name] == plain[name], name
    assert held.failure == plain.failure == "none"
    assert not any(name.startswith(LIFT_OFF) for name in plain)


def test_an_object_that_is_held_has_left_the_table(held: TrialRow):
    assert held[LIFT_OFF + "on_table"] is False
    assert 0.0 < held[LIFT_OFF + "rise_mm"] < 1e3 * lift.LARGEST_RISE + 1.0
    # The hand alone bears it: what the motors squeeze with goes through the hand.
    assert held[LIFT_OFF + "displacement_mm"] <= held["displacement_mm"] + 1e-9
    before, now = held["object_pose_hand"], held[LIFT_OFF + "object_pose_hand"]
    scene = Trial(PLAIN, HELD).scene
    moved = moved_between(before, now, scene.obj.com_m)
    assert moved[0] == pytest.approx(held[LIFT_OFF + "displacement_mm"], abs=1e-9)


def test_the_hand_bears_the_weight_of_an_object_that_has_left_the_table():
    # At rest off the table the contact forces on the object add up to its weight.
    trial = Trial(ASKED, HELD)
    trial.acquire()
    trial.lift_off()
    forces = forces_on_object(trial.scene, trial.simulation.data).forces
    weight = trial.scene.obj.mass_kg * GRAVITY
    assert forces.sum(axis=0) == pytest.approx([0.0, 0.0, weight], abs=0.01 * weight)


def test_an_object_that_sinks_back_to_the_table_is_raised_further():
    row = run_trial(replace(ASKED, object="oval_bottle"), 1).row
    assert row.success
    assert row[LIFT_OFF + "on_table"] is False


def test_an_object_that_never_leaves_the_table_says_so(slipped: TrialRow):
    assert not slipped.success
    assert slipped[LIFT_OFF + "on_table"] is True
    assert slipped[LIFT_OFF + "rise_mm"] == pytest.approx(1e3 * lift.LARGEST_RISE, abs=0.6)


def test_a_hand_that_touches_nothing_has_no_second_snapshot():
    # Without collision the hand closes through the object.
    scene = build_scene(ASKED)
    trial = Trial(ASKED, HELD, scene=scene)
    hand = scene.geom_group == HAND_GEOM
    scene.model.geom_contype[hand] = scene.model.geom_conaffinity[hand] = 0
    row = trial.run()
    assert row.failure == "no_contact"
    assert not any(name.startswith(LIFT_OFF) for name in row)


def test_lift_off_needs_a_table():
    with pytest.raises(SettingsError, match="lift_off: got True; with support none"):
        replace(ASKED, support="none")
    with pytest.raises(SettingsError, match="lift_off: got 'yes'; give true or false"):
        replace(PLAIN, lift_off="yes")


@pytest.mark.parametrize("hand", ["schunk_sdh2", "parallel_jaw"])
def test_a_run_keeps_and_compares_both_moments(hand: str, tmp_path: Path, capsys):
    out = tmp_path / "run"
    asked = ["lift", "--object", "box", "--trials", "2", "--seed", "5", "--lift-off"]
    assert main([*asked, "--hand", hand, "--workers", "1", "--out", str(out)]) == 0
    rows = read_rows(out / "trials.parquet")
    for row in rows:
        if row.failure != "no_contact":
            arrays = [n for n in row if n.startswith(LIFT_OFF + "tactile_") and row[n] is not None]
            assert arrays
            for name in arrays:
                assert row[name].shape == row[name.removeprefix(LIFT_OFF)].shape
            assert row[LIFT_OFF + "joint_angles_rad"].shape == row["joint_angles_rad"].shape
    capsys.readouterr()
    assert main(["compare", str(out)]) == 0
    assert "at lift-off" in capsys.readouterr().out
    page = (out / "report" / "index.html").read_text()
    assert "Before the lift and when the table has gone" in page


def test_copies_rise_as_the_trial_does(held: TrialRow):
    failure, motion = Trial(ASKED, HELD).grasp_and_lift()
    assert (failure, *motion[:2]) == (held.failure, held.displacement_mm, held.rotation_deg)
