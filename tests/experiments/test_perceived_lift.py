"""The simulation from the perceived snapshot: it is that snapshot, and leaves the scene alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments import perceived_lift
from experiments.perceived_lift import Job, predict_motion, scores_of, set_to_snapshot
from sdh_sim.cell import Simulation, scene_of
from sdh_sim.metrics import snapshot_of
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import classify, run_trial
from sdh_sim.trial.outcome import Motion, moved_between
from tests.support.run_folders import write_run_of

SETTINGS = TrialSettings("box", grasps="precision", pads="distal")


@pytest.fixture(scope="module")
def row():
    return run_trial(SETTINGS, 3).row


def test_the_simulation_starts_where_the_snapshot_was_taken(row):
    snapshot = snapshot_of(row)
    assert snapshot is not None
    simulation = Simulation(scene_of(replace(SETTINGS, arm="none")))
    set_to_snapshot(simulation, snapshot)
    scene, data = simulation.scene, simulation.data
    moved = moved_between(snapshot.object_pose_hand, simulation.object_in_hand(), scene.obj.com_m)
    assert moved == pytest.approx((0.0, 0.0), abs=1e-4)
    assert scene.motor_positions(data) == pytest.approx(snapshot.joint_angles, abs=1e-12)
    # The servos press as hard as they did, but for what damps their last motion.
    assert data.actuator_force[scene.motors] == pytest.approx(snapshot.motor_torques, abs=1e-4)
    sensed, unsensed = simulation.hand_force()
    assert sensed == pytest.approx(row["sensed_force_n"], rel=0.05)
    assert unsensed == pytest.approx(row["unsensed_force_n"], abs=0.05 * sensed)


def test_a_held_grasp_is_predicted_to_hold_and_to_move_as_far(row):
    motion = predict_motion(Job(SETTINGS, row))
    assert classify(motion) == row["failure"] == "none"
    assert motion.displacement_mm == pytest.approx(row["displacement_mm"], abs=1.0)


def test_an_object_thought_too_heavy_is_predicted_to_fall_and_the_scene_stays(row):
    scene = scene_of(replace(SETTINGS, arm="none"))
    mass, friction = scene.model.body_mass.copy(), scene.model.geom_friction.copy()
    place = scene.model.body_pos.copy()
    heavy = {**row, "perceived_mass_kg": 8.0 * row["mass_kg"]}
    assert classify(predict_motion(Job(SETTINGS, heavy))) != "none"
    slippery = {**row, "perceived_friction": 0.2 * row["friction"]}
    assert classify(predict_motion(Job(SETTINGS, slippery))) != "none"
    assert np.array_equal(scene.model.body_mass, mass)
    assert np.array_equal(scene.model.geom_friction, friction)
    assert np.array_equal(scene.model.body_pos, place)


def test_scores_order_by_motion_and_part_at_the_verdict():
    still, near, out = Motion(1.0, 0.5, False), Motion(9.0, 2.0, False), Motion(11.0, 1.0, False)
    gone = Motion(np.inf, np.inf, True)
    scores = scores_of([gone, near, out, still])
    assert np.argsort(scores).tolist() == [0, 2, 1, 3]
    assert (scores > 1.0).tolist() == [False, True, False, True]


def test_the_command_prints_its_table(row, tmp_path, capsys):
    fell = {**row, "success": False, "failure": "dropped"}
    out = write_run_of([row, fell], SETTINGS, tmp_path / "run")
    perceived_lift.main([str(out), "--workers", "1"])
    printed = capsys.readouterr().out
    assert "MuJoCo from the snapshot" in printed
    with pytest.raises(SystemExit):
        perceived_lift.main([str(tmp_path / "nothing")])
