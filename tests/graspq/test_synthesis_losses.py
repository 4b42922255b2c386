"""DFC, Q1 and TDG against closed forms, and what must not change them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import graspq as gq
from tests.support.field_contacts import field_contacts

TURN = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
LOSSES = {
    "dfc": gq.dfc_residual,
    "q1": lambda p, n: gq.dexgraspbench_q1(p, n, 0.5),
    "tdg": lambda p, n: gq.tdg_loss(p, n, 0.5),
}


def test_dfc_of_equal_forces():
    made = field_contacts()
    assert gq.dfc_residual(*made["pair"]) == 0.0
    assert gq.dfc_residual(*made["cube"]) == pytest.approx(0.0, abs=1e-15)
    angles = np.radians([0.0, 120.0, 240.0])
    ring = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    assert gq.dfc_residual(0.03 * ring, -ring) == pytest.approx(0.0, abs=1e-14)
    assert gq.dfc_residual([[0.01, 0.02, 0.03]], [[0, 0, 1.0]]) == pytest.approx(1.0)
    # Two forces the same way, and a pair of forces a length apart (arms are scaled to 1).
    places = [[0.05, 0, 0], [-0.05, 0, 0]]
    assert gq.dfc_residual(places, [[0, 0, 1.0], [0, 0, 1.0]]) == pytest.approx(2.0)
    assert gq.dfc_residual(places, [[0, 0, 1.0], [0, 0, -1.0]]) == pytest.approx(2.0, rel=1e-4)


@pytest.mark.parametrize("name", ["cube", "ellipsoid_3", "ellipsoid_6", "one_side"])
def test_q1_is_two_minus_epsilon_whether_the_cones_hold_the_origin_or_not(name):
    # The published way: the smallest distance of any facet's plane from the origin, without a sign.
    positions, normals = field_contacts()[name]
    arms = positions - positions.mean(axis=0)
    arms /= np.linalg.norm(arms, axis=1).mean() + 1e-6
    first, second = np.zeros_like(normals), np.zeros_like(normals)
    for k, normal in enumerate(normals):
        axis = [0, 0, 1.0] if abs(normal[1]) > 0.99 else [0, 1.0, 0]
        tangent = np.cross(normal, np.cross(axis, normal))
        first[k] = tangent / np.linalg.norm(tangent)
        second[k] = np.cross(normal, first[k])
    angles = np.pi / 4 * np.arange(8)[:, None, None]
    forces = normals + 0.5 * (np.sin(angles) * first + np.cos(angles) * second)
    wrenches = np.concatenate([forces, np.cross(arms, forces)], axis=2).reshape(-1, 6)
    planes = ConvexHull(np.vstack([wrenches, np.zeros(6)])).equations
    distance = np.abs(planes[:, 6]).min()
    assert gq.dexgraspbench_q1(positions, normals, 0.5) == pytest.approx(2 - distance, abs=1e-12)
    assert gq.scaled_epsilon(positions, normals, 0.5) == pytest.approx(distance, abs=1e-12)
    assert (distance > 1e-9) == (name != "one_side")


def test_tdg_of_one_contact():
    # Along the normal, against it, across it, and within the cone.
    place, normal, mu = [[0.01, 0.02, 0.03]], [[0, 0, 1.0]], 0.5
    for direction, cosine in (
        ([0, 0, 1.0], 1.0),
        ([0, 0, -1.0], 0.0),
        ([1.0, 0, 0], mu / np.sqrt(1 + mu**2)),
        ([0.28, 0, 0.96], 1.0),
    ):
        loss = gq.tdg_loss(place, normal, mu, [direction])
        assert loss == pytest.approx(1 - cosine, abs=1e-12)


def test_tdg_of_a_cube_along_its_axes():
    assert gq.tdg_loss(*field_contacts()["cube"], 0.5, np.eye(3)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", field_contacts())
def test_order_place_size_and_side_do_not_matter(name):
    positions, normals = field_contacts()[name]
    for loss in LOSSES.values():
        value = loss(positions, normals)
        assert loss(positions[::-1], normals[::-1]) == pytest.approx(value, rel=1e-9, abs=1e-9)
        assert loss(positions + 0.3, normals) == pytest.approx(value, rel=1e-9, abs=1e-9)
        assert loss(positions, -normals) == pytest.approx(value, rel=1e-9, abs=1e-9)
        # But for the micrometre that is added to the mean arm.
        assert loss(2 * positions, normals) == pytest.approx(value, rel=1e-4)


@pytest.mark.parametrize("name", field_contacts())
def test_turning_changes_what_depends_on_edges_alone(name):
    positions, normals = field_contacts()[name]
    turned = positions @ TURN.T, normals @ TURN.T
    assert gq.dfc_residual(*turned) == pytest.approx(gq.dfc_residual(positions, normals), abs=1e-12)
    aims = np.random.default_rng(1).normal(size=(40, 3))
    aims /= np.linalg.norm(aims, axis=1)[:, None]
    assert gq.tdg_loss(*turned, 0.5, aims @ TURN.T) == pytest.approx(
        gq.tdg_loss(positions, normals, 0.5, aims), abs=1e-12
    )


def test_the_directions_stand_for_all():
    # Without friction one contact exerts its normal in every direction, and 1 - n·u has the mean 1.
    loss = gq.tdg_loss([[0, 0, 0.01]], [[0, 0, 1.0]], 0.0)
    assert loss == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("loss", [*LOSSES.values(), lambda p, n: gq.scaled_epsilon(p, n, 0.5)])
def test_bad_input_is_named(loss):
    up = [[0, 0, 1.0]]
    for positions, normals, words in (
        (np.zeros((0, 3)), np.zeros((0, 3)), "positions: got no contact"),
        ([[0, 0, np.nan]], up, "finite"),
        (np.zeros((2, 3)), up, "one per position"),
        (np.zeros((1, 3)), [[0, 0, 0.5]], "unit vectors"),
        (np.zeros((1, 2)), up, "shape"),
    ):
        with pytest.raises(gq.GraspError, match=words):
            loss(positions, normals)


@pytest.mark.parametrize(
    ("friction", "words"),
    [
        (-0.1, ">= 0"),
        (np.nan, "finite"),
        ([0.5, 0.5, 0.5], "one per contact"),
        ("rough", "friction"),
    ],
)
def test_a_bad_friction_is_named(friction, words):
    for loss in (gq.dexgraspbench_q1, gq.tdg_loss, gq.qp_residual, gq.qp_dfc_residual):
        with pytest.raises(gq.GraspError, match=words):
            loss(*field_contacts()["pair"], friction)


def test_bad_directions_are_named():
    for bad in (np.zeros((0, 3)), np.ones((2, 3)), np.eye(2)):
        with pytest.raises(gq.GraspError, match="directions"):
            gq.tdg_loss(*field_contacts()["pair"], 0.5, bad)
