"""ε and force closure of planar and flat grasps, the reason for 0, and sets of revolution."""

import itertools

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import graspq as gq
from tests.support.random_grasps import contacts

HALF = 0.05
PLANAR = [0, 1, 5]


def pushes(spots):
    """One frictionless force per (x, y, direction) in the xy plane."""
    return [
        gq.contact_wrenches(gq.Contact([x, y, 0], [np.cos(a), np.sin(a), 0], 0.0), 3)
        for x, y, a in spots
    ]


# Two forces of 1 N on each side of a square, 20 mm off its middle: a planar form closure.
SQUARE = [
    (HALF * np.cos(a) - 0.02 * s * np.sin(a), HALF * np.sin(a) + 0.02 * s * np.cos(a), a + np.pi)
    for a in np.pi / 2 * np.arange(4)
    for s in (-1, 1)
]


def by_hull(wrenches, rows):
    """ε from the hull of all sums, with zero, in some of the rows."""
    sets = [np.hstack([np.zeros((6, 1)), w]) for w in wrenches]
    sums = np.array([sum(c) for c in itertools.product(*[list(s.T) for s in sets])])
    return float(-ConvexHull(np.unique(sums.round(14), axis=0)[:, rows]).equations[:, -1].max())


def test_form_closure_in_the_plane_has_its_closed_form():
    # Moments: four forces turn each way with 20 mm, so h(mz) = 0.08; the plane's other facets are
    # further away than that.
    wrenches = pushes(SQUARE)
    for subspace in ("planar", "span"):
        ball = gq.largest_ball(wrenches, subspace=subspace)
        assert ball.value == pytest.approx(by_hull(wrenches, PLANAR), rel=1e-12)
        assert ball.value <= 0.08 * (1 + 1e-12)
        assert ball.value == gq.epsilon(wrenches, subspace=subspace)
        assert (ball.names, ball.dimension, ball.reason) == ("fx, fy, mz", 3, "")
        np.testing.assert_array_equal(ball.axes, np.eye(6)[:, PLANAR])
        assert gq.is_force_closure(wrenches, subspace=subspace)
    ball = gq.largest_ball(wrenches)
    assert (ball.value, ball.dimension) == (0.0, 6)
    assert "span 3 of the 6 dimensions (fx, fy, mz)" in ball.reason
    assert not gq.is_force_closure(wrenches)


def test_a_cross_in_three_dimensions():
    # ± a N along x, ± b N along y, a couple of ± c N m: the box's shortest half side.
    for sides in ([3.0, 2.0, 5.0], [0.5, 2.0, 5.0], [3.0, 2.0, 0.125]):
        wrenches = [
            side * np.column_stack([np.eye(6)[r], -np.eye(6)[r]])
            for r, side in zip(PLANAR, sides, strict=True)
        ]
        for unloading, subspace in itertools.product((True, False), ("span", "planar")):
            value = gq.epsilon(wrenches, unloading=unloading, subspace=subspace)
            assert value == pytest.approx(min(sides), rel=1e-12)
        # The hull of the same is an octahedron.
        octahedron = 1.0 / np.linalg.norm(1.0 / np.array(sides))
        assert gq.epsilon(wrenches, "l1", subspace="span") == pytest.approx(octahedron, rel=1e-12)


def test_the_span_may_lie_askew():
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    wrenches = [turn @ w for w in pushes(SQUARE)]
    ball = gq.largest_ball(wrenches, subspace="span")
    assert ball.value == pytest.approx(by_hull(pushes(SQUARE), PLANAR), rel=1e-11)
    np.testing.assert_allclose(ball.axes.T @ ball.axes, np.eye(3), atol=1e-12)
    inside = turn[:, PLANAR]
    np.testing.assert_allclose(ball.axes @ (ball.axes.T @ inside), inside, atol=1e-10)
    assert ball.names == "3 dimensions across the axes"


@pytest.mark.parametrize("edges", [4, 12, None])
def test_cones_seen_in_the_plane_are_planar_cones(edges):
    angle = 2 * np.pi * np.arange(3) / 3
    made = [
        gq.Contact([HALF * np.cos(a), HALF * np.sin(a), 0], [-np.cos(a), -np.sin(a), 0], 0.5)
        for a in angle
    ]
    planar = []
    for c in made:
        side = 0.5 * np.cross(c.normal, [0, 0, 1.0])
        forces = np.stack([c.normal + side, c.normal - side], axis=1)
        planar.append(np.vstack([forces, np.cross(c.position, forces.T).T]))
    expected = by_hull(planar, PLANAR)
    for sets in (planar, [gq.contact_wrenches(c, edges) for c in made]):
        assert gq.epsilon(sets, subspace="planar", tol=1e-9) == pytest.approx(expected, rel=1e-8)


