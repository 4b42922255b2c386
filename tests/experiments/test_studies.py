"""Sensitivity and gallery: what each assumption changes, which trials are the clearest."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import gallery, load_rates, repeatability, sensitivity, sensor_study
from sdh_sim.objects import object_info
from sdh_sim.trial.outcome import moved_between
from tests.support import sdh2

LIMITS = (1.6401, 1.0934)


@pytest.fixture
def grasp():
    """Thumb against two fingers on an upright bottle, four taxels each."""
    distal = np.zeros((3, 13, 6))
    distal[:, 7:9, 2:4] = 50.0
    pose = np.array([0.0, 0.0, 0.2, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])
    hand = np.array([0.5, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0])
    snapshot = sdh2.snapshot(
        np.zeros((3, 14, 6)), distal, np.zeros(7), np.zeros(7), pose, hand
    )  # fmt: skip
    return snapshot, object_info("cylindrical_bottle"), LIMITS


def change(grasp, key, value):
    return sensitivity.changed(
        grasp, sensitivity.Setting(key, value), np.random.default_rng(0)
    )  # fmt: skip


@pytest.mark.parametrize("key", list(sensitivity.ASSUMPTIONS))
def test_the_default_value_changes_nothing(grasp, key):
    default = sensitivity.ASSUMPTIONS[key].default
    snapshot, obj, limits = change(grasp, key, default)
    assert np.array_equal(snapshot.distal, grasp[0].distal)
    assert snapshot.object_pose_hand == pytest.approx(grasp[0].object_pose_hand, abs=1e-15)
    assert (obj.mass_kg, obj.friction) == (grasp[1].mass_kg, grasp[1].friction)
    assert obj.com_m == pytest.approx(grasp[1].com_m)
    assert limits == LIMITS


def test_each_assumption_changes_its_own(grasp):
    assert change(grasp, "friction", 1.5)[1].friction == pytest.approx(1.5 * 0.60)
    assert change(grasp, "mass", 0.5)[1].mass_kg == pytest.approx(0.278)
    assert change(grasp, "torque", 2.0)[2] == pytest.approx((3.2802, 2.1868))
    assert change(grasp, "offset", 10.0)[1].com_m[2] - grasp[1].com_m[2] == pytest.approx(0.01)
    assert not change(grasp, "threshold", 50.0)[0].distal.any()
    assert change(grasp, "dead", 100.0)[0].distal.sum() == 0.0
    noisy = change(grasp, "noise", 20.0)[0].distal
    assert (noisy[grasp[0].distal > 0] != 50.0).all()
    assert not noisy[grasp[0].distal == 0].any()
    before, com = grasp[0].object_pose_hand, np.zeros(3)
    shifted = moved_between(before, change(grasp, "position", 4.0)[0].object_pose_hand, com)
    turned = moved_between(before, change(grasp, "rotation", 4.0)[0].object_pose_hand, com)
    assert shifted[0] > 0.5
    assert shifted[1] == pytest.approx(0.0, abs=1e-5)
    assert turned[0] == pytest.approx(0.0, abs=1e-9)
    assert turned[1] > 0.5


def test_half_the_mass_doubles_q(grasp):
    q = [
        sensitivity.scores(sensitivity.Setting("mass", value), [grasp, None], "distal", 0)
        for value in (1.0, 0.5)
    ]
    assert (q[0][0] > 0).all()
    assert q[1][0] == pytest.approx(2 * q[0][0], rel=1e-6)
    assert q[0][1].tolist() == [0.0, 0.0]  # no snapshot


def test_clearest_mispredictions_come_first_and_surplus_errors_are_left_out():
    rows = [
        {"success": s, "failure": f, "q_linf": q, "displacement_mm": m}
        for s, f, q, m in (
            (True, "none", 0.0, 5.0), (True, "none", 0.0, 1.0), (True, "none", 0.9, 1.0),
            (True, "none", 3.0, 1.0), (False, "dropped", 2.0, 80.0), (False, "slipped", 5.0, 20.0),
            (False, "dropped", 0.5, 80.0), (False, "error", 9.0, None), (False, "none", None, 1.0),
        )
    ]  # fmt: skip
    missed, alarms = gallery.mispredicted(rows, "q_linf", 2).values()
    assert [r["q_linf"] for r in missed] == [5.0, 2.0]
    assert [(r["q_linf"], r["displacement_mm"]) for r in alarms] == [(0.0, 1.0), (0.0, 5.0)]


@pytest.mark.parametrize(
    ("module", "arguments"),
    [(sensitivity, ["/nowhere"]), (gallery, ["/nowhere"])],
)
def test_a_missing_run_is_one_line(module, arguments, capsys):
    assert module.main(arguments) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        (repeatability, ["--grasps", "-1"]),
        (load_rates, ["--grasps", "0"]),
        (sensor_study, ["--grasps", "1"]),
    ],
)
def test_numbers_out_of_range_are_refused(module, arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        module.main(arguments)
    assert stop.value.code == 2
    assert "must" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("scores", "area"), [((2.0, 1.0), 1.0), ((1.0, 1.0), 0.5), ((1.0, 2.0), 0.0)]
)
def test_an_area_of_zero_is_not_taken_for_chance(scores, area):
    held = np.array([True, False])
    assert sensor_study.area_text(np.array(scores), held) == f"{area:.3f}"
    assert sensitivity.summary(np.array(scores), held)[0] == area


def test_outcomes_that_are_all_alike_have_no_area():
    assert sensor_study.area_text(np.ones(2), np.array([True, True])) == "–"
