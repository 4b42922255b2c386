"""Compiled entry: maps that make polytopes about round; it runs without the interpreter's lock.

A linear map under which a set of points has the unit matrix as its scatter matrix S = Σ x xᵀ
makes their hull about round ("whitening"; A. Kessy, A. Lewin and K. Strimmer, "Optimal whitening
and decorrelation", The American Statistician 72, 2018). With the Cholesky factor S = L Lᵀ it is
L⁻¹: no eigenvectors are needed.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.body import LEAST_EXTENT
from graspq._compiled.body_reading import largest
from graspq._compiled.jit import compiled, entry

# Scatter matrices of a greater condition number are too close to singular for round-off.
MOST_CONDITION = 1e11


@compiled
def _row_extents(points, begin, end, size):
    """Write the largest absolute entry per row of some columns; return the largest of all."""
    most = 0.0
    for r in range(6):
        big = 0.0
        # A slice, since only loops from 0 become vector code.
        row = points[r, begin:end]
        for k in range(row.shape[0]):
            reach = abs(row[k])
            big = reach if reach > big else big
        size[r] = big
        most = max(most, big)
    return most


@compiled
def _centre(points, first_point, begin, end, holds_origin, size, moved, inner):
    """Write an inner point of the sets from ``begin`` to ``end``, and what spans them.

    A set that holds the origin is spanned by its points, another by what they differ from their
    mean. ``moved`` receives it in units of ``size``.
    """
    offset = first_point[begin]
    for r in range(6):
        inner[r] = 0.0
        for i in range(begin, end):
            own = points[r, first_point[i] : first_point[i + 1]]
            total = 0.0
            for k in range(own.shape[0]):
                total += own[k]
            mean = total / (own.shape[0] + (1.0 if holds_origin else 0.0))
            inner[r] += mean
            away = 0.0 if holds_origin else mean
            row = moved[r, first_point[i] - offset : first_point[i + 1] - offset]
            for k in range(own.shape[0]):
                row[k] = (own[k] - away) / size[r]


@compiled
def _factor_scatter(moved, count, factor):
    """Write the Cholesky factor of the scatter matrix; return its trace, 0 where it has none."""
    trace = 0.0
    for r in range(6):
        for c in range(r + 1):
            row, other = moved[r, :count], moved[c, :count]
            total = 0.0
            for k in range(count):
                total += row[k] * other[k]
            product = total
            for m in range(c):
                total -= factor[r, m] * factor[c, m]
            if c < r:
                factor[r, c] = total / factor[c, c]
                continue
            # A diagonal entry over its pivot is no more than the condition number.
            if not total * MOST_CONDITION > product:
                return 0.0
            factor[r, r] = np.sqrt(total)
            trace += product
    return trace


@compiled
def _invert_triangle(factor, inverse):
    """Write the inverse of a lower triangular matrix; return the sum of its squares."""
    squares = 0.0
    for c in range(6):
        for r in range(6):
            total = 1.0 if r == c else 0.0
            for m in range(c, r):
                total -= factor[r, m] * inverse[m, c]
            inverse[r, c] = total / factor[r, r] if r >= c else 0.0
            squares += inverse[r, c] * inverse[r, c]
    return squares


@compiled
def _turn(turn, points, begin, end, out):
    """Write ``turn`` times some columns."""
    for r in range(6):
        t0, t1, t2 = turn[r, 0], turn[r, 1], turn[r, 2]
        t3, t4, t5 = turn[r, 3], turn[r, 4], turn[r, 5]
        own, row = points[:, begin:end], out[r, begin:end]
        for k in range(row.shape[0]):
            row[k] = (
                t0 * own[0, k]
                + t1 * own[1, k]
                + t2 * own[2, k]
                + t3 * own[3, k]
                + t4 * own[4, k]
                + t5 * own[5, k]
            )


@entry
def whiten_bodies(points, first_point, first_set, holds_origin, turned, turns, inner, flat):
    """Make many polytopes about round, with extent 1 in every row.

    Args:
        points, first_point, first_set, holds_origin: as in ``Bodies``, without ellipsoids.
        turned: receives the points of the round bodies, shape (6, K).
        turns: receives the maps that take the bodies there, shape (N, 6, 6).
        inner: receives an inner point of each of them, there, shape (N, 6).
        flat: receives whether a body is flat or too close to flat to tell, shape (N,).
    """
    moved = np.empty((6, largest(first_point, first_set)[0]))
    factor, size, middle = np.empty((6, 6)), np.empty(6), np.empty(6)
    for g in range(first_set.shape[0] - 1):
        turn = turns[g]
        sets = first_set[g], first_set[g + 1]
        begin, end = first_point[sets[0]], first_point[sets[1]]
        most = _row_extents(points, begin, end, size)
        for r in range(6):
            size[r] = max(size[r], LEAST_EXTENT * most) if most > 0.0 else 1.0
        _centre(points, first_point, sets[0], sets[1], holds_origin, size, moved, middle)
        trace = _factor_scatter(moved, end - begin, factor)
        # The condition number is at most trace S · trace S⁻¹.
        flat[g] = True
        if trace > 0.0:
            flat[g] = not trace * _invert_triangle(factor, turn) < MOST_CONDITION
        for r in range(6):
            for c in range(6):
                if flat[g]:
                    turn[r, c] = 1.0 if r == c else 0.0
                turn[r, c] /= size[c]
        _turn(turn, points, begin, end, turned)
        _row_extents(turned, begin, end, size)
        for r in range(6):
            scale = 1.0 / size[r] if size[r] > 0.0 else 1.0
            row = turned[r, begin:end]
            for k in range(row.shape[0]):
                row[k] *= scale
            inner[g, r] = 0.0
            for c in range(6):
                turn[r, c] *= scale
                inner[g, r] += turn[r, c] * middle[c]
