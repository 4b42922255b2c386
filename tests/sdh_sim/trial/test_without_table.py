"""Without a table: the fixture, the balance of forces at the snapshot, weight in any direction."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import graspq as gq
from sdh_sim import poses
from sdh_sim.cell import HAND_GEOM, Simulation, build_scene
from sdh_sim.cell.contacts import forces_on_object
from sdh_sim.errors import InfeasibleGrasp, SettingsError
from sdh_sim.grasping import GraspPlan
from sdh_sim.metrics import stored_grasps
from sdh_sim.records import normalise
from sdh_sim.robot import preshape_closing
from sdh_sim.sensing.perceived_grasp import gravity_task
from sdh_sim.settings import GRAVITY_DIRECTIONS, TrialSettings
from sdh_sim.trial import Trial, run_trial
from sdh_sim.trial.weigh import RAMP_TIME, weigh

FREE = TrialSettings("cylindrical_bottle", arm="none", support="none")
SEED = 1


class Poses:
    """An observer that keeps the object's pose by phase."""

    def __init__(self):
        self.seen: dict[str, list[np.ndarray]] = {}

    def after_tick(self, scene, data, phase):
        pose = poses.body_pose(data, scene.object_body)
        self.seen.setdefault(phase, []).append(pose)


@pytest.fixture(scope="module")
def grasped():
    seen = Poses()
    trial = Trial(FREE, SEED, observers=(seen,))
    trial.acquire()
    assert trial.touched
    return trial, seen.seen


def test_the_fixture_holds_the_object_while_the_hand_squeezes(grasped):
    _, seen = grasped
    held = np.array(seen["approach"] + seen["close"] + seen["squeeze"])
    assert np.abs(held[:, :3] - held[0, :3]).max() < 1e-6
    assert max(poses.turn_between(held[0], pose) for pose in held) < 1e-4
    loose = np.array(seen["rest"])
    assert np.abs(loose[-1, :3] - held[0, :3]).max() > 1e-6  # it has let go


def test_the_hand_s_forces_balance_at_the_snapshot(grasped):
    # Nothing else bears on the object and it has no weight: they add up to nothing.
    trial, _ = grasped
    points, forces, normals, geoms = forces_on_object(trial.scene, trial.simulation.data)
    pressed = np.linalg.norm(forces, axis=1).sum()
    assert pressed > 10.0
    assert np.linalg.norm(forces.sum(axis=0)) < 0.01 * pressed
    arms = points - trial.simulation.data.xipos[trial.scene.object_body]
    assert np.linalg.norm(np.cross(arms, forces).sum(axis=0)) < 0.01 * pressed * 0.1
    # Contacts push, and no more along the surface than friction lets them.
    pushed = np.einsum("kj,kj->k", forces, normals)
    assert (pushed > 0.0).all()
    slid = np.linalg.norm(forces - pushed[:, None] * normals, axis=1)
    assert (slid < 1.01 * trial.scene.obj.friction * pushed).all()
    assert (trial.scene.geom_group[geoms] == HAND_GEOM).all()
    assert not trial.simulation.on_table()


def test_an_object_that_nothing_holds_falls_along_the_weight():
    # a(t) = g t / T while the weight grows: after T it has come g T² / 6.
    scene = build_scene(FREE)
    simulation = Simulation(scene)
    start = simulation.data.qpos[scene.object_qpos : scene.object_qpos + 3]
    start[:] = (2.0, 2.0, 1.0)
    simulation.release_object()
    down = np.array([0.6, 0.0, -0.8])
    path = []

    class Path:
        def after_tick(self, scene, data, phase):
            path.append((data.time, *data.xipos[scene.object_body]))

    simulation.observers.append(Path())
    before = simulation.object_in_hand()
    motion = weigh(simulation, down, before)
    assert motion.fell
    time, *place = np.array(path).T
    way = (np.array(place).T - np.array(place)[:, 0]) @ down
    # The weight takes each tick's value at its beginning, half a tick early in the mean. MuJoCo's
    # xipos is that of the last step's beginning, and semi-implicit steps are half a step ahead.
    since = time + 0.5 * simulation.tick_time - 0.5 * scene.model.opt.timestep
    expected = 9.81 / RAMP_TIME / 6 * (since**3 - since[0] ** 3)
    assert way == pytest.approx(expected, abs=2e-4)
    across = np.array(place).T - np.array(place)[:, 0] - np.outer(way, down)
    assert np.abs(across).max() < 1e-9


