"""Polytopes made about round: closed forms, scatter matrices, and what counts as flat."""

from __future__ import annotations

import numpy as np
import pytest

from graspq._engines.whitening import whiten, whiten_polytopes
from graspq.inputs import pack

AXES = np.array([3.0, 0.5, 1e-3, 7.0, 20.0, 1.0])


def cross(lengths):
    """Vertices of the cross-polytope with these half axes."""
    return np.hstack([np.diag(lengths), -np.diag(lengths)])


def test_cross_polytope_becomes_the_unit_one():
    # Its scatter matrix is 2 diag(lengths²), so the map with extents 1 is diag(1 / lengths).
    found = whiten(pack([cross(AXES)], "linf", True).body)
    np.testing.assert_allclose(found.bodies.points, cross(np.ones(6)), rtol=0, atol=1e-14)
    np.testing.assert_allclose(found.turns[0], np.diag(1 / AXES), rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(found.inner, 0.0, atol=1e-15)
    assert not found.flat.any()


def test_rows_have_no_correlation_and_extent_one():
    rng = np.random.default_rng(0)
    grasp = [AXES[:, None] * rng.normal(size=(6, 9)) for _ in range(3)]
    body = pack(grasp, "linf", True).body
    found = whiten_polytopes(body)
    points = found.bodies.points
    scatter = points @ points.T
    np.testing.assert_allclose(scatter, np.diag(np.diag(scatter)), atol=1e-11)
    np.testing.assert_allclose(np.abs(points).max(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(found.turns[0] @ body.points, points, rtol=0, atol=1e-13)
    # A set with the origin has one vertex more in its mean.
    middle = sum(w.sum(axis=1) / 10 for w in grasp)
    np.testing.assert_allclose(found.inner[0], found.turns[0] @ middle, atol=1e-13)


def test_sets_without_the_origin_may_be_moved():
    rng = np.random.default_rng(1)
    grasp = [rng.normal(size=(6, 9)) for _ in range(2)]
    moved = [w + 5.0 * rng.normal(size=(6, 1)) for w in grasp]
    about = []
    for g in (grasp, moved):
        found = whiten_polytopes(pack(g, "linf", False).body)
        # Up to the extents of the rows, which the move changes.
        turn = found.turns[0]
        about.append(turn / np.linalg.norm(turn, axis=1, keepdims=True))
    np.testing.assert_allclose(about[0], about[1], atol=1e-12)


@pytest.mark.parametrize(("thickness", "flat"), [(1e-2, False), (1e-4, False), (1e-7, True)])
@pytest.mark.parametrize("turned", [False, True])
def test_too_flat_to_tell(thickness, flat, turned):
    # The condition number of the scatter matrix is 1 / thickness², and 1e11 / 36 is the limit or
    # above it. Rows of a polytope along the axes are brought to one extent first, which leaves
    # nothing flat.
    points = cross(np.array([1.0, 1.0, 1.0, 1.0, 1.0, thickness]))
    rotation = np.linalg.qr(np.random.default_rng(2).normal(size=(6, 6)))[0]
    body = pack([rotation @ points if turned else points], "linf", True).body
    assert whiten_polytopes(body).flat[0] == (flat and turned)


def test_flat_body_beside_a_round_one():
    line = np.zeros((6, 2))
    line[0] = 1.0, 2.0
    packed = [pack([w], "linf", True).body for w in (line, cross(AXES))]
    bodies = packed[0]._replace(
        points=np.hstack([b.points for b in packed]),
        first_point=np.array([0, 2, 14]),
        first_ellipsoid=np.zeros(3, dtype=np.int64),
        first_set=np.array([0, 1, 2]),
    )
    found = whiten_polytopes(bodies)
    assert found.flat.tolist() == [True, False]
    assert np.isfinite(found.turns).all()
    np.testing.assert_allclose(found.bodies.points[:, 2:], cross(np.ones(6)), atol=1e-14)


@pytest.mark.parametrize("scale", [1e-140, 1.0, 1e140])
def test_scale_does_not_matter(scale):
    grasp = [np.random.default_rng(3).normal(size=(6, 20))]
    want = whiten_polytopes(pack(grasp, "linf", True).body)
    found = whiten_polytopes(pack([scale * w for w in grasp], "linf", True).body)
    np.testing.assert_allclose(found.bodies.points, want.bodies.points, rtol=0, atol=1e-12)
    assert not found.flat[0]
