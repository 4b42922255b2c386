"""Volumes against qhull, closed forms and how they must scale."""

import math
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import graspq as gq
from graspq._engines.qhull_check import product_volume
from tests.support.random_grasps import KINDS, grasp


@pytest.mark.parametrize("kind", KINDS)
def test_volume_equals_that_of_the_whole_hull(kind):
    for seed in range(14):
        rng = np.random.default_rng([seed, 12])
        wrenches = grasp(rng, kind, edges=int(rng.choice([3, 4, 6])))
        if np.prod([w.shape[1] + 1 for w in wrenches], dtype=float) > 300:
            wrenches = wrenches[:2]
        if np.prod([w.shape[1] + 1 for w in wrenches], dtype=float) > 300:
            continue
        bound, unloading = ["linf", "l1"][rng.integers(2)], bool(rng.integers(2))
        value = gq.volume(wrenches, bound, unloading)
        assert value == pytest.approx(product_volume(wrenches, bound, unloading), rel=1e-6)


def test_three_polygons_have_a_closed_form():
    rng = np.random.default_rng(8)
    wrenches = grasp(rng, "random", 12)
    area, sides = 1.0, []
    for w in wrenches:
        middle = w.mean(axis=1)
        a, b = w[:, 0] - middle, w[:, 3] - middle
        # A regular 12-gon of radius one has area 3, in units of its two half-axes.
        area *= 3.0
        sides += [a, b]
    exact = area * abs(np.linalg.det(np.column_stack(sides)))
    assert gq.volume(wrenches, unloading=False) == pytest.approx(exact, rel=1e-6)


