"""Least-effort contact forces: closed forms, limits, and infeasible wrenches."""

import numpy as np
import pytest

import graspq as gq


def pair(mu=0.5, g=20.0, torsion=0.0):
    return [gq.Contact([s * 0.03, 0, 0], [-s, 0, 0], mu, g, torsion) for s in (1.0, -1.0)]


def test_two_fingers_press_no_harder_than_friction_needs():
    f = gq.contact_forces(pair(), [0, 0, 4.0, 0, 0, 0], edges=12)
    # 2 N of friction each; the inscribed 12-gon is μ cos 15° wide along an edge's middle.
    push = 2.0 / (0.5 * np.cos(np.pi / 12))
    np.testing.assert_allclose(f.point_forces[0], [[-push, 0, 2.0]], atol=1e-5)
    assert f.effort == pytest.approx(2 * (push**2 + 4), rel=1e-5)
    np.testing.assert_allclose(f.wrenches.sum(0), [0, 0, 4.0, 0, 0, 0], atol=1e-5)


def test_torsion_carries_a_twist():
    f = gq.contact_forces(pair(torsion=0.1), [0, 0, 4.0, 0.02, 0, 0])
    np.testing.assert_allclose(f.wrenches.sum(0), [0, 0, 4.0, 0.02, 0, 0], atol=1e-5)
    assert f.torsions.tolist() == pytest.approx([-0.01, 0.01], abs=1e-5)


def test_forces_stay_in_their_cones_and_limits():
    rng = np.random.default_rng(2)
    for _ in range(10):
        made = []
        for _ in range(4):
            n = rng.normal(size=3)
            n /= np.linalg.norm(n)
            made.append(gq.Contact(-0.05 * n, n, 0.8, 5.0))
        task = rng.normal(size=6) * [1, 1, 1, 0.05, 0.05, 0.05]
        reach = gq.task_scaling([gq.contact_wrenches(c) for c in made], task).value
        if reach < 1e-6:
            continue
        f = gq.contact_forces(made, 0.8 * reach * task)
        np.testing.assert_allclose(f.wrenches.sum(0), 0.8 * reach * task, atol=1e-4)
        for contact, force in zip(made, f.point_forces, strict=True):
            normal = float(force[0] @ contact.normal)
            side = np.linalg.norm(force[0] - normal * contact.normal)
            assert side <= 0.8 * normal + 1e-4
            assert normal <= 5.0 + 1e-4
        with pytest.raises(gq.GraspError, match="no forces"):
            gq.contact_forces(made, 1.2 * reach * task)


def test_a_hand_limits_by_its_motors():
    jacobians = [np.zeros((3, 2)), np.zeros((3, 2))]
    jacobians[0][0, 0], jacobians[1][0, 1] = -0.1, 0.1
    hand = gq.HandBound(pair(), jacobians, [1.0, 1.0])
    f = gq.contact_forces(hand, [0, 0, 4.0, 0, 0, 0])
    assert f.motor_torque is not None
    np.testing.assert_allclose(
        f.motor_torque, np.full(2, 0.1 * 2 / (0.5 * np.cos(np.pi / 12))), atol=1e-6
    )
    with pytest.raises(gq.GraspError, match="motor"):
        gq.contact_forces(hand, [0, 0, 11.0, 0, 0, 0])


def test_bad_input():
    with pytest.raises(gq.GraspError, match="grip"):
        gq.contact_forces([], [0, 0, 1.0, 0, 0, 0])
    with pytest.raises(gq.GraspError, match="wrench"):
        gq.contact_forces(pair(), [0, 0, 1.0])
