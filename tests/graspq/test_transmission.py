"""Hands with gears, tendons, couplings and underactuated joints: closed forms and a program."""

from typing import Any

import numpy as np
import pytest

import graspq as gq
from graspq.hand_bound import cones_of
from graspq.transmission import reduce_transmission

UP = np.array([[0, 0, 1.0, 0, 0, 0]]).T
LEAD = 0.002  # a spindle: jaw travel per turn of its motor [m/rad]
TORQUE = 0.3


def pinch(mu=0.5, patch=True):
    """Two opposed pads across x, each with its centre among its taxels."""
    offsets = np.array([[0, 0, 0], [0, 0.004, 0], [0, 0, 0.005], [0, -0.003, -0.004]])
    made = []
    for side in (1.0, -1.0):
        at = np.array([0.03 * side, 0, 0])
        grip = gq.max_normal_force([[LEAD], [0], [0]], [1.0, 0, 0], [TORQUE])
        made.append(gq.Contact(at, [-side, 0, 0], mu, grip, 0.0, at + offsets if patch else None))
    # The jaws close along -x and +x.
    jacobians = [np.zeros((3, 2)), np.zeros((3, 2))]
    jacobians[0][0, 0], jacobians[1][0, 1] = -1.0, 1.0
    return made, jacobians


@pytest.mark.parametrize("arms", [[1 / LEAD, 0.0], [0.0, 1 / LEAD], [0.5 / LEAD, 0.5 / LEAD]])
@pytest.mark.parametrize("patch", [False, True])
def test_one_motor_on_two_jaws_is_the_bound_on_the_sum(arms, patch):
    made, jacobians = pinch(patch=patch)
    hand = gq.HandBound(made, jacobians, [TORQUE], transmission=[arms], couplings=[[1.0, -1.0]])
    tasks = gq.gravity_tasks(0.4, np.zeros(3), [0, 0, -9.81], radius=0.003) if patch else UP
    sets = [gq.contact_wrenches(c, 12, "hf" if patch else "none") for c in made]
    sum_bound = gq.task_scaling(sets, tasks, "l1").value
    assert sum_bound > 0
    assert gq.hand_task_scaling(hand, tasks).value == pytest.approx(sum_bound, rel=1e-12)
    if not patch:
        # Each jaw presses with half of the spindle's force.
        assert sum_bound == pytest.approx(0.5 * TORQUE / LEAD, rel=1e-12)


def test_a_differential_presses_with_both_jaws_alike():
    # Without the coupling the motor's torque reaches each jaw whole, and both must take it.
    made, jacobians = pinch(patch=False)
    hand = gq.HandBound(made, jacobians, [TORQUE], transmission=[[1 / LEAD, 1 / LEAD]])
    s = gq.hand_task_scaling(hand, UP)
    assert s.value == pytest.approx(2 * 0.5 * TORQUE / LEAD, rel=1e-12)
    assert s.motor_torque == pytest.approx([TORQUE])
    # A pull that only one jaw could bear is nothing it can exert.
    assert gq.hand_task_scaling(hand, [-1.0, 0, 0, 0, 0, 0]).value == 0.0


def test_a_held_spindle_squeezes_with_all_its_torque():
    made, jacobians = pinch(patch=False)
    for share in (1.0, 0.98):
        hand = gq.HandBound(
            made, jacobians, [TORQUE], [share * TORQUE], 0.05, [[1 / LEAD, 0]], [[1.0, -1.0]]
        )
        s = gq.hand_task_scaling(hand, UP)
        assert s.value == pytest.approx(1.05 * share * 0.5 * TORQUE / LEAD, rel=1e-12)
        assert s.least == 0.0
    # One jaw alone cannot give way: what the spindle presses with must be balanced.
    alone = gq.HandBound(
        made[:1], jacobians[:1], [TORQUE], [TORQUE], 0.0, [[1 / LEAD, 0]], [[1.0, -1.0]]
    )
    pushed = gq.hand_task_scaling(alone, [-1.0, 0, 0, 0, 0, 0])
    assert pushed.value == pytest.approx(TORQUE / LEAD, rel=1e-12)
    assert pushed.least == pytest.approx(TORQUE / LEAD, rel=1e-12)
    assert gq.hand_task_scaling(alone, UP).value == -np.inf