def test_boxes_multiply():
    sides = [np.column_stack([np.zeros(6), (i + 1.0) * e]) for i, e in enumerate(np.eye(6))]
    assert gq.volume(sides) == pytest.approx(720.0, rel=1e-6)
    assert gq.volume(sides, "l1") == pytest.approx(1.0, rel=1e-9)
    assert gq.volume(sides + sides[:1]) == pytest.approx(1440.0, rel=1e-6)
    assert gq.volume(sides[:5]) == 0.0


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 10.0))
def test_scaling_turning_and_moving(seed, factor):
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    wrenches = grasp(rng, "random", 12)
    value = gq.volume(wrenches)
    assert gq.volume([factor * w for w in wrenches]) == pytest.approx(factor**6 * value, rel=1e-6)
    both = np.kron(np.eye(2), Rotation.random(rng=rng).as_matrix())
    assert gq.volume([both @ w for w in wrenches]) == pytest.approx(value, rel=1e-6)
    # Taking moments about another point shears the space, which keeps its volume.
    x, y, z = rng.normal(size=3)
    shear = np.eye(6)
    shear[3:, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    assert gq.volume([shear @ w for w in wrenches]) == pytest.approx(value, rel=1e-6)
    assert gq.volume(wrenches, "l1") <= value * (1 + 1e-6)


def test_four_contacts_sum_up():
    rng = np.random.default_rng(3)
    wrenches = grasp(rng, "random", 3) + grasp(rng, "random", 3)[:1]
    assert gq.volume(wrenches) == pytest.approx(product_volume(wrenches), rel=1e-6)


def soft_grasp(rng, count, edges=12):
    """Soft contacts spread over a ball, pressing inwards."""
    made = []
    for _ in range(count):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        at = -0.05 * n + 0.01 * rng.normal(size=3)
        made.append(gq.contact_wrenches(gq.Contact(at, n, 0.6, 1.0, 0.01), edges))
    return made


def zonotope_volume(segments):
    """Σ |det| over all six of the segments (6, m): McMullen, Shephard."""
    return sum(
        abs(np.linalg.det(segments[:, list(six)]))
        for six in combinations(range(segments.shape[1]), 6)
    )


@pytest.mark.parametrize("count", [6, 7, 9, 12])
def test_sums_of_segments_are_zonotopes(count):
    rng = np.random.default_rng([count, 41])
    segments = rng.normal(size=(6, count))
    exact = zonotope_volume(segments)
    sets = [np.column_stack([-0.5 * s, 0.5 * s]) for s in segments.T]
    assert gq.volume(sets, unloading=False) == pytest.approx(exact, rel=1e-6)
    # From zero to a segment's end: the same zonotope, moved.
    assert gq.volume([s[:, None] for s in segments.T]) == pytest.approx(exact, rel=1e-6)
    # Segments two by two make parallelograms: faces of dimension two take part.
    pairs = [
        np.column_stack([0 * a, a, b, a + b])
        for a, b in zip(*[segments.T[k::2] for k in (0, 1)], strict=False)
    ]
    left = [segments[:, -1:]] if count % 2 else []
    assert gq.volume(pairs + left) == pytest.approx(exact, rel=1e-6)


def test_parallelepipeds_of_every_dimension_are_zonotopes():
    rng = np.random.default_rng(42)
    for dims in (
        [4, 2],
        [4, 3],
        [3, 3],
        [5, 1],
        [4, 2, 1],
        [3, 2, 2],
        [2, 2, 2, 2],
        [4, 4],
        [6, 2],
    ):
        segments = rng.normal(size=(6, sum(dims)))
        sets, at = [], 0
        for d in dims:
            corners = np.array(list(product([0.0, 1.0], repeat=d))).T
            sets.append(segments[:, at : at + d] @ corners)
            at += d
        exact = zonotope_volume(segments)
        assert gq.volume(sets, unloading=False) == pytest.approx(exact, rel=1e-6), dims


@pytest.mark.parametrize("dims", [(3, 3), (2, 4), (1, 5), (2, 2, 2), (3, 2, 1), (1, 1, 1, 3)])
def test_simplices_in_complements_multiply(dims):
    rng = np.random.default_rng(43)
    axes = rng.normal(size=(6, 6))
    sets, at, exact = [], 0, abs(np.linalg.det(axes))
    for d in dims:
        sets.append(axes[:, at : at + d])
        at += d
        exact /= math.factorial(d)
    # With zero they are simplices of these dimensions.
    assert gq.volume(sets) == pytest.approx(exact, rel=1e-6)


def test_a_body_added_to_itself_grows_by_its_power():
    rng = np.random.default_rng(44)
    a, b = soft_grasp(rng, 2, 4)
    # V(x A + y B) is a polynomial of degree six (Minkowski): seven values fix it.
    y = np.arange(1.0, 9.0)
    values = np.array([gq.volume([a, t * b]) for t in y])
    fitted = np.polynomial.polynomial.polyfit(y[:7], values[:7], 6)
    assert np.polynomial.polynomial.polyval(y[7], fitted) == pytest.approx(values[7], rel=1e-5)
    assert gq.volume([a, b, b]) == pytest.approx(values[1], rel=1e-6)
    assert gq.volume([a, b, b, b]) == pytest.approx(values[2], rel=1e-6)


@pytest.mark.parametrize("count", [4, 5])
def test_many_soft_contacts(count):
    rng = np.random.default_rng([count, 45])
    wrenches = soft_grasp(rng, count, 6)
    value = gq.volume(wrenches)
    assert gq.volume([0.3 * w for w in wrenches]) == pytest.approx(0.3**6 * value, rel=1e-6)
    assert gq.volume(wrenches[::-1]) == pytest.approx(value, rel=1e-6)
    turn = rng.normal(size=(6, 6))
    turn /= abs(np.linalg.det(turn)) ** (1 / 6)
    assert gq.volume([turn @ w for w in wrenches]) == pytest.approx(value, rel=1e-6)
    assert gq.volume(wrenches[:-1]) <= value * (1 + 1e-6)
    assert gq.volume(wrenches, unloading=False) <= value * (1 + 1e-6)
    # Split one contact into two that press half as much: the same sum.
    halves = [0.5 * wrenches[0], 0.5 * wrenches[0], *wrenches[1:]]
    if count == 4:
        assert gq.volume(halves) == pytest.approx(value, rel=1e-6)
        # A polytope inside, and the ball inside that.
        assert gq.volume(wrenches, "l1") <= value
        radius = gq.epsilon(wrenches)
        assert np.pi**3 / 6 * radius**6 <= value


def test_facets_that_do_not_close_are_refused(monkeypatch):
    import sys

    module = sys.modules["graspq.volume"]
    sides = soft_grasp(np.random.default_rng(46), 3, 4)
    gq.volume(sides)
    whole = module.lattice_of

    def with_one_face_too_large(points):
        lattice = whole(points)
        sizes = lattice.volume.copy()
        sizes[lattice.first[2]] *= 1.01
        return replace(lattice, volume=sizes)

    monkeypatch.setattr(module, "lattice_of", with_one_face_too_large)
    with pytest.raises(gq.GraspError, match="of the surface open"):
        gq.volume(sides)


def test_too_many_combinations_are_refused():
    rng = np.random.default_rng(47)
    with pytest.raises(gq.GraspError, match="combinations of faces"):
        gq.volume(soft_grasp(rng, 12))


def test_what_is_out_of_reach_is_said():
    rng = np.random.default_rng(1)
    many = [gq.contact_wrenches(gq.Contact(rng.normal(size=3), [0, 0, 1.0], 0.5), 65)] * 2
    many += grasp(rng, "random", 12)
    with pytest.raises(gq.GraspError, match="fewer edges"):
        gq.volume(many)
    with pytest.raises(gq.GraspError, match="EllipsoidSet"):
        gq.volume([gq.contact_wrenches(gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5), None)])
