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


def test_readings_are_the_pressures_where_contacts_act():
    hand = built_in_hand()
    model = grasp_model(hand, object_info("box"))
    model.look(model.model.qpos0)
    pad, (row, column) = hand.pads[0], (6, 2)
    geom = int(np.flatnonzero(model.taxel == row * pad.array.shape[1] + column)[0])
    link = int(model.model.geom_bodyid[geom])
    turn, place = model.data.xmat[link].reshape(3, 3), model.data.xpos[link]
    centre, _ = pad.array.surface(row, column)
    beside, _ = pad.array.surface(row, column + 0.25)
    beyond, _ = pad.array.surface(row, pad.array.shape[1] + 1.0)
    geoms = np.array([[geom, model.table]] * 3 + [[model.table, 0]])
    points = np.array([place + turn @ local for local in (centre, beside, beyond, centre)])
    readings = model.readings(geoms, points, np.array([2.0, 4.0, 8.0, 16.0]))
    pressure = np.concatenate([readings[kind].ravel() for kind in hand.arrays])
    force = 1e3 * pad.array.pitch**2 * pressure
    # 2 N on a centre, 4 N a quarter of a pitch beside it, 8 N beyond the border, 16 N elsewhere.
    assert np.sort(force[force > 0.0]) == pytest.approx([1.0, 5.0])
