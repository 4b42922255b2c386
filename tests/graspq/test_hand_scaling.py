"""Contacts that share motors: closed forms, and a linear program by HiGHS."""

import numpy as np
import pytest

import graspq as gq
from graspq.contact import tangent_basis
from graspq.hand_bound import cones_of

UP = np.array([[0, 0, 1.0, 0, 0, 0]]).T


def along(axis, arm):
    """A one-motor Jacobian whose motion at the contact is ``arm`` along ``axis``."""
    return np.outer(axis, [arm])


@pytest.mark.parametrize("edges", [12, None])
def test_one_finger_without_friction_is_equation_six(edges):
    normal, jacobian = np.array([0, 0, 1.0]), np.array([[0, 0], [0, 0], [0.1, 0.04]])
    contact = gq.Contact([0, 0, 0], normal, 0.0)
    limit = [1.5, 0.9]
    s = gq.hand_task_scaling(gq.HandBound([contact], [jacobian], limit), UP, edges)
    g = gq.max_normal_force(jacobian, normal, limit)
    assert s.value == pytest.approx(g, rel=1e-9)
    np.testing.assert_allclose(s.motor_torque, jacobian.T @ normal * g, rtol=1e-8)
    np.testing.assert_allclose(s.point_forces[0], [[0, 0, g]], atol=1e-8 * g)


def two_fingers(torque=None, mu=0.5, limit=1.0, slack=0.0):
    made = [gq.Contact([s * 0.03, 0, 0], [-s, 0, 0], mu) for s in (1.0, -1.0)]
    jacobians = [np.zeros((3, 2)), np.zeros((3, 2))]
    jacobians[0][0, 0], jacobians[1][0, 1] = -0.1, 0.1
    return gq.HandBound(made, jacobians, [limit, limit], torque, slack)


@pytest.mark.parametrize("edges", [12, None])
def test_two_opposed_fingers_hold_what_friction_carries(edges):
    # Each motor presses with τ / 0.1 m; both friction forces point up.
    s = gq.hand_task_scaling(two_fingers(), UP, edges)
    assert s.value == pytest.approx(2 * 0.5 * 1.0 / 0.1, rel=1e-9)
    assert s.lower <= s.value <= s.upper * (1 + 1e-12)


def test_held_motors_that_disagree_have_no_equilibrium():
    agreed = gq.hand_task_scaling(two_fingers([1.0, 1.0]), UP)
    assert agreed.value == pytest.approx(10.0, rel=1e-9)
    apart = two_fingers([1.0, 0.8], limit=0.8)
    s = gq.hand_task_scaling(apart, UP)
    assert s.value == -np.inf
    assert "no equilibrium" in s.reason
    # A motor below its limit gives way: only the first one's torque is fixed.
    yields = gq.hand_task_scaling(two_fingers([1.0, 0.3]), UP)
    assert yields.value == pytest.approx(10.0, rel=1e-9)
    # Slack forgives a small disagreement: both press with 0.9 to 1.1, the rest is friction.
    close = gq.HandBound(apart.contacts, apart.jacobians, [1.0, 0.95], [1.0, 0.95], slack=0.1)
    assert gq.hand_task_scaling(close, UP).value > 0


def test_held_squeeze_with_nothing_opposite():
    contact = gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5)
    hand = gq.HandBound([contact], [along([0, 0, 1.0], 0.1)], [2.0], [2.0], slack=0.0)
    s = gq.hand_task_scaling(hand, UP)
    # The motor pushes up with exactly 20 N: that scale, and no smaller one.
    assert s.value == pytest.approx(20.0, rel=1e-9)
    assert s.least == pytest.approx(20.0, rel=1e-9)
    down = gq.hand_task_scaling(hand, -UP)
    assert down.value == -np.inf


def test_a_motor_at_its_limit_that_no_contact_loads():
    contact = gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5)
    hand = gq.HandBound([contact], [np.outer([0, 0, 1.0], [0.1, 0.0])], [2.0, 1.0], [2.0, 1.0])
    assert "motor 1" in gq.hand_task_scaling(hand, UP).reason


