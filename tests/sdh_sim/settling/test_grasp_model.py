"""The model of hand, object and table: forces of springs, stops and couplings, gaps, readings."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.objects import object_info
from sdh_sim.robot import built_in_hand, hand_kinematics, read_hand_folder
from sdh_sim.settling.grasp_model import COUPLING, STOP, GraspModel, grasp_model
from tests.support.hand_folders import GRIPPER, write_hand

SPRUNG = GRIPPER.replace(
    '<fixed name="pull">', '<fixed name="pull" stiffness="300" springlength="0.011 0.013">'
).replace('damping="5"', 'damping="5" stiffness="20" springref="0.004"')
FAR = np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])  # pose of an object that touches nothing


def forces(model: GraspModel, joints: list[float]) -> np.ndarray:
    """What springs, stops and couplings exert on all coordinates (n,)."""
    model.look(model.pose(np.array(joints), FAR))
    found = model.mechanism()
    return np.clip(found.force, found.lower, found.upper) @ found.rows


@pytest.mark.parametrize("joints", [[0.005, 0.005], [0.012, 0.012], [0.03, 0.03]])
def test_springs_of_joints_and_tendons_pull_as_in_mujoco(joints, tmp_path):
    # Below, within and above the slack of the tendon.
    hand = read_hand_folder(write_hand(tmp_path / "hand", model=SPRUNG))
    model = grasp_model(hand, object_info("box"))
    found = forces(model, joints)
    mujoco.mj_passive(model.model, model.data)
    springs = model.data.qfrc_spring
    assert np.abs(springs[~model.of_object]).max() > 0.0
    assert found == pytest.approx(springs, abs=1e-9)


def test_couplings_pull_back_and_stops_push(tmp_path):
    hand = read_hand_folder(write_hand(tmp_path / "hand"))
    model = grasp_model(hand, object_info("box"))
    apart = forces(model, [0.0201, 0.02])
    assert apart[:2] == pytest.approx([-COUPLING * 1e-4, COUPLING * 1e-4], rel=1e-6)
    outside = forces(model, [0.041, 0.041])
    assert outside[:2] == pytest.approx([-STOP * 1e-3, -STOP * 1e-3], rel=1e-6)


def test_gaps_to_the_table_and_the_motion_that_closes_them():
    hand = built_in_hand()
    model = grasp_model(hand, object_info("box"))
    up = np.array([0.0, 0.0, 1.0])
    joints = hand_kinematics(hand).joint_positions(np.zeros(len(hand.motors)))
    qpos = model.pose(joints, FAR)
    lowest = model.lowest(qpos, up)
    model.put_table(lowest - 1e-3, up)
    model.look(qpos)
    touch = model.touch()
    under = (touch.geoms == model.table).any(axis=1)
    assert touch.gap[under] == pytest.approx(1e-3, abs=1e-9)
    down = np.zeros(len(model.of_object))
    down[model.object_dof + 2] = -1e-3
    closing = np.einsum("ci,cij,j->c", touch.normal, touch.jacobian, down)
    assert closing[under] == pytest.approx(-1e-3, abs=1e-9)
    model.look(model.move(qpos, down))
    assert model.touch().gap == pytest.approx(0.0, abs=1e-9)


def test_readings_are_the_pressures_of_the_taxels():
    hand = built_in_hand()
    model = grasp_model(hand, object_info("box"))
    taxel = int(np.flatnonzero(model.taxel >= 0)[5])
    pitch = hand.pads[0].array.pitch
    model.look(model.pose(hand_kinematics(hand).joint_positions(np.zeros(7)), FAR))
    body = model.model.body(hand.pads[0].body).id
    centre = hand.pads[0].array.centres[5, 2]
    point = model.data.xpos[body] + model.data.xmat[body].reshape(3, 3) @ centre
    geoms = np.array([[taxel, model.table], [model.table, 0]])
    readings = model.readings(geoms, np.array([point, point]), np.array([2.0, 9.0]))
    flat = np.concatenate([readings[kind].ravel() for kind in hand.arrays])
    assert flat.sum() == pytest.approx(2.0 / pitch**2 / 1e3)
    assert np.count_nonzero(flat > 1e-9 * flat.max()) == 1
