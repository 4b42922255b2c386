"""Support, membership, facets and pictures of the wrench space."""

import numpy as np
import pytest

import graspq as gq
from tests.support.random_grasps import grasp


def ring(edges: int | None = 12, torsion=0.01):
    return [
        gq.contact_wrenches(
            gq.Contact(
                [0.05 * np.cos(a), 0.05 * np.sin(a), 0.01],
                [-np.cos(a), -np.sin(a), 0],
                0.6,
                2.0,
                torsion,
            ),
            edges,
        )
        for a in (0, 2.1, 4.0)
    ]


def test_support_adds_up_and_takes_the_largest():
    wrenches = grasp(np.random.default_rng(0), "soft", 6)
    u = np.random.default_rng(1).normal(size=(5, 6))
    each = np.array([np.maximum((u @ w).max(axis=1), 0) for w in wrenches])
    np.testing.assert_allclose(gq.WrenchSpace(wrenches).support(u), each.sum(0))
    np.testing.assert_allclose(gq.WrenchSpace(wrenches, "l1").support(u), each.max(0))
    alone = np.array([(u @ w).max(axis=1) for w in wrenches])
    np.testing.assert_allclose(gq.WrenchSpace(wrenches, unloading=False).support(u), alone.sum(0))


@pytest.mark.parametrize("unloading", [True, False])
@pytest.mark.parametrize("bound", ["linf", "l1"])
def test_membership_agrees_with_the_facets(bound, unloading):
    rng = np.random.default_rng(4)
    wrenches = grasp(rng, "soft", 4)
    space = gq.WrenchSpace(wrenches, bound, unloading)
    normals, offsets = space.facets()
    inside = 0
    middle = sum(w.mean(axis=1) for w in wrenches) if bound == "linf" else wrenches[0].mean(axis=1)
    for _ in range(60):
        w = middle * rng.uniform(0.5, 1.2) + 0.2 * rng.normal(size=6) * np.abs(middle)
        gap = float((normals @ w - offsets).max())
        if abs(gap) > 1e-6:
            assert space.contains(w) == (gap < 0)
            inside += gap < 0
    assert inside > 0
    assert (space.support(normals) <= offsets + 1e-8).all()


@pytest.mark.parametrize("bound", ["linf", "l1"])
def test_slices_lie_on_the_boundary_and_inside_projections(bound):
    space = gq.WrenchSpace(ring(), bound)
    for part, at in (("force", 0), ("moment", 3)):
        cut, shadow = space.slice(part), space.projection(part)
        assert cut.is_watertight
        assert shadow.is_watertight
        assert 0 < cut.volume <= shadow.volume
        for corner in cut.vertices[::25]:
            task = np.zeros(6)
            task[at : at + 3] = corner
            assert gq.task_scaling(ring(), task, bound).value == pytest.approx(1, rel=1e-6)
        # A projection's support is the space's, for normals within the part.
        u = np.zeros((9, 6))
        u[:, at : at + 3] = np.random.default_rng(1).normal(size=(9, 3))
        np.testing.assert_allclose(
            (u[:, at : at + 3] @ shadow.vertices.T).max(axis=1), space.support(u), rtol=1e-9
        )


def test_ellipsoids_draw_a_larger_slice():
    # Drawn from outside, a picture this coarse is 0.2 % too large; the ellipsoids add 8 %.
    exact = gq.WrenchSpace(ring(None)).slice("force", 1e-2)
    assert exact.volume > 1.01 * gq.WrenchSpace(ring()).slice("force", 1e-9).volume


def test_flat_pictures_are_refused():
    fingers = [
        gq.contact_wrenches(gq.Contact([s * 0.03, 0, 0.01], [-s, 0, 0], 0.5)) for s in (1.0, -1.0)
    ]
    with pytest.raises(gq.GraspError, match=r"flat|not strictly inside"):
        gq.WrenchSpace(fingers).slice("moment")
    with pytest.raises(gq.GraspError, match="part"):
        gq.WrenchSpace(fingers).slice("torque")
