"""Volumes against qhull, closed forms and how they must scale."""

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


def test_what_is_out_of_reach_is_said():
    rng = np.random.default_rng(1)
    many = [gq.contact_wrenches(gq.Contact(rng.normal(size=3), [0, 0, 1.0], 0.5), 65)] * 2
    many += grasp(rng, "random", 12)
    with pytest.raises(gq.GraspError, match="fewer edges"):
        gq.volume(many)
    with pytest.raises(gq.GraspError, match="EllipsoidSet"):
        gq.volume([gq.contact_wrenches(gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5), None)])
