"""Disturbances, perturbed copies, tracking errors and the rigid arm: what each option changes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sdh_sim.cell import Simulation, build_scene
from sdh_sim.objects import object_info
from sdh_sim.sensing import TactileSnapshot, add_tracking_error
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import disturbance, run_trial
from sdh_sim.trial.outcome import moved_between
from tests.support import sdh2

BOTTLE = TrialSettings("cylindrical_bottle")


@pytest.fixture(scope="module")
def plain():
    return run_trial(BOTTLE, 1).row


def test_turning_goes_120_degrees_either_way_and_comes_back():
    scene = build_scene(BOTTLE)
    simulation, start = Simulation(scene), np.array([0.0, 0.4, 0.8, 0.0, 0.4, 0.3])
    references = np.array(disturbance._turn(start, simulation))
    assert np.degrees(references[:, 5].max() - 0.3) == pytest.approx(120.0)
    assert np.degrees(references[:, 5].min() - 0.3) == pytest.approx(-120.0)
    assert references[-1] == pytest.approx(start)
    assert np.ptp(references[:, :5], axis=0) == pytest.approx(np.zeros(5))
    speed = np.abs(np.diff(references, axis=0)).max() / simulation.tick_time
    assert speed < scene.arm_speed_limit[5]


def test_shaking_moves_the_hand_by_20_mm_along_its_x():
    scene = build_scene(BOTTLE)
    simulation, start = Simulation(scene), np.array([0.0, 0.4, 0.8, 0.0, 0.4, 0.3])
    arm = scene.palm_motion
    position, rotation = arm.palm_pose(start)
    path = [arm.palm_pose(r)[0] - position for r in disturbance._shake(start, simulation)]
    along = np.array(path) @ rotation
    assert along[:, 0].max() == pytest.approx(0.02, rel=0.05)
    assert along[:, 0].min() == pytest.approx(-0.02, rel=0.05)
    assert np.abs(along[:, 1:]).max() < 1e-3
    assert along[-1] == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("kind", ["turn", "shake"])
def test_disturbance_has_columns_of_its_own(kind, plain):
    row = run_trial(replace(BOTTLE, disturbance=kind), 1).row
    assert row["success"] == plain["success"]
    assert row["displacement_mm"] == plain["displacement_mm"]
    assert row["disturbance_failure"] in ("none", "dropped", "slipped", "rotated")
    assert (row["disturbance_failure"] == "none") == (
        row["disturbance_displacement_mm"] <= 10.0 and row["disturbance_rotation_deg"] <= 10.0
    )


def test_copies_without_noise_repeat_the_label(plain):
    exact = replace(BOTTLE, repeats=2, repeat_position=0.0, repeat_angle=0.0, repeat_friction=0.0)
    row = run_trial(exact, 1).row
    assert (row["repeats"], row["success_probability"]) == (2, float(plain["success"]))
    # Wilson's interval of 2 in 2.
    assert row["success_low"] == pytest.approx(0.3424, abs=1e-4)
    assert row["success_high"] == 1.0
    for name in ("displacement_mm", "q_linf"):
        assert row[name] == plain[name]


def test_copies_are_noisy_and_decided_by_the_seed():
    noisy = replace(BOTTLE, repeats=3, repeat_position=0.03, repeat_friction=0.3)
    first, second = (run_trial(noisy, 1).row for _ in range(2))
    for name in ("repeats", "success_probability", "success_low"):
        assert first[name] == second[name]
    assert first["success_probability"] < 1.0  # an inch beside the bottle


def test_a_rigid_arm_keeps_its_place_under_load():
    sag = {}
    for kind in ("servo", "rigid"):
        scene = build_scene(replace(BOTTLE, arm=kind))
        simulation = Simulation(scene)
        posture = np.array([0.0, 0.2, 0.4, 0.0, 0.6, 0.0])
        simulation.data.qpos[scene.arm_qpos] = simulation.data.ctrl[scene.arm_motors] = posture
        simulation.data.xfrc_applied[scene.palm, 2] = -30.0
        simulation.wait(1.0)
        sag[kind] = np.abs(simulation.data.qpos[scene.arm_qpos] - posture).max()
    assert sag["rigid"] == pytest.approx(sag["servo"] / 100.0, rel=0.05)
    assert sag["servo"] > 1e-4


@pytest.fixture
def snapshot() -> TactileSnapshot:
    turn = np.array([0.5, 0.5, 0.5, 0.5])
    return sdh2.snapshot(
        np.zeros((3, 14, 6)), np.zeros((3, 13, 6)), np.zeros(7), np.zeros(7),
        np.concatenate(((0.01, 0.02, 0.15), turn)), np.array([0, 0, 0, 1.0, 0, 0, 0]),
    )  # fmt: skip


def test_a_tracker_makes_no_error_by_default(snapshot):
    obj = object_info("box")
    seen, known = add_tracking_error(snapshot, obj, TrialSettings("box"), np.random.default_rng(0))
    assert seen.object_pose_hand == pytest.approx(snapshot.object_pose_hand, abs=1e-15)
    assert (known.mass_kg, known.friction) == (obj.mass_kg, obj.friction)


def test_errors_have_their_standard_deviations(snapshot):
    obj, rng = object_info("box"), np.random.default_rng(0)
    settings = TrialSettings(
        "box", position_error=0.003, angle_error=0.05, friction_error=0.1, mass_error=0.2
    )
    moved, turned, friction, mass = [], [], [], []
    for _ in range(4000):
        seen, known = add_tracking_error(snapshot, obj, settings, rng)
        step = moved_between(snapshot.object_pose_hand, seen.object_pose_hand, obj.com_m)
        moved.append(step[0])
        turned.append(math.radians(step[1]))
        friction.append(known.friction / obj.friction)
        mass.append(known.mass_kg / obj.mass_kg)
    # Three independent axes each: the mean square is three times the variance.
    assert np.sqrt(np.mean(np.square(moved)) / 3) == pytest.approx(3.0, rel=0.05)
    assert np.sqrt(np.mean(np.square(turned)) / 3) == pytest.approx(0.05, rel=0.05)
    assert np.std(friction) == pytest.approx(0.1, rel=0.05)
    assert np.std(mass) == pytest.approx(0.2, rel=0.05)


def test_one_error_does_not_change_another(snapshot):
    obj = object_info("box")
    masses = [
        add_tracking_error(snapshot, obj, TrialSettings("box", mass_error=0.1, position_error=p),
                    np.random.default_rng(3))[1].mass_kg
        for p in (0.0, 0.01)
    ]  # fmt: skip
    assert masses[0] == masses[1]


def test_a_tracking_error_changes_the_metrics_and_nothing_else(plain):
    settings = replace(BOTTLE, position_error=0.003, angle_error=0.05, mass_error=0.1)
    row = run_trial(settings, 1).row
    assert row["q_linf"] != plain["q_linf"]
    assert row["perceived_mass_kg"] != row["mass_kg"] == plain["mass_kg"]
    assert not np.array_equal(row["perceived_pose_hand"], row["object_pose_hand"])
    assert np.array_equal(row["object_pose_hand"], plain["object_pose_hand"])
    assert row["displacement_mm"] == plain["displacement_mm"]
