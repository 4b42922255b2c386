"""The composed cell: contact stiffness as given by the rubber, settings, parts in place."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import mujoco
import numpy as np
import pytest

from sdh_sim.cell import ARM_GEOM, HAND_GEOM, OBJECT_GEOM, TABLE_GEOM, Scene, build_scene
from sdh_sim.cell.scene_builder import taxel_stiffness
from sdh_sim.errors import SettingsError
from sdh_sim.grasping import place, plan_motion
from sdh_sim.model_files import models_dir
from sdh_sim.objects import object_info, object_names
from sdh_sim.robot import sdh2_constants as c
from sdh_sim.setting_table import settings_of
from sdh_sim.settings import TrialSettings
from tests.support import taxel_press as sdh_press
from tests.support.sdh2 import MOTOR_NAMES, PAD_OFFSETS, TACTILE_SIZE

PAD_MIDDLE = np.array([15.4e-3, 0.0, 43.7e-3])  # of the proximal pad, in the link


@pytest.fixture(scope="module")
def scenes() -> dict[str, Scene]:
    return {name: build_scene(TrialSettings(name)) for name in object_names()}


@pytest.fixture(scope="module", params=["box", "cylindrical_bottle"])
def pressed(request, scenes) -> tuple[Scene, mujoco.MjData]:
    """10 N on the proximal pad of the thumb, at rest."""
    scene = sdh_press.alone(scenes[request.param], ("thumb", "proximal"))
    data = sdh_press.against_thumb_proximal(scene)
    sdh_press.push(scene, data, "thumb_proximal", PAD_MIDDLE, 10.0, 1.5)
    return scene, data


def test_stiffness_of_the_rubber():
    # E pitch^2 / thickness = 1e6 Pa * (3.4e-3 m)^2 / 3e-3 m = 3853.33 N/m
    assert taxel_stiffness(TrialSettings("box"), 3.4e-3) == pytest.approx(3853.3333, abs=1e-3)
    soft = TrialSettings("box", pad_modulus=2e5, pad_thickness=6e-3)
    assert taxel_stiffness(soft, 3.4e-3) == pytest.approx(385.33333, abs=1e-4)


def test_a_press_indents_by_force_over_stiffness(pressed):
    scene, data = pressed
    _, depth, force, _ = sdh_press.contacts(scene, data)
    assert np.abs(data.qvel).max() < 1e-4  # at rest
    size = np.linalg.norm(force, axis=1)
    assert size / depth == pytest.approx(np.full(len(size), 3853.333), rel=1e-3)
    link = data.body("hand/thumb_proximal").xmat.reshape(3, 3)
    assert force.sum(axis=0) @ link == pytest.approx((10.0, 0, 0), abs=1e-3)


def test_a_flat_face_presses_all_84_cells_alike(scenes):
    scene = sdh_press.alone(scenes["box"], ("thumb", "proximal"))
    data = sdh_press.against_thumb_proximal(scene)
    sdh_press.push(scene, data, "thumb_proximal", PAD_MIDDLE, 10.0, 1.5)
    taxel, depth, _, _ = sdh_press.contacts(scene, data)
    first = PAD_OFFSETS[c.PADS.index(("thumb", "proximal"))]
    assert sorted(taxel) == list(range(first, first + 84))
    # 10 N / (84 * 3853.333 N/m) = 30.895 micrometres
    assert depth * 1e6 == pytest.approx(np.full(84, 30.895), abs=0.01)


def test_softer_rubber_indents_more():
    scene = sdh_press.alone(
        build_scene(TrialSettings("box", pad_modulus=2e5)), ("thumb", "proximal")
    )
    data = sdh_press.against_thumb_proximal(scene)
    sdh_press.push(scene, data, "thumb_proximal", PAD_MIDDLE, 10.0, 1.5)
    _, depth, _, _ = sdh_press.contacts(scene, data)
    assert depth * 1e6 == pytest.approx(np.full(84, 154.5), rel=0.01)  # 5 times 30.895


def test_solref_follows_the_object(scenes):
    # k = K (1 - d) (A_link + A_object), b = 2 sqrt k: another mass, another k.
    seen = {}
    for name, scene in scenes.items():
        model = scene.model
        for geom in np.flatnonzero(scene.taxel >= 0):
            link = model.geom_bodyid[geom]
            a = model.body_invweight0[link, 0] + model.body_invweight0[scene.object_body, 0]
            k = 3853.3333 * 0.05 * a
            assert model.geom_solref[geom] == pytest.approx((-k, -2 * np.sqrt(k)), rel=1e-6)
            assert model.geom_solimp[geom, :2].tolist() == [0.95, 0.95]
        seen[name] = model.geom_solref[np.flatnonzero(scene.taxel >= 0)[0], 0]
        # The lighter the object, the more A: 1 / m of a free body.
        assert model.body_invweight0[scene.object_body, 0] == pytest.approx(
            1 / object_info(name).mass_kg, rel=1e-6
        )
    by_mass = sorted(seen, key=lambda name: object_info(name).mass_kg)
    assert [-seen[n] for n in by_mass] == sorted((-seen[n] for n in seen), reverse=True)
    assert len(set(seen.values())) == 4


def test_options_are_the_cells(scenes):
    option = ElementTree.parse(models_dir() / "cell" / "cell.xml").getroot().find("option")
    assert option is not None
    for scene in scenes.values():
        opt = scene.model.opt
        assert option.get("integrator") == "Euler"
        assert opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
        assert opt.disableflags & mujoco.mjtDisableBit.mjDSBL_EULERDAMP
        assert option.get("cone") == "elliptic"
        assert opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
        assert opt.impratio == float(option.get("impratio", "")) == 1000.0
        assert opt.tolerance == float(option.get("tolerance", "")) == 1e-10
        assert opt.iterations == int(option.get("iterations", ""))
        assert opt.noslip_iterations == 0
        assert opt.gravity.tolist() == [0, 0, -9.81]
        assert opt.timestep == 0.002
        assert opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
        assert not opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT


def test_timestep_and_torque_limits_are_the_settings():
    settings = TrialSettings("box", torque_limit=(1.5, 0.7), timestep=0.004)
    scene = build_scene(settings)
    assert scene.model.opt.timestep == 0.004
    expected = [1.5, 1.5, 0.7, 1.5, 0.7, 1.5, 0.7]
    ranges = scene.model.actuator_forcerange[scene.motors]
    assert ranges[:, 1] == pytest.approx(expected)
    assert ranges[:, 0] == pytest.approx(np.negative(expected))
    assert scene.model.actuator_forcelimited[scene.motors].all()


def test_unknown_object_is_refused():
    with pytest.raises(SettingsError, match="teapot"):
        build_scene(TrialSettings("teapot"))


def test_explicit_damping_is_stable_at_the_longest_time_step(scenes):
    # Semi-implicit Euler with stiffness K and damping D, both explicit, is stable while every
    # mode has c h < 2 and k h² < 4 - 2 c h.
    span = settings_of(TrialSettings)["timestep"].span
    assert span is not None
    longest = span[1]
    for scene in (scenes["box"], build_scene(TrialSettings("box", arm="rigid"))):
        model = scene.model
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        damping, stiffness = np.diag(model.dof_damping), np.zeros((model.nv, model.nv))
        for motor in range(model.nu):
            dof = model.jnt_dofadr[model.actuator_trnid[motor, 0]]
            stiffness[dof, dof] -= model.actuator_biasprm[motor, 1]
            damping[dof, dof] -= model.actuator_biasprm[motor, 2]
        rate = np.linalg.eigvals(np.linalg.solve(mass, damping)).real.max() * longest
        square = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.max() * longest**2
        assert 0.5 < rate < 1.5  # far from 0: the test sees the damping
        assert square < 4.0 - 2.0 * rate


@pytest.mark.parametrize("name", object_names())
def test_friction_of_pads_and_structure_is_the_objects(scenes, name):
    scene, mu = scenes[name], object_info(name).friction
    hand = scene.geom_group == HAND_GEOM
    solid = hand & (scene.model.geom_contype > 0)
    assert scene.model.geom_friction[solid, 0] == pytest.approx(np.full(solid.sum(), mu))
    # MuJoCo takes the larger of two frictions, of equal priority.
    assert scene.model.geom_friction[scene.table, 0] <= mu
    obj = (scene.geom_group == OBJECT_GEOM) & (scene.model.geom_contype > 0)
    assert scene.model.geom_friction[obj, 0] == pytest.approx(np.full(obj.sum(), mu))


@pytest.mark.parametrize("name", object_names())
def test_object_keeps_its_mass_and_centre_of_mass(scenes, name):
    scene, info = scenes[name], object_info(name)
    assert scene.model.body_mass[scene.object_body] == pytest.approx(info.mass_kg)
    assert scene.model.body_ipos[scene.object_body] == pytest.approx(info.com_m)
    assert scene.model.body_gravcomp[scene.object_body] == 0.0


def test_indices_point_at_what_they_say(scenes):
    scene = scenes["spray_bottle"]
    model = scene.model
    assert [model.actuator(k).name for k in scene.motors] == ["hand/" + m for m in MOTOR_NAMES]
    for motor, qpos, dof in zip(scene.motors, scene.motor_qpos, scene.motor_dof, strict=True):
        joint = model.actuator_trnid[motor, 0]
        assert model.jnt_qposadr[joint] == qpos
        assert model.jnt_dofadr[joint] == dof
    assert [model.actuator(k).name for k in scene.arm_motors] == [
        f"arm/joint{k}" for k in range(1, 7)
    ]
    assert model.body(scene.palm).name == "hand/palm"
    assert model.body(scene.object_body).name == "object/object"
    assert model.jnt_type[model.body_jntadr[scene.object_body]] == mujoco.mjtJoint.mjJNT_FREE
    live = scene.taxel[scene.taxel >= 0]
    assert len(live) == len(set(live)) == 456
    assert live.max() < TACTILE_SIZE == 486
    # Thumb distal, row 3, column 4: after 3 * 84 proximal cells and two distal pads of 78.
    geom = model.geom("hand/thumb_distal_r03_c4").id
    assert scene.taxel[geom] == 3 * 84 + 2 * 78 + 3 * 6 + 4
    counts = np.bincount(scene.geom_group, minlength=5)
    assert counts[TABLE_GEOM] == 1
    assert counts[OBJECT_GEOM] >= 1
    assert counts[HAND_GEOM] > 456
    assert counts[ARM_GEOM] > 6


@pytest.mark.parametrize("name", object_names())
def test_nothing_touches_the_object_but_the_table_when_a_trial_begins(scenes, name):
    scene = scenes[name]
    data = mujoco.MjData(scene.model)
    for seed in range(2):
        motion = plan_motion(scene, np.random.default_rng(seed))
        place(scene, data, motion.grasp, motion.approach[0], motion.opening)
        mujoco.mj_forward(scene.model, data)
        groups = np.sort(scene.geom_group[data.contact.geom], axis=1)
        assert ((groups == (OBJECT_GEOM, TABLE_GEOM)).all(axis=1)).all(), groups
        assert data.body("object/object").xpos[:2] == pytest.approx((0.56, 0.0), abs=1e-9)


@pytest.mark.parametrize("name", object_names())
def test_object_stands_on_the_table_by_itself(scenes, name):
    scene, info = scenes[name], object_info(name)
    data = mujoco.MjData(scene.model)
    data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = sdh_press.ARM_POSTURE
    start = np.array([0.56, 0.0, info.standing_height, *info.standing_quat])
    data.qpos[scene.object_qpos : scene.object_qpos + 7] = start
    mujoco.mj_step(scene.model, data, 500)
    end = data.qpos[scene.object_qpos : scene.object_qpos + 7]
    assert end[:3] == pytest.approx(start[:3], abs=5e-4)
    assert abs(end[3:] @ start[3:]) == pytest.approx(1.0, abs=1e-5)
    assert not any(data.warning[k].number for k in range(mujoco.mjtWarning.mjNWARNING))


def test_the_arm_carries_the_hand(scenes):
    scene = scenes["box"]
    data = mujoco.MjData(scene.model)
    data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = sdh_press.ARM_POSTURE
    data.qpos[scene.object_qpos : scene.object_qpos + 3] = (0.56, 0.0, 0.2)
    mujoco.mj_step(scene.model, data, 250)
    assert data.qpos[scene.arm_qpos] == pytest.approx(sdh_press.ARM_POSTURE, abs=1e-4)
