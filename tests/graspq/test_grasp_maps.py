"""Singular values of the grasp map against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import graspq as gq
from tests.support.field_contacts import field_contacts


def test_two_hard_fingers_cannot_turn_the_object_about_their_line():
    # G Gᵀ = diag(2, 2, 2, 0, 2 a²/L², 2 a²/L²).
    pair, normals = field_contacts()["pair"]
    hard = gq.grasp_map(pair, length=0.06)
    assert hard.shape == (6, 6)
    assert gq.smallest_singular_value(hard) == 0.0
    assert gq.ellipsoid_volume(hard) == 0.0
    assert gq.isotropy(hard) == 0.0
    soft = gq.grasp_map(pair, normals, length=0.06)
    assert soft.shape == (6, 8)
    # 2 for the moment about the line, of both torsions, 2 (0.03/0.06)² = 1/2 for the others.
    assert gq.smallest_singular_value(soft) == pytest.approx(np.sqrt(0.5))
    assert gq.ellipsoid_volume(soft) == pytest.approx(np.sqrt(2**3 * 2 * 0.5 * 0.5))
    assert gq.isotropy(soft) == pytest.approx(0.5)
    assert gq.isotropy(gq.grasp_map(pair, normals, length=0.03)) == pytest.approx(1.0)


def test_six_contacts_on_the_faces_of_a_cube():
    # Σ (|r|² I - r rᵀ) = 4 a² I, and Σ I = 6 I.
    cube, _ = field_contacts()["cube"]
    found = gq.grasp_map(cube, length=0.05)
    assert gq.smallest_singular_value(found) == pytest.approx(2 * 0.025 / 0.05)
    assert gq.ellipsoid_volume(found) == pytest.approx(6**1.5 * (2 * 0.025 / 0.05) ** 3)
    assert gq.isotropy(found) == pytest.approx(1 / np.sqrt(6))


def test_columns_are_the_wrenches_of_forces_and_torsion():
    place, normal = np.array([[0.01, -0.02, 0.03]]), np.array([[0.6, 0.0, 0.8]])
    found = gq.grasp_map(place, normal, origin=[0.0, 0.01, 0.0], length=0.1)
    arm = (place[0] - [0.0, 0.01, 0.0]) / 0.1
    for k, force in enumerate(np.eye(3)):
        assert found[:, k] == pytest.approx(np.concatenate([force, np.cross(arm, force)]))
    assert found[:, 3] == pytest.approx(np.concatenate([np.zeros(3), normal[0]]))


@pytest.mark.parametrize("name", field_contacts())
def test_turning_scaling_and_order_do_not_matter(name):
    positions, normals = field_contacts()[name]
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    order = np.roll(np.arange(len(positions)), 1)
    base = gq.grasp_map(positions, normals, length=0.05)
    others = (
        gq.grasp_map(positions @ turn.T, normals @ turn.T, length=0.05),
        gq.grasp_map(3 * positions, normals, length=0.15),
        gq.grasp_map(positions[order], -normals[order], length=0.05),
        gq.grasp_map(positions + 0.2, normals, origin=[0.2, 0.2, 0.2], length=0.05),
    )
    for other in others:
        for measure in (gq.smallest_singular_value, gq.ellipsoid_volume, gq.isotropy):
            assert measure(other) == pytest.approx(measure(base), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: gq.grasp_map(np.zeros((0, 3))), "positions: got no contact"),
        (lambda: gq.grasp_map(np.zeros((2, 2))), r"positions: expected shape \(n, 3\)"),
        (lambda: gq.grasp_map([[0, 0, np.nan]]), "finite"),
        (lambda: gq.grasp_map(np.zeros((2, 3)), np.eye(3)), "one per position"),
        (lambda: gq.grasp_map(np.zeros((1, 3)), [[0, 0, 2.0]]), "unit vectors, got length 2 in"),
        (
            lambda: gq.grasp_map(np.zeros((1, 3)), length=0.0),
            "length: expected a finite",
        ),
        (lambda: gq.isotropy(np.zeros((6, 0))), "no column"),
        (lambda: gq.isotropy(np.zeros((3, 6))), "grasp_map's result"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(gq.GraspError, match=words):
        call()


def test_a_map_of_zeros_has_no_isotropy():
    assert gq.isotropy(np.zeros((6, 3))) == 0.0
