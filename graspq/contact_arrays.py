"""Checks for contacts given as arrays: positions, normals and coefficients of friction."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from graspq.errors import UNIT_TOLERANCE, GraspError, as_array


class ContactArrays(NamedTuple):
    """Places and normals of a grasp's contacts.

    Attributes:
        positions: (n, 3) [m], n >= 1.
        normals: unit vectors (n, 3).
    """

    positions: np.ndarray
    normals: np.ndarray


def as_positions(positions: ArrayLike) -> np.ndarray:
    """Return places of contacts as an array (n, 3) [m], n >= 1."""
    array = as_array("positions", positions, (None, 3), "one contact per row")
    if len(array) == 0:
        raise GraspError("positions: got no contact, expected shape (n, 3) with n >= 1")
    return array


def as_contacts(positions: ArrayLike, normals: ArrayLike) -> ContactArrays:
    """Return places and unit normals of contacts, as many of each."""
    places = as_positions(positions)
    directions = as_array("normals", normals, (None, 3), "one contact per row")
    if len(directions) != len(places):
        raise GraspError(
            f"normals: expected one per position, got {len(directions)} for {len(places)} positions"
        )
    lengths = np.linalg.norm(directions, axis=1)
    wrong = np.abs(lengths - 1.0) > UNIT_TOLERANCE
    if wrong.any():
        row = int(np.argmax(wrong))
        raise GraspError(
            f"normals: expected unit vectors, got length {lengths[row]:.9g} in row {row}; divide"
            " each by its norm"
        )
    return ContactArrays(places, directions)


def as_coefficients(name: str, value: Any, count: int) -> np.ndarray:
    """Return one number >= 0 per contact (count,); a single number is that of every contact."""
    array = as_array(name, value, ()) if np.ndim(value) == 0 else as_array(name, value, (None,))
    if array.ndim and len(array) != count:
        raise GraspError(
            f"{name}: expected one number, or one per contact, got {len(array)} for {count}"
            " contacts"
        )
    if (array < 0).any():
        raise GraspError(f"{name}: expected numbers >= 0, got {array.min():g}")
    return np.broadcast_to(array, (count,))


def tangents_from_y(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit tangents (n, 3) for every normal (n, 3): the y axis projected, and n × that.

    Where the y axis is within 8° of the normal, the z axis takes its place. They decide where the
    edges of friction pyramids lie, so DexGraspBench's choice is kept.
    """
    along = np.abs(normals[:, 1:2]) > 0.99
    axis = np.where(along, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    first = axis - (axis * normals).sum(axis=1, keepdims=True) * normals
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)
