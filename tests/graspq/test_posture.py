"""Measures of the hand's posture in closed form."""

import numpy as np
import pytest

import graspq as gq

L1, L2 = 0.09, 0.08


def planar_arm(q1, q2):
    """Jacobian of the tip of two links in a plane."""
    a, b = q1, q1 + q2
    return np.array(
        [
            [-L1 * np.sin(a) - L2 * np.sin(b), -L2 * np.sin(b)],
            [L1 * np.cos(a) + L2 * np.cos(b), L2 * np.cos(b)],
        ]
    )


def test_the_range_is_measured_from_its_middle():
    low, high = [-1.0, 0.0, 0.0], [1.0, 2.0, 4.0]
    assert gq.range_deviation([0.0, 1.0, 2.0], low, high) == 0.0
    assert gq.range_deviation([1.0, 0.0, 4.0], low, high) == pytest.approx(0.75)
    assert gq.range_deviation([0.0, 1.0, 3.0], low, high) == pytest.approx(1 / 16)
    # In degrees it is the same.
    degrees = [np.rad2deg(x) for x in ([0.3, 1.0, 3.0], low, high)]
    assert gq.range_deviation(*degrees) == pytest.approx(gq.range_deviation([0.3, 1, 3], low, high))


@pytest.mark.parametrize("q2", [0.2, 1.0, np.pi / 2, 2.5])
def test_a_planar_arm_has_the_manipulability_of_its_parallelogram(q2):
    jacobian = planar_arm(0.4, q2)
    assert gq.manipulability(jacobian) == pytest.approx(L1 * L2 * np.sin(q2))
    # The same wherever the arm points, in the other order of joints, with an idle joint beside.
    other = np.column_stack([planar_arm(1.7, q2)[:, ::-1], np.zeros(2)])
    assert gq.manipulability(other) == pytest.approx(gq.manipulability(jacobian))
    assert gq.singularity_distance(other) == pytest.approx(gq.singularity_distance(jacobian))
    # σmin σmax = |det|.
    largest = np.linalg.norm(jacobian, 2)
    assert gq.singularity_distance(jacobian) == pytest.approx(L1 * L2 * np.sin(q2) / largest)
    assert gq.singularity_distance(3.0 * jacobian) == pytest.approx(
        3.0 * gq.singularity_distance(jacobian)
    )


def test_a_straight_arm_is_singular():
    assert gq.singularity_distance(planar_arm(0.4, 0.0)) == 0.0
    assert gq.manipulability(planar_arm(0.4, 0.0)) == 0.0


def test_a_tall_jacobian_counts_its_joints():
    jacobian = np.vstack([np.diag([2.0, 3.0]), np.zeros((4, 2))])
    assert gq.manipulability(jacobian) == pytest.approx(6.0)
    assert gq.singularity_distance(jacobian) == pytest.approx(2.0)


def test_uniformity_is_that_of_the_object_s_motion():
    # G = 1: contacts move as the object does.
    assert gq.transmission_uniformity(np.eye(6), 5.0 * np.eye(6)) == pytest.approx(1.0)
    assert gq.transmission_uniformity(np.eye(6), np.diag([1, 2, 3, 4, 5, 8.0])) == pytest.approx(
        1 / 8
    )
    # Two contacts at one place: the object moves by the mean of theirs.
    double = np.hstack([np.eye(6), np.eye(6)])
    both = np.vstack([np.diag([1, 2, 2, 2, 2, 2.0])] * 2)
    assert gq.transmission_uniformity(double, both) == pytest.approx(0.5)
    # Joints that work against each other do not move it.
    against = np.vstack([np.diag([1, 1, 1, 1, 1, 1.0]), -np.eye(6)])
    assert gq.transmission_uniformity(double, against) == 0.0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gq.range_deviation([0.1], [0.0], [0.0]), "upper: expected every entry above"),
        (lambda: gq.range_deviation([0.1], [0.0, 1.0], [1.0]), "lower: expected shape"),
        (lambda: gq.range_deviation([], [], []), "got no joint"),
        (lambda: gq.range_deviation([np.nan], [0.0], [1.0]), "must be finite"),
        (lambda: gq.singularity_distance(np.zeros((3, 2))), "without an entry other than 0"),
        (lambda: gq.singularity_distance(np.zeros((0, 2))), "without an entry other than 0"),
        (lambda: gq.manipulability([1.0, 2.0]), "jacobian: expected shape"),
        (lambda: gq.transmission_uniformity(np.eye(5), np.eye(5)), "grasp_map: expected shape"),
        (lambda: gq.transmission_uniformity(np.eye(6), np.eye(5)), "one row per column"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(gq.GraspError, match=words):
        call()
