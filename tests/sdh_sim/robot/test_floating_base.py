"""The base of a hand without an arm: inverse kinematics in closed form, and how stiff it is."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sdh_sim.cell import build_scene
from sdh_sim.robot.floating_base import FREQUENCY, INERTIA, FloatingBase
from sdh_sim.settings import TrialSettings

BASE = FloatingBase()
POLES = [np.eye(3), np.diag([1.0, -1.0, -1.0]), np.diag([-1.0, 1.0, -1.0])]  # palm up, palm down


@pytest.fixture(scope="module")
def scene():
    return build_scene(TrialSettings("box", arm="none"))


@pytest.mark.parametrize("number", range(20))
def test_every_pose_is_reached_where_mujoco_puts_the_palm(scene, number):
    rng = np.random.default_rng(number)
    rotation = POLES[number] if number < 3 else Rotation.random(rng=rng).as_matrix()
    position = rng.uniform(-1, 1, 3)
    joints = BASE.reach(position, rotation)
    for place, turn in [BASE.palm_pose(joints), palm_of(scene, joints)]:
        assert place == pytest.approx(position, abs=1e-12)
        assert turn == pytest.approx(rotation, abs=1e-9)


def palm_of(scene, joints):
    data = mujoco.MjData(scene.model)
    data.qpos[scene.arm_qpos] = joints
    mujoco.mj_kinematics(scene.model, data)
    return data.xpos[scene.palm], data.xmat[scene.palm].reshape(3, 3)


@pytest.mark.parametrize(
    "rotation", [*POLES, Rotation.from_euler("xyz", (0.3, -1.2, 2.0)).as_matrix()]
)
def test_a_straight_line_keeps_the_angles(rotation):
    start = BASE.reach(np.array([0.5, 0.1, 0.4]), rotation)
    path = BASE.straight(start, np.array([0.0, 0.0, 0.15]))
    assert path is not None
    assert np.ptp(path[:, 3:], axis=0).max() == 0.0
    assert path[-1, :3] - path[0, :3] == pytest.approx([0, 0, 0.15], abs=1e-12)


def test_a_small_turn_needs_small_angles_even_beside_the_pole():
    # Of the two triples of angles of every rotation, and their full turns, the nearest is taken.
    start = np.array([0.0, 0.0, 0.0, 3.0, 0.01, -3.0])
    rotation = BASE.palm_pose(start + np.array([0, 0, 0, 0.4, 0.0, 0.3]))[1]
    found = BASE.solve(np.zeros(3), rotation, start)
    assert np.abs(found[3:] - start[3:]).max() == pytest.approx(0.4)


def test_the_base_gives_way_by_force_over_stiffness(scene):
    # k = m w²: 20 N over 100 kg (200 rad/s)² is 5 µm; 2 N m over 1 kg m² (200 rad/s)² is 50 µrad.
    data = mujoco.MjData(scene.model)
    start = BASE.reach(np.array([0.0, 0.0, 0.6]), POLES[1])
    data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = start
    data.xfrc_applied[scene.palm] = [0, 0, -20.0, 0, 0, 0]
    mujoco.mj_step(scene.model, data, 500)
    moved = data.qpos[scene.arm_qpos] - start
    assert moved[2] == pytest.approx(-20.0 / (INERTIA[0] * FREQUENCY**2), rel=0.01)
    data.xfrc_applied[scene.palm] = [0, 0, 0, 0, 2.0, 0]
    mujoco.mj_step(scene.model, data, 500)
    moved = data.qpos[scene.arm_qpos] - start
    assert abs(moved[4]) == pytest.approx(2.0 / (INERTIA[1] * FREQUENCY**2), rel=0.02)
