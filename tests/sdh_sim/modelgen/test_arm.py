"""The arm: kinematics against the table of joint lines, mass, servos, files as generated."""

import mujoco
import numpy as np
import pytest

from sdh_sim.model_files import models_dir
from sdh_sim.modelgen import arm
from tests.support.generated_files import assert_same_files, model_files

FOLDER = models_dir() / "kuka_kr5_sixx_r850"
# Point on the joint line [m], axis, limits [deg], speed [deg/s] at the zero pose.
TABLE = (
    ((0, 0, 0.335), (0, 0, -1), (-170, 170), 250),
    ((0.075, 0, 0.335), (0, 1, 0), (-100, 135), 250),
    ((0.075, 0, 0.700), (0, 1, 0), (-209, 76), 250),
    ((0, 0, 0.790), (-1, 0, 0), (-190, 190), 410),
    ((0.480, 0, 0.790), (0, 1, 0), (-120, 120), 410),
    ((0.560, 0, 0.790), (-1, 0, 0), (-350, 350), 660),
)


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_path(str(FOLDER / "kr5_sixx_r850.xml"))


def turn_about(point, axis, angle):
    """Homogeneous transform of a turn about a line, by Rodrigues' formula."""
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]], float)
    rotation = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = np.array(point) - rotation @ np.array(point)
    return pose


def product_of_exponentials(q):
    pose = np.eye(4)
    for (point, axis, _, _), angle in zip(TABLE, q, strict=True):
        pose = pose @ turn_about(point, axis, angle)
    flange = np.eye(4)
    flange[:3, :3] = np.column_stack(([0, 0, -1], [0, 1, 0], [1, 0, 0]))
    flange[:3, 3] = (0.56, 0.0, 0.79)
    return pose @ flange


def test_flange_pose_is_the_product_of_exponentials(model):
    data = mujoco.MjData(model)
    low, high = model.jnt_range.T
    rng = np.random.default_rng(7)
    for q in [np.zeros(6), *np.diag(np.full(6, 0.7)), *rng.uniform(low, high, (20, 6))]:
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        expected = product_of_exponentials(q)
        assert data.site("flange").xpos == pytest.approx(expected[:3, 3], abs=1e-9)
        rotation = data.site("flange").xmat.reshape(3, 3)
        assert rotation == pytest.approx(expected[:3, :3], abs=1e-9)


def test_limits_and_speeds_are_the_tables(model):
    limits = np.radians([row[2] for row in TABLE])
    assert model.jnt_range == pytest.approx(limits, abs=1e-6)
    assert model.actuator_ctrlrange == pytest.approx(limits, abs=1e-6)
    assert np.all(model.jnt_limited)
    speeds = model.numeric("joint_speed_limit").data
    assert speeds == pytest.approx(np.radians([row[3] for row in TABLE]), abs=1e-6)
    names = [f"joint{k}" for k in range(1, 7)]
    assert [model.joint(k).name for k in range(6)] == names
    assert [model.actuator(k).name for k in range(6)] == names
    assert list(model.actuator_trnid[:, 0]) == list(range(6))


def test_masses_sum_to_29_kg_and_inertias_are_possible(model):
    masses = model.body_mass[1:]
    assert masses.sum() == pytest.approx(29.0, abs=1e-5)
    assert masses == pytest.approx([7.6, 7.8, 6.0, 4.9, 2.4, 0.3, 0.1], abs=0.05)
    moments = np.sort(model.body_inertia[1:], axis=1)
    assert np.all(moments > 0)
    assert np.all(moments[:, 0] + moments[:, 1] > moments[:, 2])
    assert np.all(model.body_gravcomp[2:] == 1)


def test_shapes_touch_or_are_drawn_and_stay_behind_the_flange(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    solid = model.geom_group == 3
    assert np.all(solid | (model.geom_group == 2))
    assert np.all(model.geom_contype[solid] == 8)
    assert np.all(model.geom_conaffinity[solid] == 4)
    assert not model.geom_contype[~solid].any()
    assert not model.geom_conaffinity[~solid].any()
    for g in np.flatnonzero(solid):
        centre, half = model.geom_aabb[g, :3], model.geom_aabb[g, 3:]
        rotation = data.geom_xmat[g].reshape(3, 3)
        ahead = data.geom_xpos[g] + rotation @ centre + np.abs(rotation) @ half
        assert ahead[0] < 0.55


@pytest.mark.parametrize("timestep", [0.002, 0.004])
def test_servos_hold_a_hand_of_2_kg_without_ringing(timestep):
    spec = mujoco.MjSpec.from_file(str(FOLDER / "kr5_sixx_r850.xml"))
    spec.body("link6").add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.06, 0, 0], mass=2.0,
                                pos=[0.14, 0, 0], contype=0, conaffinity=0)  # fmt: skip
    spec.option.timestep = timestep
    model = spec.compile()
    data = mujoco.MjData(model)
    goal = np.array([0.5, 0.4, -0.4, 0.6, 0.7, -1.0])
    data.qpos[:] = data.ctrl[:] = goal
    mujoco.mj_step(model, data, round(0.5 / timestep))
    assert np.abs(data.qpos - goal).max() < 0.002  # the tool's weight over the stiffness
    # A step small enough that no motor saturates: then the damping is what is seen.
    data.ctrl[:] += 0.005
    path = []
    while data.time < 1.5:
        mujoco.mj_step(model, data)
        path.append(data.qpos.copy())
    assert path[-1] == pytest.approx(goal + 0.005, abs=0.002)
    assert (np.max(path, axis=0) - path[-1]).max() < 0.1 * 0.005
    assert np.abs(data.qvel).max() < 1e-4


def test_committed_files_are_what_the_script_makes(tmp_path):
    arm.write_arm(tmp_path)
    assert_same_files(tmp_path, FOLDER, model_files(FOLDER), "sdh_sim.modelgen.arm")