def test_a_coupled_spread_joint_shares_its_torque():
    # Two fingers turned apart by one motor: their side forces oppose through it, ±y by 0.05 m.
    made = [
        gq.Contact([0.02, 0.03, 0], [0, -1.0, 0], 0.0),
        gq.Contact([-0.02, 0.03, 0], [0, -1.0, 0], 0.0),
    ]
    spread = [np.outer([0, 1.0, 0], [0.05]), np.outer([0, -1.0, 0], [0.05])]
    push = np.array([[0, -1.0, 0, 0, 0, 0]]).T
    # Equal pushes cancel in the motor, so it does not limit them.
    both = gq.hand_task_scaling(gq.HandBound(made, spread, [1.0]), push)
    assert both.value == np.inf
    # A twist about z needs more on one side: the difference of the pushes is 1 / 0.05 N.
    twist = np.array([[0, -1.0, 0, 0, 0, -0.01]]).T
    s = gq.hand_task_scaling(gq.HandBound(made, spread, [1.0]), twist)
    assert s.value == pytest.approx(20.0 / 0.5, rel=1e-9)
    assert abs(s.motor_torque[0]) == pytest.approx(1.0, rel=1e-9)


def test_taxels_take_the_moved_jacobian():
    taxels = np.array([[0.01, 0, 0], [-0.02, 0, 0]])
    contact = gq.Contact([0, 0, 0], [0, 0, 1.0], 0.0, patch=taxels)
    # A motor about -y through (-0.1, 0, 0): lever arms 0.11 and 0.08 at the taxels.
    jacobian = np.array([[0, 0, 0.1, 0, -1.0, 0]]).T
    hand = gq.HandBound([contact], [jacobian], [1.0])
    np.testing.assert_allclose(hand.jacobians[0][:, 2, 0], [0.11, 0.08])
    given = gq.HandBound([contact], [hand.jacobians[0]], [1.0])
    for at, arm in zip(taxels, (0.11, 0.08), strict=True):
        task = np.concatenate([[0, 0, 1.0], np.cross(at, [0, 0, 1.0])])
        for h in (hand, given):
            assert gq.hand_task_scaling(h, task).value == pytest.approx(1 / arm, rel=1e-9)


def random_hand(rng):
    count, motors = int(rng.integers(1, 5)), int(rng.integers(1, 8))
    made, jacobians = [], []
    for _ in range(count):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        p = -0.04 * n + 0.01 * rng.normal(size=3)
        kind = rng.integers(3)
        a, b = tangent_basis(n)
        patch = p + 0.01 * (rng.uniform(-1, 1, (6, 1)) * a + rng.uniform(-1, 1, (6, 1)) * b)
        made.append(
            gq.Contact(
                p,
                n,
                float(rng.choice([0.1, 0.6, 1.0])),
                2.0,
                0.01 if kind == 2 else 0.0,
                patch if kind == 1 else None,
            )
        )
        jacobian = 0.1 * rng.normal(size=(6, motors)) * (rng.uniform(size=motors) < 0.7)
        jacobian[3:] *= 10
        jacobians.append(jacobian)
    limit, torque = rng.uniform(0.3, 2, motors), None
    push = [
        (c.normal + 0.3 * c.friction * tangent_basis(c.normal)[0]) * rng.uniform(0.1, 5)
        for c in made
    ]
    wanted = gq.gravity_tasks(0.3, 0.01 * rng.normal(size=3), [0, 0, -9.81], samples=6)
    if rng.integers(2):
        torque = sum(j[:3].T @ f for j, f in zip(jacobians, push, strict=True))
        limit = np.maximum(np.abs(torque) * rng.choice([1.0, 1.5], motors), 1e-3)
    if rng.integers(3):
        wanted = np.sum(
            [np.concatenate([f, np.cross(c.position, f)]) for c, f in zip(made, push, strict=True)],
            axis=0,
        )[:, None]
    slack = float(rng.choice([0.0, 0.05, 0.1]))
    return gq.HandBound(made, jacobians, limit, torque, slack), wanted


