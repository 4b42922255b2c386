"""Stiffness, PCR and PGR of two soft fingers in closed form, and what they do not depend on."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import graspq as gq
from graspq.robustness import friction_rows
from tests.support import soft_pinch
from tests.support.soft_pinch import ARM, FRICTION, LIMIT, PAD, RADIUS, SERVO, TORSION

EDGES = 12
NOTHING = np.zeros(6)


def test_rigid_fingers_leave_the_stiffness_of_the_pads():
    for length in (RADIUS, 0.1):
        found = gq.grasp_stiffness(soft_pinch.grasp(length, driven=False))
        about = np.array([2 * TORSION, 2 * PAD * RADIUS**2, 2 * PAD * RADIUS**2]) / length**2
        assert found == pytest.approx(np.diag([2 * PAD, 2 * PAD, 2 * PAD, *about]), abs=1e-6)


def test_a_servo_yields_in_series_with_its_pad():
    found = gq.grasp_stiffness(soft_pinch.grasp())
    assert found[0, 0] == pytest.approx(2 / (1 / PAD + 1 / SERVO))
    assert found[1, 1] == pytest.approx(2 * PAD)


def test_the_least_stiffness_is_that_of_the_weakest_motion():
    assert gq.least_stiffness(soft_pinch.grasp()) == pytest.approx(2 * TORSION / RADIUS**2)
    assert gq.least_stiffness(soft_pinch.grasp(arm=0.0)) == 0.0  # hard fingers: about their line


def test_the_formula_of_the_literature():
    """(C_s + J C_q Jᵀ)⁻¹ as it is written, against the form that passive joints need."""
    rng = np.random.default_rng(0)
    made = [gq.Contact(p, -p / np.linalg.norm(p), 0.5) for p in rng.normal(size=(3, 3))]
    jacobians = rng.normal(size=(3, 6, 4))
    found = gq.CompliantGrasp(
        gq.HandBound(made, list(jacobians), np.ones(4)), [1, 2, 3], [4, 5, 6, 7], 1.0
    )
    series = np.diag(1 / found.pads) + found.jacobian @ np.diag(1 / found.servos) @ found.jacobian.T
    assert gq.contact_stiffness(found) == pytest.approx(np.linalg.inv(series), rel=1e-9)


def test_a_passive_joint_is_not_loaded():
    """One motor on two jaws by a differential: their sum is stiff, their difference free."""
    hand = gq.HandBound(
        soft_pinch.contacts(), soft_pinch.jacobians(), [LIMIT], transmission=[[1.0, 1.0]]
    )
    found = gq.CompliantGrasp(hand, [PAD] * 2, [SERVO], RADIUS, [TORSION] * 2)
    motors = len(hand.torque_limit)
    stiffness = gq.contact_stiffness(found)
    assert found.jacobian.shape[1] == motors + 1
    assert found.jacobian[:, motors] @ stiffness == pytest.approx(0.0, abs=1e-6)
    assert gq.grasp_stiffness(found)[0, 0] == pytest.approx(0.0, abs=1e-6)  # it slides along x


def closed_robustness(length):
    """Squeezed by s: cone facets are at a s, motor limits at LIMIT - s."""
    slope = FRICTION * np.cos(np.pi / EDGES)
    a = slope / np.sqrt(slope**2 + 1 + np.cos(np.pi / EDGES) ** 2)
    distance = a * LIMIT / (1 + a)
    # Each contact takes half of a force, and moments over their arms.
    return distance / (max(1.0, length / RADIUS, length / ARM) / np.sqrt(2))


@pytest.mark.parametrize("length", [0.5 * ARM, RADIUS, 0.2])
def test_a_squeeze_is_robust_in_closed_form(length):
    found = soft_pinch.grasp(length)
    assert gq.contact_robustness(found, NOTHING) == pytest.approx(closed_robustness(length))
    # Neither finger may slip or let go.
    assert gq.grasp_robustness(found, NOTHING) == pytest.approx(closed_robustness(length))


def test_no_controllable_squeeze_no_robustness():
    assert gq.contact_robustness(soft_pinch.grasp(driven=False), NOTHING) == 0.0


def test_a_load_takes_its_part():
    found = soft_pinch.grasp()
    loads = [np.array([0, 0, f, 0, 0, 0.0]) for f in (0.0, 2.0, 4.0, 2 * FRICTION * LIMIT)]
    values = [gq.contact_robustness(found, load) for load in loads]
    assert values == sorted(values, reverse=True)
    assert values[0] > values[1] > values[2] > 0.0 == values[3]


def test_a_load_along_the_squeeze_in_closed_form():
    """Fingers press with s ± w/2: cones at a (s - w/2), limits at LIMIT - s - w/2."""
    found = soft_pinch.grasp()
    for w in (1.0, -4.0, 9.0):
        load = np.array([w, 0, 0, 0, 0, 0])
        expected = closed_robustness(RADIUS) * (1 - abs(w) / LIMIT)
        assert gq.contact_robustness(found, load) == pytest.approx(expected)


@pytest.mark.parametrize("length", [RADIUS, 0.2])
def test_a_moment_loads_as_the_forces_at_its_arm(length):
    found = soft_pinch.grasp(length)
    force, moment = np.array([0, 0, 3.0, 0, 0, 0]), np.array([0, 0, 0, 0, 3.0 * RADIUS, 0])
    assert gq.contact_robustness(found, moment) == pytest.approx(
        gq.contact_robustness(found, force)
    )


def third_finger():
    """A finger across the line of the other two that no motor presses."""
    made = [*soft_pinch.contacts(), gq.Contact([0, RADIUS, 0], [0, -1, 0], FRICTION, LIMIT, 0.01)]
    jacobians = [*soft_pinch.jacobians(), np.zeros((6, 2))]
    hand = gq.HandBound(made, jacobians, [LIMIT] * 2)
    return gq.CompliantGrasp(hand, [PAD] * 3, [SERVO] * 2, RADIUS, [TORSION] * 3)


def test_a_finger_that_cannot_press_may_let_go():
    found = third_finger()
    assert gq.contact_robustness(found, NOTHING) == pytest.approx(0.0, abs=1e-9)
    assert gq.grasp_robustness(found, NOTHING) >= closed_robustness(RADIUS) * (1 - 1e-9)


def test_axes_and_order_do_not_matter():
    rotation = Rotation.from_rotvec([0.3, -1.0, 0.7]).as_matrix()
    found = third_finger()
    other = soft_pinch.turned(found, rotation, [2, 0, 1])
    assert gq.least_stiffness(other) == pytest.approx(gq.least_stiffness(found))
    assert gq.grasp_stiffness(other)[:3, :3] == pytest.approx(
        rotation @ gq.grasp_stiffness(found)[:3, :3] @ rotation.T
    )
    # Cones have edges, which turn with the contacts' own axes: alike within what edges lose.
    before, after = (gq.grasp_robustness(g, NOTHING, edges=60) for g in (found, other))
    assert after == pytest.approx(before, rel=2e-3)


def test_forces_and_stiffness_have_their_units():
    """All lengths twice, torques and torsion with them: forces stay, stiffness over a length."""
    both = []
    for size in (1.0, 2.0):
        made = [
            gq.Contact(size * c.position, c.normal, c.friction, LIMIT, size * c.max_torsion)
            for c in soft_pinch.contacts()
        ]
        hand = gq.HandBound(made, soft_pinch.jacobians(), [LIMIT] * 2)
        both.append(
            gq.CompliantGrasp(
                hand, [PAD / size] * 2, [SERVO / size] * 2, size * RADIUS, [size * TORSION] * 2
            )
        )
    small, large = both
    assert gq.least_stiffness(large) == pytest.approx(0.5 * gq.least_stiffness(small))
    assert gq.contact_robustness(large, NOTHING) == pytest.approx(
        gq.contact_robustness(small, NOTHING)
    )


@pytest.mark.parametrize("soft", [False, True])
def test_friction_rows_are_inside_the_cone(soft):
    rows = friction_rows(FRICTION, EDGES, soft)
    rng = np.random.default_rng(0)
    tangential = rng.normal(size=(2000, 3 if soft else 2))
    forces = np.column_stack([np.ones(2000), FRICTION * tangential])
    inside = np.all(forces @ rows.T <= 0, axis=1)
    size = np.linalg.norm(tangential[:, :2], axis=1)
    if soft:
        size += np.abs(tangential[:, 2])
    assert inside.any()
    assert (size[inside] <= 1.0 + 1e-12).all()
    assert inside[size <= 0.9 * np.cos(np.pi / EDGES)].all()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gq.CompliantGrasp(None, [1.0], [1.0], 1.0), "hand: expected a HandBound"),  # type: ignore[arg-type]
        (lambda: gq.CompliantGrasp(soft_pinch.hand(), [1.0], [1.0] * 2, 1.0), "one per contact"),
        (
            lambda: gq.CompliantGrasp(soft_pinch.hand(), [1.0, 0.0], [1.0] * 2, 1.0),
            "above 0, got 0",
        ),
        (lambda: gq.CompliantGrasp(soft_pinch.hand(), [1.0] * 2, [1.0], 1.0), "one per motor"),
        (
            lambda: gq.CompliantGrasp(soft_pinch.hand(), [1.0] * 2, [1.0] * 2, 0.0),
            "length: expected",
        ),
        (
            lambda: gq.CompliantGrasp(soft_pinch.hand(), [1.0] * 2, [1.0] * 2, 1.0, [1.0, 0.0]),
            "contact 1 is soft",
        ),
        (lambda: gq.contact_stiffness(soft_pinch.grasp(), [True]), "kept: expected 8 booleans"),
        (lambda: gq.contact_robustness(soft_pinch.grasp(), [0.0]), "wrench: expected shape"),
        (lambda: gq.contact_robustness(soft_pinch.grasp(), NOTHING, 2), "edges: expected"),
        (lambda: gq.grasp_robustness(soft_pinch.hand(), NOTHING), "expected a CompliantGrasp"),  # type: ignore[arg-type]
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(gq.GraspError, match=words):
        call()


def test_a_patch_is_refused():
    made = [gq.Contact([0, 0, 0], [1, 0, 0], 0.5, patch=[[0, 0, 0]])]
    hand = gq.HandBound(made, [np.zeros((6, 1))], [1.0])
    with pytest.raises(gq.GraspError, match="give patch=None"):
        gq.CompliantGrasp(hand, [1.0], [1.0], 1.0)


def test_too_many_contacts_are_refused():
    made = [gq.Contact([0, 0, 0], [1, 0, 0], 0.5) for _ in range(8)]
    hand = gq.HandBound(made, [np.zeros((6, 1))] * 8, [1.0])
    with pytest.raises(gq.GraspError, match="got 8 contacts"):
        gq.grasp_robustness(gq.CompliantGrasp(hand, [1.0] * 8, [1.0], 1.0), NOTHING)
