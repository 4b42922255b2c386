"""Stable poses against what statics says on paper, and objects at rest in the simulation."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import trimesh

from sdh_sim.cell import build_scene
from sdh_sim.cell.contacts import robot_touches
from sdh_sim.grasping.grasp_sampler import OBJECT_POSITION
from sdh_sim.objects import object_info, user_object
from sdh_sim.objects.stable_poses import margin_within, stable_poses
from sdh_sim.poses import rotation_of, turn_between
from sdh_sim.settings import TrialSettings
from tests.support.object_files import FACTS, MUG, A, B, C, block, info_of, object_folder, refusal

DOWN = np.array([0.0, 0.0, -1.0])


def test_a_block_rests_on_its_six_sides():
    found = list(stable_poses(np.array(block().vertices), np.zeros(3), DOWN))
    assert [pose.tilt for pose in found] == pytest.approx([0.0, *[np.pi / 2] * 4, np.pi])
    # Of equal tilt the lowest comes first.
    heights = [C, A, A, B, B, C]
    assert [2 * pose.height for pose in found] == pytest.approx(heights)


def test_of_equal_tilt_the_lowest_comes_first_whatever_its_area():
    com = np.array([0.02, 0.0, 0.0])
    found = list(stable_poses(np.array(block().vertices), com, DOWN))
    heights = [A / 2 - 0.02, B / 2, B / 2, A / 2 + 0.02]
    assert [pose.height for pose in found[1:5]] == pytest.approx(heights)


def test_a_centre_of_mass_over_no_side_leaves_out_that_side():
    # A sheared block: over its base stands the centre of mass only while the shear is below A / 2.
    points = np.array(block((0.0, 0.0, C / 2)).vertices)
    for shift, rests in ((0.45 * A, True), (0.55 * A, False)):
        com = np.array([shift, 0.0, C / 2])
        sheared = points + np.outer(points[:, 2], [2 * shift / C, 0.0, 0.0])
        found = list(stable_poses(sheared, com, DOWN))
        assert (found[0].tilt == pytest.approx(0.0, abs=1e-9)) is rests


def test_a_loaded_cube_rests_on_the_sides_that_its_centre_of_mass_is_over():
    # Every side of a cube is below a point inside it: loads change heights, not the sides.
    cube = np.array(block(size=(0.04,) * 3).vertices)
    com = np.array([0.015, 0.0, 0.0])
    found = list(stable_poses(cube, com, np.array([1.0, 0.0, 0.0])))
    assert len(found) == 6
    assert found[0].height == pytest.approx(0.005)


def test_triangles_of_one_facet_are_one():
    mesh = block().subdivide().subdivide()
    noise = np.random.default_rng(0).normal(size=mesh.vertices.shape) * 1e-9
    assert len(list(stable_poses(mesh.vertices + noise, np.zeros(3), DOWN))) == 6


def test_the_margin_is_the_distance_from_the_nearest_side():
    square = np.array([[x, y, 0.0] for x in (0, 2) for y in (0, 1)])
    assert margin_within(square, np.array([0.7, 0.5, 9.0]), DOWN) == pytest.approx(0.5)
    assert margin_within(square, np.array([0.2, 0.5, 9.0]), DOWN) == pytest.approx(0.2)
    assert margin_within(square, np.array([-0.2, 0.5, 9.0]), DOWN) == pytest.approx(-0.2)
    assert margin_within(square[:2], np.array([0.0, 0.5, 9.0]), DOWN) == -np.inf


def wedge_base(angle: float) -> trimesh.Trimesh:
    """A block whose base slopes along x by an angle [rad]."""
    mesh = block((0.0, 0.0, C / 2))
    low = mesh.vertices[:, 2] < 1e-9
    mesh.vertices[low, 2] = (mesh.vertices[low, 0] + A / 2) * np.tan(angle)
    return mesh


def tilt_of(path) -> float:
    """Angle between the object's z and the vertical as it stands [deg]."""
    return float(np.degrees(np.arccos(rotation_of(info_of(path).standing_quat)[2, 2])))


@pytest.mark.parametrize("angle", [0.5, 3.0, 11.0])
def test_an_uneven_base_tilts_by_its_slope(tmp_path, angle):
    path = object_folder(tmp_path, wedge_base(np.radians(angle)))
    # Its base is flat against the table; that yields under the side where the weight lies.
    assert tilt_of(path) == pytest.approx(angle, abs=0.5)
    assert "stable pose 1, tilted by" in user_object(path).reference.notes[0]


