"""Where points lie on an array, and which taxels feel what acts there, worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.robot import Pad, TaxelArray, built_in_hand

PADS = [pad for name in ("schunk_sdh2", "parallel_jaw") for pad in built_in_hand(name).pads[::3]]


def places(array: TaxelArray, count: int = 200) -> np.ndarray:
    """Random fractional rows and columns between the outermost centres (count, 2)."""
    return np.random.default_rng(1).uniform(0.0, np.array(array.shape) - 1.0, (count, 2))


def felt(array: TaxelArray, row: float, column: float, depth: float = 0.0) -> np.ndarray:
    """What the taxels (rows, columns) feel of a unit force at a place, ``depth`` [m] beneath."""
    # Beyond the ends the surface goes on straight.
    last = array.shape[0] - 1.0
    there = float(np.clip(row, 0.0, last))
    point, normal = array.surface(there, column)
    inner = float(np.clip(there, 0.5, last - 0.5))
    ends = [array.surface(inner + side, column)[0] for side in (-0.5, 0.5)]
    beyond = (row - there) * (ends[1] - ends[0])
    taxels, shares = array.shares((point + beyond - depth * normal)[None])
    found = np.zeros(array.live.size)
    np.add.at(found, taxels, shares)
    return found.reshape(array.shape)


@pytest.mark.parametrize("pad", PADS, ids=lambda pad: pad.name)
def test_coordinates_are_the_inverse_of_the_surface(pad: Pad):
    array = pad.array
    at = places(array)
    points = np.array([array.surface(*place)[0] for place in at])
    assert array.coordinates(points) == pytest.approx(at, abs=1e-9)
    # What is pressed in by a millimetre is where it was: within what the chords of a curve miss.
    deep = np.array(
        [point - 1e-3 * array.surface(*place)[1] for point, place in zip(points, at, strict=True)]
    )
    assert array.coordinates(deep) == pytest.approx(at, abs=0.02)


@pytest.mark.parametrize("pad", PADS, ids=lambda pad: pad.name)
def test_inside_neither_force_nor_centre_of_pressure_changes(pad: Pad):
    array = pad.array
    whole = array.live[:-1, :-1] & array.live[1:, :-1] & array.live[:-1, 1:] & array.live[1:, 1:]
    at = [place for place in places(array) if whole[tuple(place.astype(int))]]
    assert len(at) > 80
    for row, column in at:
        forces = felt(array, row, column)
        assert forces.sum() == pytest.approx(1.0)
        assert np.count_nonzero(forces) <= 4
        assert forces.sum(axis=1) @ np.arange(array.shape[0]) == pytest.approx(row, abs=1e-9)
        assert forces.sum(axis=0) @ np.arange(array.shape[1]) == pytest.approx(column, abs=1e-9)


def test_shares_of_a_few_places_by_hand():
    array = built_in_hand().arrays["proximal"]
    alone = felt(array, 7.0, 2.0)
    assert alone[7, 2] == pytest.approx(1.0)
    quarters = felt(array, 7.5, 2.5, depth=5e-4)
    assert quarters[7:9, 2:4] == pytest.approx(np.full((2, 2), 0.25))
    uneven = felt(array, 7.25, 2.0)
    assert uneven[7:9, 2] == pytest.approx((0.75, 0.25))


@pytest.mark.parametrize(("beyond", "whole"), [(0.0, 1), (0.25, 1), (0.49, 1), (0.51, 0), (1.3, 0)])
def test_beyond_the_border_nobody_feels_anything(beyond: float, whole: int):
    # The array ends half a pitch beyond the outermost centres.
    array = built_in_hand().arrays["proximal"]
    for row, column, cell in (
        (6, -beyond, (6, 0)), (6, 5 + beyond, (6, 5)), (13 + beyond, 2, (13, 2)),
        (-beyond, 2, (0, 2)), (-beyond, 5 + beyond, (0, 5)),
    ):  # fmt: skip
        forces = felt(array, row, column)
        assert forces[cell] == pytest.approx(whole)
        assert forces.sum() == pytest.approx(whole)
    beside = felt(array, 6.25, -beyond)
    assert beside[6:8, 0] == pytest.approx((0.75 * whole, 0.25 * whole))


def test_missing_taxels_feel_nothing():
    # The two outer columns of the distal array lack their taxels in the rows 0 to 4.
    array = built_in_hand().arrays["distal"]
    for row, column in ((2.0, 0.0), (2.0, 0.49), (4.49, 5.0)):  # on a missing one
        assert not felt(array, row, column).any()
    for row, column, cell in ((2.0, 0.51, (2, 1)), (4.51, 5.0, (5, 5))):  # on the next
        forces = felt(array, row, column)
        assert forces[cell] == pytest.approx(1.0)
        assert forces.sum() == pytest.approx(1.0)


def test_an_array_of_one_row():
    array = TaxelArray("strip", 4e-3, np.array([[0.0, 0.0, 0.0]]), np.ones((1, 3), dtype=bool))
    points = np.array([[0.0, 0.0, 0.0], [-5e-4, 2e-3, -1e-3], [0.0, 0.0, 4e-3]])
    assert array.coordinates(points) == pytest.approx(np.array([[0, 1], [0.25, 1.5], [-1, 1]]))
    _, shares = array.shares(points)
    assert shares.sum(axis=1) == pytest.approx((1.0, 1.0, 0.0))


def beside(array: TaxelArray, row: float, column: float) -> set[tuple[int, int]]:
    """Rows and columns of the taxels beside a place."""
    cells, there = array.beside(array.surface(row, column)[0])
    places = np.unravel_index(cells[there], array.shape)
    return set(zip(*(index.tolist() for index in places), strict=True))


def test_taxels_beside_a_place_without_one():
    array = built_in_hand().arrays["distal"]
    assert beside(array, 8.0, 2.0) == set()  # on a taxel
    assert beside(array, 8.3, 5.9) == {(8, 5)}  # beyond the border
    assert beside(array, 8.0, 6.6) == set()  # two places beyond
    # The two outer columns lack their taxels in the rows 0 to 4.
    assert beside(array, 2.0, 0.0) == {(2, 1)}
    assert beside(array, 4.0, 0.0) == {(4, 1), (5, 0)}
