"""Distance, area and shape of contacts against school geometry."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import graspq as gq

ANGLES = np.radians([90.0, 210.0, 330.0])
EQUILATERAL = 0.04 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES])
RIGHT = np.array([[0.0, 0, 0], [0.03, 0, 0], [0, 0.03, 0]])
SQUARE = np.array([[0.0, 0, 0], [0.02, 0, 0], [0.02, 0.02, 0], [0, 0.02, 0]])


def test_distance_of_the_centroid():
    assert gq.centroid_distance(EQUILATERAL) == pytest.approx(0.0, abs=1e-15)
    assert gq.centroid_distance(SQUARE, [0.01, 0.01, 0.05]) == pytest.approx(0.05)
    assert gq.centroid_distance([[0.03, 0.0, 0.04]]) == pytest.approx(0.05)


def test_triangles():
    assert gq.contact_area(EQUILATERAL) == pytest.approx(3 * np.sqrt(3) / 4 * 0.04**2)
    assert gq.contact_shape(EQUILATERAL) == pytest.approx(0.0, abs=1e-12)
    # 90°, 45°, 45°: off by 30 + 15 + 15 of at most 60 + 60 + 120.
    assert gq.contact_area(RIGHT) == pytest.approx(0.5 * 0.03**2)
    assert gq.contact_shape(RIGHT) == pytest.approx(60 / 240)


def test_other_numbers_of_contacts():
    assert gq.contact_area(SQUARE) == pytest.approx(0.02**2)
    assert gq.contact_shape(SQUARE) == pytest.approx(0.0, abs=1e-12)
    within = np.vstack([SQUARE, [[0.007, 0.011, 0.0]]])
    assert gq.contact_area(within) == pytest.approx(0.02**2)
    assert gq.contact_shape(within) == pytest.approx(0.0, abs=1e-12)
    # A square bent along its sides stays the square in the plane nearest to it.
    bent = SQUARE + np.array([[0, 0, h] for h in (0.002, -0.002, 0.002, -0.002)])
    assert gq.contact_area(bent) == pytest.approx(0.02**2)
    for few in (SQUARE[:1], SQUARE[:2], np.outer([0.0, 1.0, 3.0], [0.01, 0.02, 0.0])):
        assert gq.contact_area(few) == 0.0
        assert gq.contact_shape(few) == 1.0
    assert gq.contact_area(np.zeros((4, 3))) == 0.0


def test_a_flatter_triangle_is_a_worse_one():
    heights = (0.03, 0.01, 0.001, 1e-5)
    shapes = [gq.contact_shape([[-0.02, 0, 0], [0.02, 0, 0], [0, h, 0]]) for h in heights]
    assert shapes == sorted(shapes)
    assert shapes[-1] == pytest.approx(1.0, abs=1e-2)


def test_turning_moving_order_and_scale():
    triangle = np.array([[0.01, 0.02, 0.0], [0.04, -0.01, 0.01], [-0.02, 0.0, 0.03]])
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    moved = (triangle @ turn.T + [0.1, 0.2, -0.3])[[2, 0, 1]]
    assert gq.contact_area(moved) == pytest.approx(gq.contact_area(triangle))
    assert gq.contact_shape(moved) == pytest.approx(gq.contact_shape(triangle))
    assert gq.contact_area(2 * triangle) == pytest.approx(4 * gq.contact_area(triangle))
    assert gq.contact_shape(2 * triangle) == pytest.approx(gq.contact_shape(triangle))


@pytest.mark.parametrize(
    "function", [gq.centroid_distance, gq.contact_area, gq.contact_shape], ids=lambda f: f.__name__
)
def test_bad_input_is_named(function):
    for bad in (np.zeros((0, 3)), [[0.0, np.inf, 0.0]], [1.0, 2.0, 3.0], "contacts"):
        with pytest.raises(gq.GraspError, match="positions"):
            function(bad)
