"""The object's wrench space against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import graspq as gq
from tests.support.field_contacts import field_contacts


def cube_corners(half: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a cube's six faces (24, 3) [m] with normals into it."""
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    places, normals = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            places.append(half * signs[signs[:, axis] == side])
            normals.append(np.tile(-side * np.eye(3)[axis], (4, 1)))
    return np.concatenate(places), np.concatenate(normals)


def test_unit_wrenches_are_those_of_contacts():
    for positions, normals in field_contacts().values():
        found = gq.unit_wrenches(positions, normals, 0.4, 7, origin=[0.01, 0, 0.02], length=0.05)
        for place, normal, wrenches in zip(positions, normals, found, strict=True):
            contact = gq.Contact(place, normal, 0.4)
            expected = gq.contact_wrenches(
                contact, 7, torque_scale=1 / 0.05, origin=[0.01, 0, 0.02]
            )
            assert wrenches == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("length", "value"), [(1.0, 1 / np.sqrt(3)), (2.0, 1 / np.sqrt(5))])
def test_epsilon_of_a_frictionless_cube(length, value):
    # With s = a / length, a face exerts n and any moment of the square (-s, s)² across n, so
    # h(f, m) = max over faces of |f_i| + s (|m_j| + |m_k|). Where h <= 1, the longest (f, m) are
    # the corners (1, 1, 1, 0, 0, 0) and (1, 0, 0, 1/s, 0, 0): ε² = 1 / max(3, 1 + 1/s²).
    sets = gq.unit_wrenches(*cube_corners(1.0), 0.0, 4, length=length)
    assert gq.surface_epsilon(sets) == pytest.approx(value, rel=1e-9)


def test_a_grasp_against_its_object():
    surface = gq.unit_wrenches(*cube_corners(0.025), 0.5, 8, length=0.04)
    assert gq.relative_epsilon(surface, surface) == pytest.approx(1.0)
    made = field_contacts()
    cube = gq.unit_wrenches(*made["cube"], 0.5, 8, length=0.04)
    ratio = gq.relative_epsilon(cube, surface)
    assert 0 < ratio < 1
    assert gq.relative_epsilon(cube[:1], surface) == 0.0
    # Size alone does not matter.
    larger = gq.unit_wrenches(*cube_corners(0.05), 0.5, 8, length=0.08)
    both = 2 * made["cube"][0], made["cube"][1]
    grown = gq.unit_wrenches(*both, 0.5, 8, length=0.08)
    assert gq.relative_epsilon(grown, larger) == pytest.approx(ratio)


def test_a_surface_that_cannot_be_turned_is_named():
    angles = np.pi / 8 * np.arange(16)
    ring = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    sets = gq.unit_wrenches(0.03 * ring, -ring, 0.0)
    with pytest.raises(gq.GraspError, match="surface: its wrenches do not hold the origin"):
        gq.surface_epsilon(sets)


def test_bad_input_is_named():
    up = [[0, 0, 1.0]]
    for call, words in (
        (lambda: gq.unit_wrenches(np.zeros((0, 3)), np.zeros((0, 3)), 0.5), "no contact"),
        (lambda: gq.unit_wrenches([[0, 0, 0.1]], up, 0.5, 2), "edges"),
        (lambda: gq.unit_wrenches([[0, 0, np.nan]], up, 0.5), "finite"),
        (lambda: gq.unit_wrenches([[0, 0, 0.1]], up, 0.5, length=-1.0), "length"),
        (lambda: gq.unit_wrenches([[0, 0, 0.1]], up, [0.5, 0.4]), "friction"),
    ):
        with pytest.raises(gq.GraspError, match=words):
            call()
