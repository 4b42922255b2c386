"""Given grasps: poses in the object's frame and back, turning, feasibility and its reasons."""

from __future__ import annotations

import dataclasses
import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sdh_sim import poses
from sdh_sim.cell import build_scene
from sdh_sim.errors import SettingsError
from sdh_sim.grasping import (
    GraspPlan,
    Infeasible,
    MotionPlan,
    closing_arc,
    motion_plan,
    place,
    plan_given,
    plan_motion,
    sample_grasp,
)
from sdh_sim.grasping.grasp_plan import standing_pose
from sdh_sim.objects import object_info, object_names
from sdh_sim.robot import closing_between, palm_motion_of, preshape_closing
from sdh_sim.settings import TrialSettings
from tests.support.sdh2 import SDH2

PARALLEL = preshape_closing("parallel")


@pytest.fixture(scope="module")
def scene():
    return build_scene(TrialSettings("cylindrical_bottle"))


@pytest.mark.parametrize("name", object_names())
def test_a_pose_in_the_object_s_frame_comes_back(name):
    obj, rng = object_info(name), np.random.default_rng(3)
    for yaw in (0.0, 1.3, -3.0):
        quat = Rotation.random(rng=rng).as_quat(scalar_first=True)
        pose = np.concatenate((rng.uniform(-0.2, 0.2, 3), quat))
        back = GraspPlan.from_pose(obj, pose, PARALLEL, object_yaw=yaw).palm_in_object(obj)
        assert back[:3] == pytest.approx(pose[:3], abs=1e-12)
        assert abs(back[3:] @ pose[3:]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("name", object_names())
def test_a_random_grasp_is_the_same_as_a_given_one(name):
    obj, rng = object_info(name), np.random.default_rng(5)
    for _ in range(10):
        plan = sample_grasp(SDH2, obj, rng).plan(SDH2)
        pose = plan.palm_in_object(obj)
        same = GraspPlan.from_pose(obj, pose, plan.closing, object_yaw=plan.object_yaw)
        assert same.palm_position == pytest.approx(plan.palm_position, abs=1e-12)
        assert same.palm_rotation == pytest.approx(plan.palm_rotation, abs=1e-12)


def test_turning_keeps_the_hand_on_the_object():
    obj = object_info("box")
    plan = sample_grasp(SDH2, obj, np.random.default_rng(0)).plan(SDH2)
    turned = plan.turned(2.0)
    assert turned.palm_in_object(obj)[:3] == pytest.approx(plan.palm_in_object(obj)[:3], abs=1e-12)
    assert math.remainder(turned.object_yaw - plan.object_yaw - 2.0, 2 * math.pi) == pytest.approx(
        0.0, abs=1e-12
    )
    # A quarter turn about (0.56, 0): what lies along x from there lies along y.
    aside = dataclasses.replace(plan, palm_position=np.array([0.76, 0.0, 0.3]))
    assert aside.turned(math.pi / 2).palm_position == pytest.approx([0.56, 0.2, 0.3])


def test_moving_is_in_the_palm_s_axes():
    plan = GraspPlan(np.zeros(3), DOWN, 0.0, PARALLEL)
    moved = plan.moved(np.array([0.01, 0.02, 0.03]), math.pi / 2)
    assert moved.palm_position == pytest.approx([0.01, -0.02, -0.03])
    assert moved.palm_rotation[:, 0] == pytest.approx([0.0, -1.0, 0.0])  # x goes to y
    assert moved.palm_rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"palm_pose": [0, 0, 0.2, 1, 0, 0]}, "palm_pose: got"),
        ({"palm_pose": [0, 0, math.nan, 1, 0, 0, 0]}, "palm_pose: got"),
        ({"palm_pose": "above"}, "palm_pose: got 'above'"),
        ({"palm_pose": [0, 0, 0.2, 1, 1, 0, 0]}, "has the length 1.41421356; give a unit one"),
        ({"opening": 1.2}, "opening: got 1.2; allowed is 0"),
        ({"opening": math.nan}, "opening: got nan"),
        ({"object_yaw": math.inf}, "object_yaw: got inf"),
    ],
)
def test_what_is_no_grasp_is_refused(change, words):
    given = {"palm_pose": [0, 0, 0.2, 0, 1, 0, 0], "closing": PARALLEL} | change
    with pytest.raises(SettingsError, match=words):
        GraspPlan.from_pose(object_info("box"), **given)


DOWN = np.diag([1.0, -1.0, -1.0])


def given(scene, position, rotation, **more) -> GraspPlan:
    """A palm pose in the world while the object stands at yaw 0, as one of its own frame."""
    palm = np.concatenate((position, poses.quaternion_of(np.array(rotation))))
    pose = poses.relative(standing_pose(scene.obj, 0.0), palm)
    return GraspPlan.from_pose(scene.obj, pose, PARALLEL, **more)


def above(scene, height: float, **more) -> GraspPlan:
    """The palm over the object's axis and looking down, at a height over its top [m]."""
    return given(scene, [0.56, 0.0, scene.obj.height + height], DOWN, **more)


