"""The load test: identities of a quasi-static ramp, its limits, and that it leaves no trace."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sdh_sim.cell import build_scene
from sdh_sim.poses import rotate
from sdh_sim.sensing import GRAVITY
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, classify, load_test, run_trial

BOTTLE = TrialSettings("cylindrical_bottle")
HELD_SEED = 11  # a grasp that holds 2.3 times the weight, well on its pads


@pytest.fixture(scope="module")
def held():
    """A lifted bottle: simulation, state on the table in the grip, state after the lift."""
    trial = Trial(BOTTLE, HELD_SEED, scene=build_scene(BOTTLE))
    trial.acquire()
    grasped = trial.simulation.save()
    assert classify(trial.lift()) == "none"
    return trial.simulation, grasped, trial.simulation.save()


@pytest.fixture(scope="module")
def q_sim(held) -> float:
    simulation, grasped, _ = held
    simulation.restore(grasped)
    result = load_test.gravity_factor(simulation)
    assert not result.capped
    return result.load


def test_weaker_gravity_leaves_as_much_more_room_for_the_load(held, q_sim):
    # At 0.4 g the applied force must make up for the missing weight: the load that the ramp
    # counts, with one weight carried by gravity, ends 0.6 higher.
    simulation, grasped, _ = held
    gravity = simulation.scene.model.opt.gravity
    simulation.restore(grasped)
    gravity[2] *= 0.4
    try:
        result = load_test.gravity_factor(simulation)
    finally:
        gravity[2] /= 0.4
    assert result.load == pytest.approx(q_sim + 0.6, rel=0.03)


def test_speed_of_the_ramp_does_not_matter(held, q_sim):
    simulation, grasped, _ = held
    for speed in (0.5, 2.0):
        simulation.restore(grasped)
        result = load_test.gravity_factor(simulation, speed)
        assert result.load == pytest.approx(q_sim, rel=0.04)


def test_a_weight_elsewhere_turns_the_object_too(held, q_sim):
    simulation, grasped, _ = held
    obj, body = simulation.scene.obj, simulation.scene.object_body
    up, beside = np.array([0.0, 0.05, 0.0]), np.array([0.05, 0.0, 0.0])  # of the upright bottle
    loads = []
    for point in (np.zeros(3), up, beside):
        simulation.restore(grasped)
        loads.append(load_test.gravity_factor(simulation, point=point).load)
        weight = obj.mass_kg * GRAVITY * loads[-1]
        arm = rotate(simulation.data.xquat[body], point)
        moment = np.cross(arm, (0.0, 0.0, -weight))
        applied = simulation.data.xfrc_applied[body, 3:]
        assert applied == pytest.approx(moment, abs=5e-4 * weight)  # it turned on in the last tick
    assert loads[0] == q_sim
    assert loads[1] == pytest.approx(q_sim, rel=0.03)  # on the weight's own line
    assert loads[2] < 0.8 * q_sim


def test_the_table_is_back_after_the_load_test(held, q_sim):
    simulation, _, _ = held
    table = simulation.scene.table
    assert simulation.scene.model.geom_contype[table] != 0  # the table is back


def test_an_open_hand_holds_nothing(held):
    simulation, grasped, _ = held
    simulation.restore(grasped)
    with simulation.without_table():
        simulation.data.qpos[simulation.scene.object_qpos + 2] += 0.5  # well above the hand
        assert load_test.gravity_factor(simulation).load < 0.1


def test_more_friction_holds_more(held, q_sim):
    simulation, grasped, _ = held
    before = simulation.scene.model.geom_friction.copy()
    simulation.restore(grasped)
    with simulation.friction_scaled(1.3):
        simulation.wait(0.2)
        more = load_test.gravity_factor(simulation).load
    assert np.array_equal(simulation.scene.model.geom_friction, before)
    assert more > 1.1 * q_sim


def test_loads_along_the_hand_leave_the_simulation_as_it_was(held):
    simulation, _, lifted = held
    simulation.restore(lifted)
    pose = simulation.object_in_hand()
    loads = load_test.direction_loads(simulation, speed=4.0)
    assert loads.shape == (9,) == (len(load_test.DIRECTIONS),)
    assert (loads > 0.0).all()
    assert simulation.object_in_hand() == pytest.approx(pose, abs=1e-12)
    assert not simulation.data.xfrc_applied.any()
    # The hand is level here, so one of its axes points down: that force beside the weight is
    # the weight scaled, and no direction holds less than a fraction of it.
    assert math.isfinite(loads[:6].min())


def test_columns_of_held_lost_and_untouched_grasps():
    settings = replace(BOTTLE, load_test="gravity")
    held = run_trial(settings, HELD_SEED).row
    assert held["success"]
    assert held["q_sim"] > 1.0
    plain = run_trial(BOTTLE, HELD_SEED).row
    assert plain["q_sim"] is None
    for name in ("displacement_mm", "q_linf", "failure"):
        assert held[name] == plain[name]  # the test comes after the verdict
    lost = run_trial(settings, 6).row
    assert not lost["success"]
    assert 0.0 <= lost["q_sim"] < held["q_sim"]
