"""The slip margin in closed form, against the task scaling, and bad input."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import graspq as gq
from tests.support import soft_pinch
from tests.support.soft_pinch import FRICTION, LIMIT, RADIUS

FREE = FRICTION * LIMIT  # friction of one finger at its limit [N]


def up(weight):
    return np.array([0, 0, weight, 0, 0, 0.0])


@pytest.mark.parametrize("weight", [0.1, 4.0, 2 * FREE - 0.01, 2 * FREE + 0.01, 30.0])
def test_two_fingers_share_the_weight(weight):
    for arm in (0.0, soft_pinch.ARM):
        margin = gq.slip_margin(soft_pinch.hand(arm), up(weight))
        assert margin == pytest.approx(FREE - weight / 2, abs=1e-7)


def test_a_moment_takes_friction_at_its_arm():
    moment = np.array([0, 0, 0, 0.01, 0, 0.0])
    expected = FREE - 0.005 / soft_pinch.ARM
    assert gq.slip_margin(soft_pinch.hand(), moment) == pytest.approx(expected)
    assert gq.slip_margin(soft_pinch.hand(arm=0.0), moment) == -math.inf  # hard fingers have none


def test_the_hardest_task_decides():
    tasks = np.column_stack([up(1.0), up(6.0), up(3.0)])
    assert gq.slip_margin(soft_pinch.hand(), tasks) == pytest.approx(FREE - 3.0)
    assert gq.slip_margin(soft_pinch.hand(), np.column_stack([up(14.0), up(1.0)])) == pytest.approx(
        FREE - 7.0
    )


def test_what_fingers_cannot_push_no_friction_mends():
    one = gq.HandBound([gq.Contact([0, 0, 0], [1, 0, 0], 0.5)], [np.eye(6)[:, :1]], [1.0])
    assert gq.slip_margin(one, [-1.0, 0, 0, 0, 0, 0]) == -math.inf
    assert gq.slip_margin(one, [0.5, 0, 0, 0, 0, 0]) == pytest.approx(0.25)


def test_motors_that_feel_nothing_limit_nothing():
    assert gq.slip_margin(soft_pinch.hand(driven=False), up(1.0)) == math.inf


def test_a_finger_beside_the_others_that_cannot_press_leaves_nothing():
    made = [*soft_pinch.contacts(), gq.Contact([0, RADIUS, 0], [0, -1, 0], FRICTION, LIMIT)]
    hand = gq.HandBound(made, [*soft_pinch.jacobians(), np.zeros((6, 2))], [LIMIT] * 2)
    # It can: the others' friction along y holds against it.
    assert gq.slip_margin(hand, up(2.0)) > 0.0
    without = [gq.Contact(c.position, c.normal, 0.0, LIMIT) for c in made]
    hand = gq.HandBound(without, [*soft_pinch.jacobians(), np.zeros((6, 2))], [LIMIT] * 2)
    assert gq.slip_margin(hand, [0.5, 0, 0, 0, 0, 0]) == 0.0


def random_hand(seed, patch):
    rng = np.random.default_rng(seed)
    places = np.array([[0.03, 0, 0], [-0.02, 0.02, 0.005], [-0.02, -0.02, -0.005]])
    made = []
    for place in places + 0.004 * rng.normal(size=(3, 3)):
        normal = -place / np.linalg.norm(place)
        spots = place + 0.006 * rng.normal(size=(4, 3)) if patch else None
        made.append(gq.Contact(place, normal, 0.6, 5.0, 0.0 if patch else 0.02, spots))
    return gq.HandBound(made, list(0.05 * rng.normal(size=(3, 6, 5))), rng.uniform(0.1, 0.4, 5))


@pytest.mark.parametrize("patch", [False, True])
def test_it_is_above_zero_where_the_task_can_be_scaled(patch):
    tasks = gq.gravity_tasks(0.3, np.zeros(3), [0, 0, -9.81], 0.003, 5)
    signs = set()
    for seed in range(8):
        hand = random_hand(seed, patch)
        q = gq.hand_task_scaling(hand, tasks).value
        margin = gq.slip_margin(hand, tasks)
        assert (margin >= 0.0) == (q >= 1.0)
        signs.add(margin >= 0.0)
        if 0 < q < math.inf:
            # Scaled to its limit, the task takes all friction of some contact.
            assert gq.slip_margin(hand, 0.999 * q * tasks) >= 0.0
            assert gq.slip_margin(hand, 1.001 * q * tasks) < 0.0
    assert signs == {True, False}


def test_axes_order_and_units_do_not_matter():
    rotation = Rotation.from_rotvec([0.3, -1.0, 0.7]).as_matrix()
    both = np.kron(np.eye(2), rotation)
    tasks = gq.gravity_tasks(0.3, np.zeros(3), [0, 0, -9.81], 0.003, 4)
    hand = random_hand(3, False)
    made = [
        gq.Contact(rotation @ c.position, rotation @ c.normal, 0.6, 5.0, 0.02)
        for c in hand.contacts
    ]
    moved = [
        both @ np.vstack([j[0], s]) for j, s in zip(hand.jacobians, hand.spins, strict=True)
        if s is not None
    ]  # fmt: skip
    order = [2, 0, 1]
    other = gq.HandBound([made[i] for i in order], [moved[i] for i in order], hand.torque_limit)
    values = [gq.slip_margin(h, t, 60) for h, t in ((hand, tasks), (other, both @ tasks))]
    assert values[1] == pytest.approx(values[0], rel=1e-2)
    # All forces ten times.
    strong = gq.HandBound(
        hand.contacts,
        [
            np.vstack([j[0], s])
            for j, s in zip(hand.jacobians, hand.spins, strict=True)
            if s is not None
        ],
        10 * hand.torque_limit,
    )
    assert gq.slip_margin(strong, 10 * tasks) == pytest.approx(10 * gq.slip_margin(hand, tasks))


def test_a_differential_pushes_with_equal_forces():
    """Its passive motion bears no torque: f₁ = f₂ = τ̄ per unit arm, so that μ τ̄ is free."""
    hand = gq.HandBound(
        soft_pinch.contacts(), soft_pinch.jacobians(), [LIMIT], transmission=[[1.0, 1.0]]
    )
    assert gq.slip_margin(hand, up(2.0)) == pytest.approx(FREE - 1.0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gq.slip_margin(None, up(1.0)), "hand: expected a HandBound"),  # type: ignore[arg-type]
        (lambda: gq.slip_margin(soft_pinch.hand(), up(1.0), 2), "edges: expected"),
        (lambda: gq.slip_margin(soft_pinch.hand(), np.zeros(6)), "tasks: column 0 is zero"),
        (lambda: gq.slip_margin(soft_pinch.hand(), [1.0, 2.0]), "tasks"),
        (lambda: gq.slip_margin(soft_pinch.hand(), up(np.nan)), "must be finite"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(gq.GraspError, match=words):
        call()
