"""Contacts, their limits and their wrench sets against closed forms."""

import numpy as np
import pytest

import graspq as gq


def disc(**more):
    return gq.Contact([0.1, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.5, 4.0, **more)


def test_hard_finger_samples_lie_on_the_friction_circle():
    w = gq.contact_wrenches(disc(), edges=12)
    assert w.shape == (6, 12)
    np.testing.assert_allclose(w[0], -4.0)
    np.testing.assert_allclose(np.hypot(w[1], w[2]), 0.5 * 4.0)
    np.testing.assert_allclose(w[3:], np.cross([0.1, 0, 0], w[:3].T).T, atol=1e-15)
    angle = np.sort(np.arctan2(w[2], w[1]))
    np.testing.assert_allclose(np.diff(angle), np.pi / 6)


def test_soft_finger_adds_two_apices():
    w = gq.contact_wrenches(disc(max_torsion=0.3))
    assert w.shape == (6, 14)
    np.testing.assert_allclose(
        w[:, 12:], np.array([[-4.0, 0, 0, -0.3, 0, 0], [-4.0, 0, 0, 0.3, 0, 0]]).T, atol=1e-15
    )


@pytest.mark.parametrize(("augment", "columns"), [("none", 14), ("fl", 16), ("hf", 38), ("sf", 42)])
def test_augmentation_acts_at_every_taxel(augment, columns):
    patch = np.array([[0.1, 0.01, 0.0], [0.1, -0.01, 0.0]])
    w = gq.contact_wrenches(disc(max_torsion=0.3, patch=patch), augment=augment)
    assert w.shape == (6, columns)
    np.testing.assert_allclose(w[:, :14], gq.contact_wrenches(disc(max_torsion=0.3)))
    if augment == "fl":
        np.testing.assert_allclose(w[:, 14], [-4, 0, 0, *np.cross(patch[0], [-4, 0, 0])])
    if augment == "hf":
        there = gq.Contact(patch[1], [-1, 0, 0], 0.5, 4.0)
        np.testing.assert_allclose(w[:, 26:], gq.contact_wrenches(there))


def test_torque_scale_and_origin_move_only_the_moment():
    w = gq.contact_wrenches(disc(), torque_scale=10.0, origin=[0.1, 0.0, 0.0])
    np.testing.assert_allclose(w[3:], 0.0, atol=1e-14)
    v = gq.contact_wrenches(disc(), torque_scale=10.0)
    np.testing.assert_allclose(v[3:], 10.0 * gq.contact_wrenches(disc())[3:])
    np.testing.assert_allclose(v[:3], w[:3])


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (dict(position=[0, 0]), "position"),
        (dict(position=[0, 0, np.nan]), "position"),
        (dict(normal=[0, 0, 2.0]), "normal"),
        (dict(friction=-0.1), "friction"),
        (dict(max_normal_force=-1.0), "max_normal_force"),
        (dict(max_torsion=np.inf), "max_torsion"),
        (dict(patch=np.zeros((0, 3))), "patch"),
        (dict(patch=[[0, 0]]), "patch"),
    ],
)
def test_bad_contacts_are_named(arguments, named):
    good = dict(position=[0, 0, 0], normal=[0, 0, 1.0], friction=0.5)
    with pytest.raises(gq.GraspError, match=named):
        gq.Contact(**{**good, **arguments})


@pytest.mark.parametrize(
    "arguments",
    [
        dict(augment="soft"),
        dict(augment="hf"),
        dict(edges=2),
        dict(edges=3.5),
        dict(torque_scale=0),
        dict(origin=[0, 0]),
    ],
)
def test_bad_sampling_is_refused(arguments):
    with pytest.raises(gq.GraspError, match=next(iter(arguments))):
        gq.contact_wrenches(disc(), **arguments)


def test_contacts_cannot_be_changed():
    contact = disc()
    with pytest.raises(ValueError, match="read-only"):
        contact.position[0] = 1.0


def test_max_normal_force_is_the_weakest_joint():
    jacobian = np.array([[0.1, 0.05], [0.0, 0.0], [0.0, 0.0]])
    assert gq.max_normal_force(jacobian, [1, 0, 0], [1.0, 0.4]) == pytest.approx(8.0)
    assert gq.max_normal_force(-jacobian, [1, 0, 0], [1.0, 0.6]) == pytest.approx(10.0)
    with pytest.raises(gq.GraspError, match="no joint is loaded"):
        gq.max_normal_force(jacobian, [0, 1, 0], [1.0, 0.4])


def test_max_normal_force_solves_the_linear_program():
    from scipy.optimize import linprog

    rng = np.random.default_rng(3)
    for _ in range(20):
        jacobian, limit = rng.normal(size=(3, 5)), rng.uniform(0.1, 2, 5)
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        load = (jacobian.T @ normal)[:, None]
        best = linprog([-1.0], A_ub=np.vstack([load, -load]), b_ub=np.tile(limit, 2))
        assert gq.max_normal_force(jacobian, normal, limit) == pytest.approx(best.x[0])


def test_max_torsion_of_a_ring_and_of_weights():
    angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    ring = 0.01 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert gq.max_torsion(0.5, 6.0, np.ones(8), ring, [0, 0, 0]) == pytest.approx(0.5 * 6 * 0.01)
    line = [[0, 0, 0], [0.02, 0, 0]]
    assert gq.max_torsion(1.0, 1.0, [3.0, 1.0], line, [0, 0, 0]) == pytest.approx(0.005)
    with pytest.raises(gq.GraspError, match="pressures"):
        gq.max_torsion(1.0, 1.0, [0.0, 0.0], line, [0, 0, 0])


def test_gravity_tasks_hold_the_object_up():
    com, gravity = np.array([0.02, 0.0, 0.05]), np.array([0.0, 0.0, -9.81])
    tasks = gq.gravity_tasks(0.5, com, gravity)
    assert tasks.shape == (6, 20)
    np.testing.assert_allclose(tasks[:3].T, np.tile([0, 0, 0.5 * 9.81], (20, 1)))
    np.testing.assert_allclose(tasks[3:, 0], np.cross(com, [0, 0, 0.5 * 9.81]))
    off = tasks[3:, 1:] - tasks[3:, :1]
    np.testing.assert_allclose(np.linalg.norm(off, axis=0), 0.02 / 3 * 0.5 * 9.81)
    about = gq.gravity_tasks(0.5, com, gravity, radius=0.0, samples=1, origin=com)
    np.testing.assert_allclose(about[:, 0], [0, 0, 0.5 * 9.81, 0, 0, 0], atol=1e-15)
    for bad in (dict(mass=0), dict(gravity=[0, 0, 0]), dict(samples=0), dict(radius=-1)):
        with pytest.raises(gq.GraspError, match=next(iter(bad))):
            gq.gravity_tasks(**{**dict(mass=1, com=com, gravity=gravity), **bad})
