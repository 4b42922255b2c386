"""Poses: identities of the group of rigid motions, and known turns."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sdh_sim import poses

HALF = math.sqrt(0.5)


def random_pose(rng: np.random.Generator) -> np.ndarray:
    quat = rng.normal(size=4)
    return np.concatenate((rng.normal(size=3), quat / np.linalg.norm(quat)))


@pytest.fixture
def three() -> list[np.ndarray]:
    rng = np.random.default_rng(7)
    return [random_pose(rng) for _ in range(3)]


def test_a_quarter_turn_about_z_takes_x_to_y():
    assert poses.rotate(poses.about_z(math.pi / 2), np.array([1.0, 0, 0])) == pytest.approx(
        [0, 1, 0], abs=1e-15
    )
    assert poses.about_z(math.pi / 2) == pytest.approx([HALF, 0, 0, HALF])


def test_rotation_matrix_and_quaternion_turn_alike(three):
    vector = np.array([0.3, -1.0, 2.0])
    for pose in three:
        matrix = poses.rotation_of(pose[3:])
        assert matrix @ vector == pytest.approx(poses.rotate(pose[3:], vector), abs=1e-14)
        assert matrix.T @ matrix == pytest.approx(np.eye(3), abs=1e-14)
        assert np.linalg.det(matrix) == pytest.approx(1.0)


def test_composition_is_one_transform_after_the_other(three):
    a, b, _ = three
    point = np.array([0.1, 0.2, -0.3])
    one_by_one = poses.transform(a, poses.transform(b, point))
    assert poses.transform(poses.compose(a, b), point) == pytest.approx(one_by_one, abs=1e-14)


def test_composition_is_associative(three):
    a, b, c = three
    first = poses.compose(poses.compose(a, b), c)
    assert first == pytest.approx(poses.compose(a, poses.compose(b, c)), abs=1e-14)


def test_relative_undoes_composition(three):
    a, b, _ = three
    assert poses.relative(a, poses.compose(a, b)) == pytest.approx(b, abs=1e-14)
    assert poses.relative(a, a) == pytest.approx([0, 0, 0, 1, 0, 0, 0], abs=1e-15)


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, math.pi])
def test_turn_between_two_poses(three, angle):
    for pose in three:
        turned = pose.copy()
        turned[3:] = poses.product(pose[3:], poses.about_z(angle))
        assert poses.turn_between(pose, turned) == pytest.approx(angle, abs=1e-7)
        turned[3:] *= -1.0  # the same orientation
        assert poses.turn_between(pose, turned) == pytest.approx(angle, abs=1e-7)
