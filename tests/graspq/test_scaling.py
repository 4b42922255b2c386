"""q* against closed forms and its own definition."""

import numpy as np
import pytest

import graspq as gq


def antipodal(mu=0.5, g=2.0, torsion=0.0):
    return [
        gq.contact_wrenches(gq.Contact([s * 0.03, 0, 0], [-s, 0, 0], mu, g, torsion))
        for s in (1.0, -1.0)
    ]


def test_two_fingers_hold_twice_the_friction_force():
    grasp = antipodal()
    lift = np.array([0, 0, 1.0, 0, 0, 0])
    assert gq.task_scaling(grasp, lift).value == pytest.approx(2 * 0.5 * 2.0, rel=1e-9)
    assert gq.task_scaling(grasp, lift, "l1").value == pytest.approx(0.5 * 2.0, rel=1e-9)
    assert gq.task_scaling(grasp, lift, unloading=False).value == pytest.approx(2.0, rel=1e-9)


def test_the_axis_through_two_hard_fingers_cannot_be_twisted():
    twist = np.array([0, 0, 0, 1.0, 0, 0])
    none = gq.task_scaling(antipodal(), twist)
    assert none.value == 0.0
    assert "outside" in none.reason
    soft = gq.task_scaling(antipodal(torsion=0.01), twist)
    assert soft.value == pytest.approx(0.02, rel=1e-9)
    assert soft.reason == ""


def test_contact_forces_reproduce_the_scaled_critical_task():
    tasks = gq.gravity_tasks(0.1, [0.005, 0, 0], [0, 0, -9.81])
    s = gq.task_scaling(antipodal(torsion=0.05), tasks)
    assert s.lower <= s.value <= s.upper
    np.testing.assert_allclose(s.forces.sum(0), s.value * tasks[:, s.critical_task], atol=1e-9)
    alone = [gq.task_scaling(antipodal(torsion=0.05), t).value for t in tasks.T]
    assert s.value == pytest.approx(min(alone), rel=1e-9)
    assert int(np.argmin(alone)) == s.critical_task


def test_without_unloading_an_unbalanced_push_is_infeasible():
    push = gq.contact_wrenches(gq.Contact([0, 0, 0], [1, 0, 0], 0.1))
    s = gq.task_scaling([push], [0, 0, 1.0, 0, 0, 0], unloading=False)
    assert s.value == -np.inf
    assert s.reason
    along = gq.task_scaling([push], [2.0, 0, 0, 0, 0, 0], unloading=False)
    assert along.value == pytest.approx(0.5, rel=1e-9)


def test_metrics_of_a_cube_of_contacts():
    # Six frictionless pushes through the centre span only forces: flat, not force closure.
    faces = [
        gq.contact_wrenches(gq.Contact(-d, d, 0.0)) for d in np.vstack([np.eye(3), -np.eye(3)])
    ]
    assert gq.volume(faces, "l1") == 0.0
    assert gq.epsilon(faces, "l1") == 0.0
    assert not gq.is_force_closure(faces)


def test_a_cross_of_wrenches_has_known_metrics():
    grasp = [np.column_stack([e, -e]) for e in np.eye(6)]
    assert gq.epsilon(grasp, "l1") == pytest.approx(1 / np.sqrt(6), rel=1e-12)
    assert gq.volume(grasp, "l1") == pytest.approx(2**6 / 720, rel=1e-9)
    assert gq.epsilon(grasp, unloading=False) == pytest.approx(1.0, rel=1e-12)
    assert gq.volume(grasp, unloading=False) == pytest.approx(64.0, rel=1e-6)
    assert gq.is_force_closure(grasp)


@pytest.mark.parametrize(
    ("wrenches", "tasks", "more", "named"),
    [
        ([], np.ones(6), {}, "empty"),
        (np.ones((6, 4)), np.ones(6), {}, "wrap"),
        ([np.ones((5, 4))], np.ones(6), {}, r"wrenches\[0\]"),
        ([np.ones((6, 0))], np.ones(6), {}, "no column"),
        ([np.full((6, 2), np.nan)], np.ones(6), {}, "finite"),
        ([np.ones((6, 4))], np.zeros(6), {}, "zero"),
        ([np.ones((6, 4))], np.ones(5), {}, "tasks"),
        ([np.ones((6, 4))], np.ones(6), {"bound": "l2"}, "bound"),
        ([np.ones((6, 4))], np.ones(6), {"engine": "qp"}, "engine"),
    ],
)
def test_bad_input_is_named(wrenches, tasks, more, named):
    with pytest.raises(gq.GraspError, match=named):
        gq.task_scaling(wrenches, tasks, **more)