def test_a_given_grasp_gets_a_motion(scene):
    motion = plan_given(scene, above(scene, 0.20))
    assert isinstance(motion, MotionPlan)
    assert motion.opening in motion_plan.OPENINGS
    fixed = plan_given(scene, above(scene, 0.20, opening=0.25, object_yaw=0.0))
    assert isinstance(fixed, MotionPlan)
    assert (fixed.opening, fixed.grasp.object_yaw) == (0.25, 0.0)


def test_a_free_yaw_is_turned_until_the_arm_can(scene):
    # The palm looks toward the robot from behind the bottle: no arm reaches round it.
    behind, back = [0.76, 0.0, 0.12], [[0, 0, -1], [-1, 0, 0], [0, 1, 0]]
    from_behind = given(scene, behind, back, object_yaw=0.0)
    failed = plan_given(scene, from_behind)
    assert isinstance(failed, Infeasible)
    assert failed.kind == motion_plan.UNREACHABLE
    free = given(scene, behind, back)
    found = plan_given(scene, free)
    assert isinstance(found, MotionPlan)
    assert abs(found.grasp.object_yaw) > 1.0
    pose, wanted = (plan.palm_in_object(scene.obj) for plan in (found.grasp, free))
    assert pose[:3] == pytest.approx(wanted[:3], abs=1e-12)


@pytest.mark.parametrize(
    ("height", "more", "kind", "words"),
    [
        (0.02, {}, "colliding", "the open hand or the arm touches the object on its way"),
        (0.60, {"object_yaw": 0.0}, "unreachable", "the arm cannot"),
        (0.20, {"opening": 0.9}, "colliding", "the open hand or the arm touches the object"),
    ],
)
def test_reasons_say_what_is_in_the_way(scene, height, more, kind, words):
    found = plan_given(scene, above(scene, height, **more))
    assert isinstance(found, Infeasible)
    assert found.kind == kind
    assert words in found.reason


def low(scene, palm_height: float) -> GraspPlan:
    """Straight down beside the object, whose axis is far away, the palm at a height [m]."""
    return GraspPlan(np.array([0.45, 0.25, palm_height]), DOWN, 0.0, PARALLEL, 0.0)


def test_the_arc_of_the_fingers_meets_the_table_by_their_length(scene):
    # The fingertips get 91 + 86.5 + 68.5 = 246 mm before the palm frame when a finger is
    # straight, which the parallel preshape is at 75/82 of its closing; open they get less.
    data = mujoco.MjData(scene.model)
    met = {}
    for height in (0.2430, 0.2490):
        plan = low(scene, height)
        place(scene, data, plan, np.zeros(6), 0.0)
        palm_to(scene, data, plan)
        met[height] = closing_arc(scene, data, plan, 0.0).blocked_by
    assert met == {0.2430: "the table", 0.2490: ""}


def palm_to(scene, data, plan):
    data.qpos[scene.arm_qpos] = palm_motion_of("servo", SDH2).reach(
        plan.palm_position, plan.palm_rotation
    )


@pytest.mark.parametrize(("height", "turn", "sideways"), [(0.235, 90, 0), (0.15, 0, 3)])
def test_fingers_that_land_on_top_do_not_grip(height, turn, sideways):
    # Palm down over the box, closing across its wider side, 69 mm either way. A proximal link at
    # angle p holds its fingertip 91 + 86.5 cos p + 68.5 mm before the palm, which is 235 mm at
    # p = -29 degrees, and the pad 19.05 + 86.5 sin 29 - 14.8 = 46 mm from the axis: on the top.
    # Across the narrower side, 36 mm either way, the fingers close beside it.
    scene = build_scene(TrialSettings("box"))
    data = mujoco.MjData(scene.model)
    yaw = scene.obj.narrow_yaw + math.radians(turn)
    plan = dataclasses.replace(above(scene, height), object_yaw=yaw)
    place(scene, data, plan, np.zeros(6), 0.0)
    palm_to(scene, data, plan)
    arc = closing_arc(scene, data, plan, 0.0)
    assert arc.stopped.all()
    assert arc.sideways.sum() == sideways


def test_random_grasps_aim_with_two_fingers_at_least():
    scene = build_scene(TrialSettings("box"))
    data = mujoco.MjData(scene.model)
    for seed in range(5):
        motion = plan_motion(scene, np.random.default_rng(seed))
        drawn = motion.grasp.drawn
        assert drawn is not None
        place(scene, data, motion.grasp, motion.approach[-1], motion.opening)
        arc = closing_arc(scene, data, motion.grasp, motion.opening)
        data.qpos[scene.object_qpos : scene.object_qpos + 3] += (
            motion.grasp.palm_rotation @ drawn.offset
        )
        aimed = closing_arc(scene, data, motion.grasp, motion.opening)
        assert arc.blocked_by == ""
        assert max(arc.sideways.sum(), aimed.sideways.sum()) >= 2


def test_closings_of_one_s_own_are_lifted(scene):
    own = closing_between([0, -0.9, 0.9, -0.9, 0.9, -0.9, 0.9], [0, 0.1, 0, 0.1, 0, 0.1, 0])
    plan = dataclasses.replace(above(scene, 0.18), closing=own)
    assert isinstance(plan_given(scene, plan), MotionPlan)