def by_lp(hand, wanted, edges):
    from scipy.optimize import linprog

    cones, _ = cones_of(hand, np.zeros(3), 1.0)
    angle = 2 * np.pi * np.arange(edges) / edges
    ring = np.stack([np.ones(edges), np.cos(angle), np.sin(angle), 0 * angle])
    ring = np.column_stack([ring, [1, 0, 0, 1], [1, 0, 0, -1]])
    columns = np.concatenate([c @ ring for c in cones], axis=1)
    ends = {}
    for sign in (-1.0, 1.0):
        ends[sign] = []
        for t in wanted.T:
            cost = np.zeros(columns.shape[1] + 1)
            cost[-1] = sign
            loads = np.column_stack([columns[6:], np.zeros(len(columns) - 6)])
            r = linprog(
                cost,
                A_ub=np.vstack([loads, -loads]),
                b_ub=np.concatenate([hand.upper, -hand.lower]),
                A_eq=np.column_stack([columns[:6], -t / np.linalg.norm(t)]),
                b_eq=np.zeros(6),
                method="highs",
                options={
                    "primal_feasibility_tolerance": 1e-10,
                    "dual_feasibility_tolerance": 1e-10,
                },
            )
            if r.status == 2:
                return -np.inf
            ends[sign].append(np.inf if r.status == 3 else r.x[-1] / np.linalg.norm(t))
    if max(ends[1.0]) > min(ends[-1.0]) * (1 + 1e-9) + 1e-9:
        return -np.inf
    return min(ends[-1.0])


def test_equals_the_linear_program_on_random_hands():
    seen = {"positive": 0, "none": 0}
    for seed in range(90):
        rng = np.random.default_rng([seed, 6])
        hand, wanted = random_hand(rng)
        edges = int(rng.choice([4, 8, 12]))
        s, value = gq.hand_task_scaling(hand, wanted, edges), by_lp(hand, wanted, edges)
        if s.value != value:
            assert s.value == pytest.approx(value, rel=1e-8, abs=1e-8)
        seen["none"] += s.value == -np.inf
        if 0 < s.value < np.inf:
            seen["positive"] += 1
            aim = s.value * wanted[:, s.critical_task]
            np.testing.assert_allclose(s.forces.sum(0), aim, atol=1e-7 * np.abs(aim).max())
            assert (s.motor_torque <= hand.upper + 1e-8).all()
            assert (s.motor_torque >= hand.lower - 1e-8).all()
            assert s.upper <= s.value * (1 + 1e-8)
            for contact, forces in zip(hand.contacts, s.point_forces, strict=True):
                normal = forces @ contact.normal
                side = np.linalg.norm(forces - np.outer(normal, contact.normal), axis=1)
                assert (side <= contact.friction * normal + 1e-8 * (1 + normal)).all()
            exact = gq.hand_task_scaling(hand, wanted, None)
            assert exact.value >= s.value * (1 - 1e-9)
    assert seen["positive"] > 40
    assert seen["none"] > 3


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (dict(contacts=[]), "contacts"),
        (dict(jacobians=[]), "jacobians"),
        (dict(jacobians=[np.zeros((4, 1))]), r"jacobians\[0\]"),
        (dict(torque_limit=[-1.0]), "torque_limit"),
        (dict(motor_torque=[1.0, 2.0]), "motor_torque"),
        (dict(slack=-0.1), "slack"),
    ],
)
def test_bad_hands_are_named(change, named):
    good = dict(
        contacts=[gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5)],
        jacobians=[np.ones((3, 1))],
        torque_limit=[1.0],
    )
    with pytest.raises(gq.GraspError, match=named):
        gq.HandBound(**{**good, **change})


def test_torsion_needs_the_angular_jacobian():
    soft = gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5, 1.0, 0.1)
    with pytest.raises(gq.GraspError, match=r"\(6, k\)"):
        gq.hand_task_scaling(gq.HandBound([soft], [np.ones((3, 1))], [1.0]), UP)