def hand_of(rng, joints, count=3):
    """Contacts on a ball and Jacobians in joint coordinates."""
    made, jacobians = [], []
    for _ in range(count):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        soft = float(rng.choice([0.0, 0.01]))
        made.append(gq.Contact(-0.04 * n + 0.005 * rng.normal(size=3), n, 0.7, 2.0, soft))
        jacobian = 0.1 * rng.normal(size=(6, joints))
        jacobian[3:] *= 10
        jacobians.append(jacobian)
    return made, jacobians


def same(one, other):
    assert one.value == pytest.approx(other.value, rel=1e-12)
    assert one.least == pytest.approx(other.least, rel=1e-9, abs=1e-12)
    if np.isfinite(other.value) and other.value > 0:
        np.testing.assert_allclose(one.motor_torque, other.motor_torque, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("held", [False, True])
def test_independent_motors_give_the_bound_in_motor_coordinates(held):
    for seed in range(12):
        rng = np.random.default_rng([seed, 31])
        made, jacobians = hand_of(rng, 7)
        limit = rng.uniform(0.5, 2.0, 7)
        torque = sum(j[:3].T @ c.normal for c, j in zip(made, jacobians, strict=True))
        limit = np.maximum(limit, np.abs(torque)) if held else limit
        given = torque if held else None
        tasks = gq.gravity_tasks(0.3, np.zeros(3), [0, 0, -9.81], samples=4)
        plain = gq.hand_task_scaling(gq.HandBound(made, jacobians, limit, given), tasks)
        same(
            gq.hand_task_scaling(
                gq.HandBound(made, jacobians, limit, given, transmission=np.eye(7)), tasks
            ),
            plain,
        )
        # Any gearing of all motors over all joints: J_q = J_m A.
        arms = rng.normal(size=(7, 7)) + 3 * np.eye(7)
        geared = [j @ arms for j in jacobians]
        same(
            gq.hand_task_scaling(
                gq.HandBound(made, geared, limit, given, transmission=arms), tasks
            ),
            plain,
        )


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("way", ["one joint", "both joints", "coupling twice"])
def test_a_coupled_spread_both_ways(held, way):
    # Eight joints, of which the first and the last turn against each other by one motor.
    arms = np.zeros((7, 8))
    arms[np.arange(7), np.arange(7)] = 1.0
    if way == "both joints":
        arms[0, 0], arms[0, 7] = 0.5, -0.5
    coupling = np.array([[1.0, 0, 0, 0, 0, 0, 0, 1.0]])
    coupling = np.vstack([coupling, -2 * coupling]) if way == "coupling twice" else coupling
    select = np.vstack([np.eye(7), -np.eye(7)[:1]])
    for seed in range(12):
        rng = np.random.default_rng([seed, 32])
        made, jacobians = hand_of(rng, 8)
        in_motors = [j @ select for j in jacobians]
        torque = sum(j[:3].T @ c.normal for c, j in zip(made, in_motors, strict=True))
        limit = np.maximum(rng.uniform(0.5, 2.0, 7), np.abs(torque) if held else 0.0)
        given = torque if held else None
        tasks = gq.gravity_tasks(0.3, np.zeros(3), [0, 0, -9.81], samples=4)
        joints = gq.HandBound(made, jacobians, limit, given, 0.05, arms, coupling)
        assert joints.preloads.shape == (7, 0)
        assert joints.passive_jacobians[0].shape == (1, 3, 0)
        same(
            gq.hand_task_scaling(joints, tasks),
            gq.hand_task_scaling(gq.HandBound(made, in_motors, limit, given), tasks),
        )


def tendon_finger():
    """A straight finger along x that one tendon bends about z at both joints, pressing along y."""
    length, near, far = 0.05, 0.02, 0.03
    arms = np.array([0.012, 0.004])
    made = [
        gq.Contact([near, 0, 0], [0, 1.0, 0], 0.0),
        gq.Contact([length + far, 0, 0], [0, 1.0, 0], 0.0),
    ]
    jacobians = [np.zeros((3, 2)), np.zeros((3, 2))]
    jacobians[0][1], jacobians[1][1] = [near, 0], [length + far, far]
    # Joint torques: a1 τ = near f1 + (length + far) f2, a2 τ = far f2.
    outer = arms[1] / far
    inner = (arms[0] - (length + far) * outer) / near
    return made, jacobians, arms, np.array([inner, outer])


def test_an_underactuated_finger_presses_in_a_fixed_ratio():
    made, jacobians, arms, per_torque = tendon_finger()
    assert (per_torque > 0).all()
    hand = gq.HandBound(made, jacobians, [40.0], transmission=[arms])
    wrench = sum(
        f * np.concatenate([c.normal, np.cross(c.position, c.normal)])
        for f, c in zip(per_torque, made, strict=True)
    )
    s = gq.hand_task_scaling(hand, wrench)
    assert s.value == pytest.approx(40.0, rel=1e-12)
    assert s.motor_torque == pytest.approx([40.0], rel=1e-12)
    pressed = [p[0, 1] for p in s.point_forces]
    np.testing.assert_allclose(pressed, 40.0 * per_torque, rtol=1e-10)
    # Any other ratio moves the finger until the ratio is this one.
    assert gq.hand_task_scaling(hand, [0, 1.0, 0, 0, 0, 0.03]).value == 0.0
    held = gq.HandBound(made, jacobians, [40.0], [40.0], 0.0, [arms])
    s = gq.hand_task_scaling(held, wrench)
    assert (s.value, s.least) == pytest.approx((40.0, 40.0), rel=1e-12)


def test_least_effort_forces_obey_the_transmission():
    made, jacobians, arms, per_torque = tendon_finger()
    hand = gq.HandBound(made, jacobians, [40.0], transmission=[arms])
    wrench = sum(
        5.0 * f * np.concatenate([c.normal, np.cross(c.position, c.normal)])
        for f, c in zip(per_torque, made, strict=True)
    )
    f = gq.contact_forces(hand, wrench)
    np.testing.assert_allclose([p[0, 1] for p in f.point_forces], 5.0 * per_torque, rtol=1e-5)
    assert f.motor_torque == pytest.approx([5.0], rel=1e-5)
    with pytest.raises(gq.GraspError, match="motor torques"):
        gq.contact_forces(hand, [0, 1.0, 0, 0, 0, 0.03])


@pytest.mark.parametrize("ratio", [0.25, 3.7, 150.0])
def test_a_gear_scales_the_bound(ratio):
    made, jacobians = pinch()
    tasks = gq.gravity_tasks(0.4, np.zeros(3), [0, 0, -9.81], radius=0.003)
    plain = gq.hand_task_scaling(
        gq.HandBound(made, jacobians, [TORQUE, TORQUE], transmission=np.eye(2)), tasks
    )
    geared = gq.hand_task_scaling(
        gq.HandBound(made, jacobians, [TORQUE, TORQUE], transmission=ratio * np.eye(2)), tasks
    )
    assert geared.value == pytest.approx(ratio * plain.value, rel=1e-12)


def test_motors_on_one_joint_add_up():
    contact = gq.Contact([0, 0, 0], [0, 0, 1.0], 0.0)
    jacobian = np.array([[0], [0], [0.1]])
    hand = gq.HandBound([contact], [jacobian], [2.0, 0.5], transmission=[[1.0], [3.0]])
    assert hand.preloads.shape == (2, 1)
    s = gq.hand_task_scaling(hand, UP)
    assert s.value == pytest.approx((2.0 + 3 * 0.5) / 0.1, rel=1e-12)
    np.testing.assert_allclose(s.motor_torque, [2.0, 0.5], rtol=1e-9)
    f = gq.contact_forces(hand, 34.9 * UP[:, 0])
    assert f.motor_torque is not None
    assert f.motor_torque @ [1.0, 3.0] == pytest.approx(3.49, rel=1e-4)
    assert (np.abs(f.motor_torque) <= [2.0 + 1e-6, 0.5 + 1e-6]).all()
    # Held: the first goes on pushing, against the second where nothing else resists.
    held = gq.HandBound([contact], [jacobian], [2.0, 1.0], [2.0, 0.1], 0.0, [[1.0], [3.0]])
    s = gq.hand_task_scaling(held, UP)
    assert s.value == pytest.approx((2.0 + 3.0) / 0.1, rel=1e-12)
    assert s.least == 0.0
    # Two motors that a coupling ties, in motor coordinates.
    tied = gq.HandBound(
        [contact], [np.array([[0, 0], [0, 0], [0.1, 0]])], [2.0, 0.5], couplings=[[1.0, -1.0]]
    )
    assert gq.hand_task_scaling(tied, UP).value == pytest.approx(25.0, rel=1e-12)


def test_joints_that_couplings_lock_carry_everything():
    made, jacobians = pinch()
    locked = gq.HandBound(
        made, jacobians, [TORQUE], None, 0.05, [[1.0, 1.0]], [[1.0, -1.0], [1.0, 1.0], [2.0, 0.0]]
    )
    s = gq.hand_task_scaling(locked, UP)
    assert s.value == np.inf
    assert "structure" in s.reason


def test_the_parts_of_a_transmission():
    for seed in range(30):
        rng = np.random.default_rng([seed, 33])
        motors, joints = int(rng.integers(1, 6)), int(rng.integers(1, 7))
        arms = rng.normal(size=(motors, joints)) * 10.0 ** rng.integers(-3, 3, (motors, 1))
        ties = rng.normal(size=(int(rng.integers(0, 3)), joints))
        if len(ties) and rng.integers(2):
            ties = np.vstack([ties, ties.sum(0)])
        parts = reduce_transmission(arms, ties)
        rank = np.linalg.matrix_rank(ties) if len(ties) else 0
        driven = min(motors, joints - rank)
        assert parts.passive.shape == (joints, joints - rank - driven)
        assert parts.preloads.shape == (motors, motors - driven)
        scale = np.abs(arms).max(axis=1, keepdims=True)
        np.testing.assert_allclose(ties @ np.hstack([parts.driven, parts.passive]), 0, atol=1e-9)
        np.testing.assert_allclose(arms / scale @ parts.passive, 0, atol=1e-12)
        for speed in np.eye(joints):
            free = speed - np.linalg.pinv(ties) @ ties @ speed if len(ties) else speed
            again = parts.driven @ arms @ free
            np.testing.assert_allclose(arms / scale @ again, arms / scale @ free, atol=1e-9)


def by_program(hand, jacobians, arms, ties, task):
    """q by HiGHS with motor torques and coupling forces as variables of their own."""
    from scipy.optimize import linprog

    bare = gq.HandBound(hand.contacts, jacobians, np.ones(arms.shape[1]))
    cones, _ = cones_of(bare, np.zeros(3), 1.0)
    angle = 2 * np.pi * np.arange(8) / 8
    ring = np.stack([np.ones(8), np.cos(angle), np.sin(angle), 0 * angle])
    ring = np.column_stack([ring, [1, 0, 0, 1], [1, 0, 0, -1]])
    columns = np.concatenate([c @ ring for c in cones], axis=1)
    k, n, e = len(arms), arms.shape[1], len(ties)
    rows = np.zeros((6 + n, columns.shape[1] + 1 + k + e))
    rows[:, : columns.shape[1]] = columns
    rows[:6, columns.shape[1]] = -task
    rows[6:, columns.shape[1] + 1 :] = -np.hstack([arms.T, ties.T])
    cost = np.zeros(rows.shape[1])
    cost[columns.shape[1]] = -1.0
    bounds = [(0, None)] * (columns.shape[1] + 1)
    bounds += list(zip(hand.lower, hand.upper, strict=True)) + [(None, None)] * e
    r = linprog(
        cost, A_eq=rows, b_eq=np.zeros(len(rows)), bounds=bounds, method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )  # fmt: skip
    return {2: -np.inf, 3: np.inf}[r.status] if r.status else -r.fun


@pytest.mark.parametrize("held", [False, True])
def test_equals_a_program_with_every_unknown_of_its_own(held):
    seen = {"positive": 0, "passive": 0, "preload": 0, "inf": 0}
    for seed in range(60):
        rng = np.random.default_rng([seed, 34])
        motors, joints = int(rng.integers(1, 6)), int(rng.integers(1, 7))
        ties = rng.normal(size=(int(rng.integers(0, 3)), joints))
        arms = rng.normal(size=(motors, joints)) * (rng.uniform(size=(motors, joints)) < 0.7)
        made, jacobians = hand_of(rng, joints, int(rng.integers(2, 5)))
        limit = rng.uniform(0.3, 2.0, motors)
        torque = rng.uniform(-1, 1, motors) * limit if held else None
        hand = gq.HandBound(made, jacobians, limit, torque, 0.05, arms, ties)
        push = [c.normal + 0.3 * rng.normal(size=3) for c in made]
        task = np.sum(
            [np.concatenate([f, np.cross(c.position, f)]) for c, f in zip(made, push, strict=True)],
            axis=0,
        )
        s = gq.hand_task_scaling(hand, task, 8)
        value = by_program(hand, jacobians, arms, ties, task)
        if s.value != value:
            assert s.value == pytest.approx(value, rel=1e-8, abs=1e-8)
        seen["inf"] += s.value == np.inf
        if 0 < s.value < np.inf:
            seen["positive"] += 1
            seen["passive"] += hand.passive_jacobians[0].shape[2] > 0
            seen["preload"] += hand.preloads.shape[1] > 0
            assert (s.motor_torque <= hand.upper + 1e-8).all()
            assert (s.motor_torque >= hand.lower - 1e-8).all()
            exact = gq.hand_task_scaling(hand, task, None)
            assert exact.value >= s.value * (1 - 1e-9)
    assert seen["positive"] > 15
    assert min(seen["passive"], seen["preload"], seen["inf"]) > 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            dict(transmission=np.ones((2, 2))),
            r"transmission: expected shape \(1, n\), got \(2, 2\)",
        ),
        (dict(transmission=[1.0, 2.0]), "one row per motor"),
        (dict(transmission=np.zeros((1, 0))), "transmission: got shape"),
        (dict(transmission=[[np.nan, 1.0]]), "transmission: every entry must be finite"),
        (dict(couplings=[[1.0, 1.0, 1.0]]), "couplings: .*one column per joint"),
        (dict(transmission=None, couplings=[[1.0, 1.0]]), "couplings: .*column per motor"),
        (dict(jacobians=[np.ones((3, 1))]), r"jacobians\[0\]: .*one column per joint"),
    ],
)
def test_bad_transmissions_are_named(change, message):
    good: dict[str, Any] = dict(
        contacts=[gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5)],
        jacobians=[np.ones((3, 2))],
        torque_limit=[1.0],
        transmission=[[1.0, 1.0]],
    )
    gq.HandBound(**good)
    with pytest.raises(gq.GraspError, match=message):
        gq.HandBound(**{**good, **change})