def test_the_task_of_six_directions_is_the_hardest_of_each(grasped):
    trial, _ = grasped
    snapshot = trial.snapshot()
    assert snapshot.gravity == "-z"
    prediction = trial.prediction
    assert prediction is not None
    sets = [gq.contact_wrenches(p.contact, 12, "hf") for p in prediction.contacts]
    values = {}
    for name in (*GRAVITY_DIRECTIONS, "six"):
        task = gravity_task(replace(snapshot, gravity=name), trial.scene.obj)
        values[name] = gq.task_scaling(sets, task).value
    six = values.pop("six")
    assert six == pytest.approx(min(values.values()), rel=1e-9)
    assert max(values.values()) > six


@pytest.fixture(scope="module")
def six():
    row = run_trial(replace(FREE, gravity="six", load_test="gravity"), SEED).row
    return normalise({**row, "trial": 0})


def test_six_directions_all_have_to_hold(six):
    moved, turned = six["direction_displacement_mm"], six["direction_rotation_deg"]
    within = (moved <= 10.0) & (turned <= 10.0)
    assert np.isfinite(moved).all()
    assert six["success"] == bool(within.all())
    assert six["displacement_mm"] == moved.max()
    assert six["rotation_deg"] == turned.max()
    assert six["q_sim"] == six["direction_q_sim"].min()
    # What holds its weight bears at least one of it.
    assert (six["direction_q_sim"][within] >= 1.0).all()
    assert six["gravity"] == "six"


def test_one_direction_is_one_of_the_six(six):
    row = normalise({**run_trial(replace(FREE, gravity="+x"), SEED).row, "trial": 0})
    at = GRAVITY_DIRECTIONS.index("+x")
    assert np.isnan(np.delete(row["direction_displacement_mm"], at)).all()
    # From the same state; the six begin by restoring it, which starts the contact solver anew.
    assert row["direction_displacement_mm"][at] == pytest.approx(
        six["direction_displacement_mm"][at], rel=0.05, abs=0.05
    )
    assert row["q_linf"] >= six["q_linf"]


def test_a_stored_grasp_keeps_its_directions(six):
    grasp = stored_grasps.grasp_of(six, "all")
    assert grasp is not None
    assert grasp.snapshot.gravity == "six"
    assert grasp.task.shape[1] == 6 * gravity_task(
        replace(grasp.snapshot, gravity="-z"), grasp.obj
    ).shape[1]  # fmt: skip


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"gravity": "six"}, "gravity: got 'six'; on the table the weight acts downward"),
        ({"support": "none", "gravity": "up"}, "gravity: got 'up'; choose one of -z, "),
        ({"support": "none", "disturbance": "turn"}, "disturbance: got 'turn'; with support none"),
        ({"support": "none", "load_test": "directions"}, "load_test: got 'directions'; with"),
    ],
)
def test_settings_that_exclude_each_other(given, words):
    with pytest.raises(SettingsError, match=words):
        TrialSettings("box", **given)


def test_a_floating_hand_lifts_from_the_table_as_well():
    row = run_trial(TrialSettings("cylindrical_bottle", arm="none"), SEED).row
    assert row.failure not in ("no_contact", "unstable_simulation")
    assert row.direction_displacement_mm is None
    assert row.resampled_unreachable == 0  # every pose is within its reach


def test_a_given_grasp_that_cannot_be_tried_is_a_row_of_its_own():
    scene = build_scene(TrialSettings("box"))
    far = GraspPlan(
        np.array([1.5, 0, 0.3]), np.diag([1.0, -1, -1]), 0.0, preshape_closing("parallel")
    )
    trial = Trial(TrialSettings("box", repeats=2), 3, plan=far, scene=scene)
    with pytest.raises(InfeasibleGrasp, match="cannot be tried: the arm cannot bring the palm"):
        _ = trial.motion
    result = run_trial(TrialSettings("box", repeats=2), 3, log=True, plan=far)
    row = normalise({**result.row, "trial": 0})
    assert (row["success"], row["failure"]) == (False, "infeasible")
    assert row["infeasible_reason"] == "the arm cannot bring the palm there"
    assert row["mass_kg"] == pytest.approx(scene.obj.mass_kg)
    assert row["q_linf"] is row["displacement_mm"] is result.log is None
    assert math.isclose(result.sim_seconds, 0.0)


def test_a_plan_of_a_random_grasp_gives_the_random_grasp_s_row():
    settings = TrialSettings("cylindrical_bottle")
    random = Trial(settings, SEED)
    again = run_trial(settings, SEED, plan=replace(
        random.motion.grasp, opening=random.motion.opening
    )).row  # fmt: skip
    row = random.run()
    for name in ("failure", "displacement_mm", "q_linf", "object_yaw_rad"):
        assert again[name] == row[name]