def test_zero_comes_with_its_reason():
    one_sided = [gq.contact_wrenches(gq.Contact(p, [0, 0, 1.0], 0.5, 1.0, 0.01)) for p in np.eye(3)]
    ball = gq.largest_ball(one_sided)
    assert ball.value == 0.0
    assert "does not reach past the origin" in ball.reason
    assert "span" in gq.largest_ball(one_sided[:1]).reason
    open_side = pushes(SQUARE[:6])
    assert "past the origin" in gq.largest_ball(open_side, subspace="planar").reason
    assert not gq.is_force_closure(open_side, subspace="planar")
    line = pushes([(HALF, 0, np.pi), (-HALF, 0, 0)])
    assert "span 1 of the 3 dimensions (fx)" in gq.largest_ball(line, subspace="planar").reason
    assert gq.epsilon(line, subspace="span") == pytest.approx(1.0)
    # Without unloading, two forces along z span what misses the origin.
    lifted = [np.array([[0, 0, 1.0, 0, 0, 0], [1.0, 0, 1.0, 0, 0, 0]]).T]
    assert "misses the origin" in gq.largest_ball(lifted, "linf", False, subspace="span").reason
    # Without friction and unloading, the wrench space is one point.
    push = gq.Contact([0.3, 0.2, 0.1], [0.6, 0.0, 0.8], 0.0)
    point = gq.largest_ball([gq.contact_wrenches(push)] * 3, unloading=False)
    assert "span 0 of the 6 dimensions (none)" in point.reason
    with pytest.raises(gq.GraspError, match="subspace"):
        gq.epsilon(line, subspace="plane")


def test_a_pinch_of_exact_cones_has_its_closed_form():
    # Two opposed soft fingers of 1 N along x. Along u = (a, 0, 0, b, 0, 0) they reach
    # max(0, a + τ |b|) + max(0, -a + τ |b|) = 2 τ |b| for |a| <= τ |b|: least where |a| = τ |b|.
    r, mu, torsion = 0.05, 0.5, 0.004
    made = [gq.Contact([s * r, 0, 0], [-s, 0, 0], mu, 1.0, torsion) for s in (1.0, -1.0)]
    exact = gq.largest_ball([gq.contact_wrenches(c, None) for c in made], tol=1e-7)
    assert exact.value == pytest.approx(2 * torsion / np.hypot(1, torsion), rel=1e-6)
    assert exact.lower <= exact.value <= exact.upper
    assert exact.upper - exact.lower <= 1e-7 * exact.value


@pytest.mark.parametrize("bound", ["linf", "l1"])
@pytest.mark.parametrize("axis", [[1.0, 0, 0], [0.6, 0.0, 0.8], [2 / 3, -1 / 3, 2 / 3]])
def test_a_set_of_revolution_is_solved_whatever_its_axis(bound, axis):
    # ε does not depend on the axis of the pinch, nor on the turn of sampled cones about it.
    values = []
    for n in ([1.0, 0, 0], axis):
        n = np.array(n)
        made = [gq.Contact(s * HALF * n, -s * n, 0.1, 1.0, 0.02) for s in (1.0, -1.0)]
        ball = gq.largest_ball([gq.contact_wrenches(c, None) for c in made], bound)
        values.append(ball.value)
        assert ball.upper - ball.lower <= 1e-5 * ball.value
        sampled = gq.epsilon([gq.contact_wrenches(c, 48) for c in made], bound)
        assert sampled <= ball.value * (1 + 1e-9)
    assert values[1] == pytest.approx(values[0], rel=2e-5)


@pytest.mark.parametrize("torsion", [0.0, 0.02])
def test_flat_sets_of_revolution_stay_flat(torsion):
    # Contacts on one line twist the object about it by torsion alone.
    n = np.array([0.48, -0.6, 0.64])
    made = [gq.Contact(s * HALF * n, -np.sign(s) * n, 0.5, 1.0, torsion) for s in (1, -1, 2)]
    sets = [gq.contact_wrenches(c, None) for c in made]
    assert gq.is_force_closure(sets) == (torsion > 0)
    ball = gq.largest_ball(sets)
    assert (ball.value > 0) == (torsion > 0)
    assert torsion or "span 5 of the 6 dimensions" in ball.reason
    frictionless = [gq.contact_wrenches(gq.Contact(c.position, c.normal, 0.0), None) for c in made]
    assert not gq.is_force_closure(frictionless)
    assert gq.epsilon(frictionless) == 0.0


def test_no_direction_that_a_flat_space_lacks_is_filled():
    # Random contacts on one line, hard and soft: closed only as far as 12 edges say so too.
    for seed in range(60):
        made = contacts(np.random.default_rng([seed, 91]), "coaxial")
        exact = gq.is_force_closure([gq.contact_wrenches(c, None) for c in made])
        assert exact == gq.is_force_closure([gq.contact_wrenches(c, 12) for c in made])
