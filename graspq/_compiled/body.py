"""Wrench spaces as the arrays that their support functions read: one, and many side by side."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Rows whose extent is less than this share of the largest count as at least that.
LEAST_EXTENT = 1e-6


class Body(NamedTuple):
    """A Minkowski sum of convex sets, less a shift, inside compiled code.

    Set i is the convex hull of the points ``points[:, first_point[i]:first_point[i + 1]]``, of
    the ellipsoids ``{centres[:, k] + axes[k] x : |x| <= 1}`` for k from ``first_ellipsoid[i]`` to
    ``first_ellipsoid[i + 1]`` and, where ``holds_origin``, of the origin.

    Attributes:
        points: shape (6, K); columns beyond the last set's are not looked at.
        first_point: shape (n + 1,), where each set's points begin; the first is 0.
        centres: centres of ellipsoids, shape (6, E).
        axes: their axes, shape (E, 6, 3).
        first_ellipsoid: shape (n + 1,), where each set's ellipsoids begin.
        holds_origin: whether every set holds the origin, as that of a contact that may unload.
        shift: what is taken off the sum, shape (6,).
    """

    points: np.ndarray
    first_point: np.ndarray
    centres: np.ndarray
    axes: np.ndarray
    first_ellipsoid: np.ndarray
    holds_origin: bool
    shift: np.ndarray


class Bodies(NamedTuple):
    """N bodies side by side, as entries take them; ``Bodies`` of one grasp has N = 1.

    Attributes:
        points: points of all sets of all bodies, shape (6, K).
        first_point: where each set's points begin, and the end, shape (number of sets + 1,).
        centres: centres of ellipsoids, shape (6, E).
        axes: their axes, shape (E, 6, 3).
        first_ellipsoid: where each set's ellipsoids begin, and the end.
        first_set: where each body's sets begin, and the end, shape (N + 1,).
        holds_origin: whether every set holds the origin.
    """

    points: np.ndarray
    first_point: np.ndarray
    centres: np.ndarray
    axes: np.ndarray
    first_ellipsoid: np.ndarray
    first_set: np.ndarray
    holds_origin: bool
