"""Compiled: take one body out of many that lie side by side."""

from __future__ import annotations

import numpy as np

from graspq._compiled.body import LEAST_EXTENT, Body
from graspq._compiled.jit import compiled


@compiled
def largest(first_point, first_set):
    """Most points and most sets of any body."""
    columns, sets = 0, 0
    for g in range(first_set.shape[0] - 1):
        sets = max(sets, first_set[g + 1] - first_set[g])
        columns = max(columns, first_point[first_set[g + 1]] - first_point[first_set[g]])
    return columns, sets


@compiled
def take(bodies, g, shift, own, own_first):
    """Return body g, with its points copied side by side to ``own``: (6, K) and (n + 1,)."""
    begin, end = bodies.first_set[g], bodies.first_set[g + 1]
    offset = bodies.first_point[begin]
    for i in range(end - begin + 1):
        own_first[i] = bodies.first_point[begin + i] - offset
    # A size that the compiler does not know keeps it from unrolling the loop.
    for r in range(own.shape[0]):
        for k in range(own_first[end - begin]):
            own[r, k] = bodies.points[r, offset + k]
    return Body(
        own,
        own_first[: end - begin + 1],
        bodies.centres,
        bodies.axes,
        bodies.first_ellipsoid[begin : end + 1],
        bodies.holds_origin,
        shift,
    )


@compiled(fastmath={"nsz", "reassoc"})
def extent(body, size):
    """Write the largest absolute entry per row of the body's points and ellipsoids.

    Returns whether all points are finite, short of 1e308.
    """
    most, total = 0.0, 0.0
    sets = body.first_point.shape[0] - 1
    for r in range(6):
        big = abs(body.shift[r])
        row = body.points[r]
        for k in range(body.first_point[sets]):
            entry = abs(row[k])
            big = entry if entry > big else big
            total += entry
        for k in range(body.first_ellipsoid[0], body.first_ellipsoid[sets]):
            big = max(big, abs(body.centres[r, k]))
            for c in range(3):
                big = max(big, abs(body.axes[k, r, c]))
        size[r] = big
        most = max(most, big)
    for r in range(6):
        size[r] = max(size[r], LEAST_EXTENT * most)
    return total < np.inf
