"""Inverse kinematics, straight paths and their timing."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.cell import build_scene
from sdh_sim.robot import ArmKinematics, along
from sdh_sim.robot.arm import arm_speed_limit
from sdh_sim.robot.palm_motion import SPEED_SHARE
from sdh_sim.settings import TrialSettings

DOWN = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])  # the palm over the table, facing it
FORWARD = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # the palm's z along the world's x


@pytest.fixture(scope="module")
def arm() -> ArmKinematics:
    return ArmKinematics()


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arccos(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1)))


def test_limits_and_speeds_are_the_data_sheets(arm):
    assert np.degrees(arm.lower) == pytest.approx([-170, -100, -209, -190, -120, -350], abs=1e-4)
    assert np.degrees(arm.upper) == pytest.approx([170, 135, 76, 190, 120, 350], abs=1e-4)
    assert np.degrees(arm.speed_limit) == pytest.approx([250, 250, 250, 410, 410, 660], abs=1e-4)
    assert arm_speed_limit(arm.model) == pytest.approx(arm.speed_limit)


def test_palm_at_the_zero_pose_by_hand(arm):
    # The flange is at (560, 0, 790) mm and faces +x; the palm frame is 7.5 mm further.
    position, rotation = arm.palm_pose(np.zeros(6))
    assert position * 1e3 == pytest.approx((567.5, 0, 790), abs=1e-6)
    assert rotation[:, 2] == pytest.approx((1, 0, 0), abs=1e-9)


def test_palm_is_where_the_scene_has_it(arm):
    scene = build_scene(TrialSettings("box"))
    data = mujoco.MjData(scene.model)
    for q in np.random.default_rng(5).uniform(arm.lower, arm.upper, (10, 6)):
        data.qpos[scene.arm_qpos] = q
        mujoco.mj_kinematics(scene.model, data)
        position, rotation = arm.palm_pose(q)
        assert position == pytest.approx(data.xpos[scene.palm], abs=1e-9)
        assert rotation == pytest.approx(data.xmat[scene.palm].reshape(3, 3), abs=1e-9)


def test_solve_finds_random_reachable_poses(arm):
    # Poses of random postures, started from a posture some way off.
    rng = np.random.default_rng(1)
    low = np.maximum(arm.lower, -1.5) + 0.4
    high = np.minimum(arm.upper, 1.5) - 0.4
    found = 0
    for _ in range(25):
        q = rng.uniform(low, high)
        position, rotation = arm.palm_pose(q)
        start = q + rng.uniform(-0.25, 0.25, 6)
        answer = arm.solve(position, rotation, start)
        if answer is None:
            continue
        found += 1
        reached, turned = arm.palm_pose(answer)
        assert np.linalg.norm(reached - position) < 2.1e-4
        assert angle_between(turned, rotation) < 2.1e-3
        assert (answer >= arm.lower - 1e-9).all()
        assert (answer <= arm.upper + 1e-9).all()
    assert found >= 24


def test_reach_gets_to_the_work_space_from_side_and_top(arm):
    rng = np.random.default_rng(2)
    for base, low, high in ((FORWARD, (0.34, -0.08, 0.06), (0.40, 0.08, 0.25)),
                            (DOWN, (0.50, -0.04, 0.30), (0.60, 0.04, 0.42))):  # fmt: skip
        for _ in range(8):
            yaw = rng.uniform(-0.7, 0.7)
            turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0],
                             [0, 0, 1]])  # fmt: skip
            position, rotation = rng.uniform(low, high), turn @ base
            q = arm.reach(position, rotation)
            assert q is not None
            reached, turned = arm.palm_pose(q)
            assert np.linalg.norm(reached - position) < 2.1e-4
            assert angle_between(turned, rotation) < 2.1e-3
            assert ((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all()


@pytest.mark.parametrize(
    ("position", "rotation"),
    [((1.5, 0, 0.3), FORWARD), ((0.5, 0, 2.0), DOWN), ((0.05, 0.0, 0.30), FORWARD)],
)
def test_out_of_reach_is_none(arm, position, rotation):
    # The arm spans 365 + 405 + 80 mm from its shoulder: 1.5 m is nowhere near.
    assert arm.reach(np.array(position), rotation) is None


def test_straight_paths_are_straight(arm):
    start = arm.reach(np.array([0.55, 0.02, 0.32]), DOWN)
    assert start is not None
    home, rotation = arm.palm_pose(start)
    for motion in ((0, 0, 0.15), (-0.08, 0.0, 0.06), (0.0, 0.1, 0.0)):
        path = arm.straight(start, np.array(motion), spacing=0.012)
        assert path is not None
        assert path[0] == pytest.approx(start)
        goal, _ = arm.palm_pose(path[-1])
        assert goal == pytest.approx(home + motion, abs=3e-4)
        length = np.linalg.norm(motion)
        direction = np.array(motion) / length
        seen = []
        # Between the waypoints too, where the servo's reference runs straight in joint angles.
        for share in np.linspace(0, 1, 60):
            position, turned = arm.palm_pose(along(path, share))
            ahead = (position - home) @ direction
            aside = position - home - ahead * direction
            assert np.linalg.norm(aside) < 1e-3
            assert angle_between(turned, rotation) < 5e-3
            seen.append(ahead)
        assert np.all(np.diff(seen) > -3e-4)
        # Waypoints are spaced evenly, no further apart than asked.
        steps = np.diff([(arm.palm_pose(q)[0] - home) @ direction for q in path])
        assert steps == pytest.approx(np.full(len(steps), length / len(steps)), abs=4e-4)
        assert length / len(steps) <= 0.012 + 1e-9


def test_the_lift_is_straight_with_the_spacing_that_trials_use(arm):
    start = arm.reach(np.array([0.55, 0.02, 0.32]), DOWN)
    path = arm.straight(start, np.array([0.0, 0.0, 0.15]))
    home, _ = arm.palm_pose(start)
    aside = [arm.palm_pose(along(path, s))[0][:2] - home[:2] for s in np.linspace(0, 1, 80)]
    assert np.linalg.norm(aside, axis=1).max() < 1.5e-3


def test_straight_out_of_reach_is_none(arm):
    start = arm.reach(np.array([0.55, 0.0, 0.32]), DOWN)
    assert arm.straight(start, np.array([0.6, 0.0, 0.0])) is None


def test_duration_keeps_every_speed_limit(arm):
    start = arm.reach(np.array([0.55, 0.02, 0.32]), DOWN)
    path = arm.straight(start, np.array([0.0, 0.0, 0.15]))
    duration = arm.duration(path, 0.0)
    shares = np.linspace(0, 1, 4001)
    speed = np.abs(np.diff([along(path, s) for s in shares], axis=0)) / (duration / 4000)
    used = (speed / arm.speed_limit).max()
    assert used <= 0.9 + 1e-6
    assert used > 0.5  # and wastes no time
    assert arm.duration(path, 9.0) == 9.0


def test_duration_by_hand(arm):
    # One joint turns 1 rad in two equal steps: mean speed 1/T, greatest 15/8 of it, at most 0.9
    # of 250 deg/s = 3.92699 rad/s: T = 1.875 / 3.92699 = 0.477465 s.
    path = np.zeros((3, 6))
    path[:, 0] = (0.0, 0.5, 1.0)
    assert arm.duration(path, 0.1) == pytest.approx(0.477465, abs=1e-6)
    assert SPEED_SHARE == 0.9


def test_along_is_minimum_jerk():
    path = np.linspace(0, 1, 6)[:, None] * np.ones(6)
    assert along(path, 0.0) == pytest.approx(np.zeros(6))
    assert along(path, 1.0) == pytest.approx(np.ones(6))
    assert along(path, 0.5) == pytest.approx(np.full(6, 0.5))
    # 10 s^3 - 15 s^4 + 6 s^5 at 0.25: .15625 - .0585938 + .0058594 = .1035156
    assert along(path, 0.25) == pytest.approx(np.full(6, 0.1035156), abs=1e-6)
    assert along(path, -1.0) == pytest.approx(np.zeros(6))
    assert along(path, 7.0) == pytest.approx(np.ones(6))
    h = 1e-3  # it starts and ends at rest
    assert np.abs(along(path, h) - along(path, 0)).max() / h < 1e-4
    assert np.abs(along(path, 1) - along(path, 1 - h)).max() / h < 1e-4
