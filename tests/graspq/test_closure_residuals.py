"""QP residuals and the span loss against closed forms and their optimality conditions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import graspq as gq
from graspq._engines.nearest_point import nearest_point
from tests.support.field_contacts import field_contacts


def test_the_nearest_point_of_hulls():
    rng = np.random.default_rng(2)
    for trial in range(60):
        points = rng.normal(size=(12, 6)) + rng.choice([0.0, 1.5]) * np.eye(6)[trial % 6]
        found = nearest_point(lambda u, p=points: p[np.argmax(p @ u)], points[0])
        # Nothing lies nearer: every point is on the far side of the plane through the one found.
        assert (points @ found).min() >= found @ found - 1e-13
        within = np.vstack([points.T, np.ones(12)]), np.append(found, 1.0)
        assert lsq_linear(*within, (0, 1), method="bvls", tol=1e-14).cost < 1e-20


def test_one_contact_has_to_press():
    # Force of normal part 1 at the mean: |n| without a load; with loads 0.1 along ± n and across,
    # which friction balances, 0.9, 1.1 and four times 1.
    place, normal = [[0.01, 0.02, 0.03]], [[0, 0, 1.0]]
    assert gq.qp_dfc_residual(place, normal, 0.5) == pytest.approx(1.0)
    assert gq.qp_residual(place, normal, 0.5) == pytest.approx(1.0)
    without = (0.9 + 1.1 + 4 * np.sqrt(1 + 0.1**2)) / 6
    assert gq.qp_residual(place, normal, 0.0) == pytest.approx(without)


def test_a_pair():
    pair = field_contacts()["pair"]
    assert gq.qp_dfc_residual(*pair, 0.0) == pytest.approx(0.0, abs=1e-12)
    # Without friction loads across the pair remain, those along it do not.
    assert gq.qp_residual(*pair, 0.0) == pytest.approx(4 * 0.1 / 6)
    assert gq.qp_residual(*pair, 0.3) == pytest.approx(0.0, abs=1e-12)
    # Little friction: two contacts pressing with 1 each hold 2 μ across.
    assert gq.qp_residual(*pair, 0.02) == pytest.approx(4 * (0.1 - 2 * 0.02) / 6)


def test_nothing_but_torsion_balances_a_twist():
    # Opposite forces on parallel lines 0.02 apart turn the object about z with 0.02; the contacts'
    # normals lie along y, so their torsion is of no use, and friction across turns it back.
    places, normals = [[0.01, 0, 0], [-0.01, 0, 0]], [[0, 1.0, 0], [0, -1.0, 0]]
    assert gq.qp_dfc_residual(places, normals, 0.0) == pytest.approx(0.5 * 0.02, rel=1e-9)
    assert gq.qp_dfc_residual(places, normals, 0.0, 0.05) == pytest.approx(0.5 * 0.02, rel=1e-9)


@pytest.mark.parametrize("name", ["ellipsoid_3", "ellipsoid_4", "one_side"])
def test_order_place_and_side_do_not_matter(name):
    positions, normals = field_contacts()[name]
    for residual in (gq.qp_residual, gq.qp_dfc_residual):
        value = residual(positions, normals, 0.2, 0.01)
        for other in (
            residual(positions[::-1], normals[::-1], 0.2, 0.01),
            residual(positions - 0.4, normals, [0.2] * len(positions), 0.01),
            residual(positions, -normals, 0.2, 0.01),
        ):
            assert other == pytest.approx(value, rel=1e-9, abs=1e-12)


def test_no_vertex_leaves_less():
    # Each contact at one of its wrenches or at rest; the residual is a point of their hull.
    positions, normals = field_contacts()["one_side"]
    best = gq.qp_dfc_residual(positions, normals, 0.2)
    arms = positions - positions.mean(axis=0)
    for used in itertools.product((0.0, 1.0), repeat=3):
        if any(used):
            forces = np.array(used)[:, None] * normals
            wrench = np.concatenate([forces, np.cross(arms, forces)], axis=1).sum(axis=0)
            assert np.linalg.norm(wrench) >= best - 1e-12


def test_span_of_a_pair():
    # All but the moments about the line can be exerted, given large weights: 2 of 12 targets leave
    # 1/2. The map is singular, so the second factor is 1.
    pair = field_contacts()["pair"]
    assert gq.span_loss(*pair, 0.2, largest_weight=1e4) == pytest.approx(2 * (1 / 12 + 0.01))
    assert gq.span_loss(*pair, 0.2, targets="zero") == pytest.approx(2 * 0.01)
    assert gq.span_loss(*pair, 0.2) > 2 * (1 / 12 + 0.01)


def test_span_of_one_frictionless_contact():
    # Four times a quarter of n: the weights' sum over 4 is the force, at least 1 under "zero".
    place, normal = [[0.0, 0, 0.02]], [[0, 0, -1.0]]
    assert gq.span_loss(place, normal, 0.0, targets="zero") == pytest.approx(2 * (0.5 + 0.01))
    assert gq.span_loss(place, normal, 0.0) == pytest.approx(2 * (11 / 24 + 0.01))


@pytest.mark.parametrize("targets", ["axes", "zero"])
def test_span_ignores_order_and_where_the_origin_is(targets):
    positions, normals = field_contacts()["ellipsoid_4"]
    value = gq.span_loss(positions, normals, targets=targets)
    moved = gq.span_loss(positions + 0.1, normals, centre=[0.1] * 3, targets=targets)
    assert moved == pytest.approx(value, rel=1e-9)
    assert gq.span_loss(positions[::-1], normals[::-1], targets=targets) == pytest.approx(value)


def test_bad_input_is_named():
    pair = field_contacts()["pair"]
    for call, words in (
        (lambda: gq.span_loss(*pair, 1.2), "<= 1, got 1.2"),
        (lambda: gq.span_loss(*pair, targets="all"), "targets: expected one of axes, zero"),
        (lambda: gq.span_loss(*pair, centre=[0, 0]), "centre"),
        (lambda: gq.span_loss(*pair, largest_weight=0), "largest_weight"),
        (lambda: gq.qp_residual(*pair, 0.3, -1.0), "torsion"),
        (lambda: gq.qp_residual(np.zeros((0, 3)), np.zeros((0, 3)), 0.3), "no contact"),
        (lambda: gq.qp_dfc_residual([[np.nan, 0, 0]], [[0, 0, 1.0]], 0.3), "finite"),
        (lambda: gq.span_loss([[np.nan, 0, 0]], [[0, 0, 1.0]]), "finite"),
    ):
        with pytest.raises(gq.GraspError, match=words):
            call()