def test_what_would_tilt_far_is_refused_and_may_be_chosen(tmp_path):
    steep = wedge_base(np.radians(20.0))
    text = refusal(object_folder(tmp_path, steep))
    assert 'its nearest stable pose is tilted by 20.0°: take that with pose = "stable:1"' in text
    path = object_folder(tmp_path / "b", steep, FACTS + 'pose = "stable:1"')
    assert tilt_of(path) == pytest.approx(20.0, abs=0.5)
    path = object_folder(tmp_path / "c", facts=FACTS + 'pose = "stable:2"')
    assert tilt_of(path) == pytest.approx(90.0, abs=0.2)
    # On its widest side it is lowest, so that one has number 2.
    assert info_of(path).height == pytest.approx(A, abs=5e-4)


def test_a_base_too_narrow_for_a_table_that_yields_is_refused(tmp_path):
    # A foot of 1 mm: the centre of mass is over it, but a table that yields by 0.2 mm tips it.
    mesh = trimesh.util.concatenate(
        [block((0, 0, 0.07), (0.04, 0.04, 0.1)), block((0, 0, 0.01), (0.001, 0.04, 0.02))]
    )
    assert "it falls over: put on the table with z up, it tips by" in refusal(
        object_folder(tmp_path, mesh)
    )


XML = "<mujoco><compiler angle='degree'/><worldbody><body>{}</body></worldbody></mujoco>"
SHAPES = {
    "block": (None, "stl"),
    "sloping base": (wedge_base(np.radians(4.0)), "stl"),
    "ball of triangles": (trimesh.creation.icosphere(2, 0.04), "stl"),
    "cylinder": (XML.format("<geom type='cylinder' size='0.03 0.05'/>"), "xml"),
    "cylinder on its side": (
        XML.format("<geom type='cylinder' size='0.03 0.05' euler='90 0 0'/>"),
        "xml",
    ),
    "ball": (XML.format("<geom type='sphere' size='0.04'/>"), "xml"),
}


@pytest.mark.parametrize("name", [*SHAPES, "mug"])
def test_an_object_is_at_rest_before_the_hand_comes(tmp_path, name):
    path = (
        MUG if name == "mug" else object_folder(tmp_path, SHAPES[name][0], ending=SHAPES[name][1])
    )
    found = user_object(path)
    scene = build_scene(TrialSettings(found.name, folder=found.reference))
    obj = object_info(found.name, found.reference)
    data = mujoco.MjData(scene.model)
    pose = data.qpos[scene.object_qpos : scene.object_qpos + 7]
    pose[:] = (*OBJECT_POSITION, obj.standing_height, *obj.standing_quat)
    data.ctrl[scene.arm_motors] = data.qpos[scene.arm_qpos]
    data.ctrl[scene.motors] = data.qpos[scene.motor_qpos]
    start = pose.copy()
    mujoco.mj_forward(scene.model, data)
    assert not robot_touches(scene, data)
    for _ in range(round(1.0 / scene.model.opt.timestep)):
        mujoco.mj_step(scene.model, data)
        assert np.linalg.norm(pose[:2] - start[:2]) < 1e-4
        # The table yields under what stands exactly, 0.2 mm flat and 0.6 mm under one point.
        assert -8e-4 < pose[2] - start[2] < 1e-4
        assert turn_between(start, pose) < np.radians(0.1)


def test_a_ball_and_a_bottle_on_its_mouth_are_told_apart(tmp_path):
    upright = XML.format("<geom type='capsule' size='0.03 0.03'/>")
    assert "it falls over" in refusal(object_folder(tmp_path, upright, ending="xml"))
    egg = XML.format("<geom type='ellipsoid' size='0.03 0.03 0.05'/>")
    assert "it falls over" in refusal(object_folder(tmp_path / "b", egg, ending="xml"))
    flat = XML.format("<geom type='ellipsoid' size='0.05 0.05 0.03'/>")
    found = info_of(object_folder(tmp_path / "c", flat, ending="xml"))
    assert found.standing_quat == pytest.approx((1, 0, 0, 0))
