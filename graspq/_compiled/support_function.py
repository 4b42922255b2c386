"""Compiled support function of a body: its largest h(u) = u·x and a point where it is reached.

The support function of a Minkowski sum is the sum of the sets' own, and that of a convex hull is
the largest of its points'; an ellipsoid ``c + A x, |x| <= 1`` has h(u) = u·c + |Aᵀ u|. (R. T.
Rockafellar, "Convex Analysis", 1970, section 13.) So no sum is ever formed.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.workspace import CHOSEN

# Reordered and fused sums are allowed, which vector code needs; values that are no numbers are not.
# For these loops alone, which call nothing: a part that is called with and without is compiled
# twice, and in what is inlined the order may be another in a process that compiles than in one
# that reads what the first has kept (tests/graspq/test_compiled_cache.py).
FAST = {"contract", "nsz", "reassoc", "nnan"}
# What a set contributes to a support point: a point k >= 0, ellipsoid k as -2 - k, or this.
ORIGIN = -1


@compiled
def support(u, body, work, vertex):
    """Return the support value of direction u (6,) and write a support point to ``vertex``.

    Row ``CHOSEN`` of the workspace's ``parts`` receives what each set contributes; ``score`` is
    scratch.
    """
    total = _points_support(u, body, work, vertex)
    if body.centres.shape[1] > 0:
        total = _with_ellipsoids(u, body, work, vertex)
    return total


@compiled(fastmath=FAST)
def _points_support(u, body, work, vertex):
    """``support`` without ellipsoids; ``score`` receives how far along u each point lies."""
    points, first_point = body.points, body.first_point
    score = work.score
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    count = first_point.shape[0] - 1
    for k in range(first_point[count]):
        score[k] = (
            u0 * points[0, k]
            + u1 * points[1, k]
            + u2 * points[2, k]
            + u3 * points[3, k]
            + u4 * points[4, k]
            + u5 * points[5, k]
        )
    shift, parts = body.shift, work.parts
    x0, x1, x2, x3, x4, x5 = -shift[0], -shift[1], -shift[2], -shift[3], -shift[4], -shift[5]
    total = u0 * x0 + u1 * x1 + u2 * x2 + u3 * x3 + u4 * x4 + u5 * x5
    for i in range(count):
        best, pick = -np.inf, ORIGIN
        if body.holds_origin:
            best = 0.0
        begin = first_point[i]
        # A slice, whose numbers are not looked at for negative ones.
        own = score[begin : first_point[i + 1]]
        for k in range(own.shape[0]):
            if own[k] > best:
                best, pick = own[k], begin + k
        total += best
        parts[CHOSEN, i] = pick
        # In registers: a sum in memory takes as long as all the rest.
        if pick >= 0:
            x0, x1, x2 = x0 + points[0, pick], x1 + points[1, pick], x2 + points[2, pick]
            x3, x4, x5 = x3 + points[3, pick], x4 + points[4, pick], x5 + points[5, pick]
    vertex[0], vertex[1], vertex[2], vertex[3], vertex[4], vertex[5] = x0, x1, x2, x3, x4, x5
    return total


@compiled
def _with_ellipsoids(u, body, work, vertex):
    """``support`` of all, from the points that were chosen and their scores."""
    parts, total = work.parts, 0.0
    least = 0.0 if body.holds_origin else -np.inf
    for r in range(6):
        vertex[r] = -body.shift[r]
        total -= u[r] * body.shift[r]
    for i in range(body.first_point.shape[0] - 1):
        pick = parts[CHOSEN, i]
        best = work.score[pick] if pick >= 0 else least
        for k in range(body.first_ellipsoid[i], body.first_ellipsoid[i + 1]):
            value = _ellipsoid_support(u, body, k)
            if value > best:
                best, pick = value, -2 - k
        total += best
        parts[CHOSEN, i] = pick
        if pick != ORIGIN:
            add_support_point(u, body, pick, vertex)
    return total


@compiled(fastmath=FAST)
def candidate_support(u, body, work, vertex):
    """``support`` of the candidates alone, without ellipsoids: a lower bound of h(u)."""
    points, shift, parts, candidates = body.points, body.shift, work.parts, work.candidates
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    x0, x1, x2, x3, x4, x5 = -shift[0], -shift[1], -shift[2], -shift[3], -shift[4], -shift[5]
    total = u0 * x0 + u1 * x1 + u2 * x2 + u3 * x3 + u4 * x4 + u5 * x5
    for i in range(body.first_point.shape[0] - 1):
        best, pick = -np.inf, ORIGIN
        if body.holds_origin:
            best = 0.0
        for m in range(1, candidates[i, 0] + 1):
            k = candidates[i, m]
            value = (
                u0 * points[0, k]
                + u1 * points[1, k]
                + u2 * points[2, k]
                + u3 * points[3, k]
                + u4 * points[4, k]
                + u5 * points[5, k]
            )
            if value > best:
                best, pick = value, k
        total += best
        parts[CHOSEN, i] = pick
        if pick >= 0:
            x0, x1, x2 = x0 + points[0, pick], x1 + points[1, pick], x2 + points[2, pick]
            x3, x4, x5 = x3 + points[3, pick], x4 + points[4, pick], x5 + points[5, pick]
    vertex[0], vertex[1], vertex[2], vertex[3], vertex[4], vertex[5] = x0, x1, x2, x3, x4, x5
    return total


@compiled
def remember(work):
    """Make candidates of the points that were chosen last, as far as there is room."""
    candidates = work.candidates
    for i in range(candidates.shape[0]):
        pick, count = work.parts[CHOSEN, i], candidates[i, 0]
        known = pick < 0 or count + 1 == candidates.shape[1]
        for m in range(1, count + 1):
            known = known or candidates[i, m] == pick
        if not known:
            candidates[i, count + 1] = pick
            candidates[i, 0] = count + 1


@compiled
def _ellipsoid_support(u, body, k):
    axes, value, square = body.axes[k], 0.0, 0.0
    for r in range(6):
        value += u[r] * body.centres[r, k]
    for c in range(axes.shape[1]):
        part = 0.0
        for r in range(6):
            part += u[r] * axes[r, c]
        square += part * part
    return value + np.sqrt(square)


@compiled
def add_support_point(u, body, pick, out):
    """Add what a set contributes in direction u, a point or ellipsoid named by ``pick``."""
    if pick >= 0:
        for r in range(6):
            out[r] += body.points[r, pick]
        return
    axes, square = body.axes[-2 - pick], 0.0
    for c in range(axes.shape[1]):
        part = 0.0
        for r in range(6):
            part += u[r] * axes[r, c]
        square += part * part
    length = np.sqrt(square)
    for r in range(6):
        out[r] += body.centres[r, -2 - pick]
    for c in range(axes.shape[1] if length > 0.0 else 0):
        part = 0.0
        for r in range(6):
            part += u[r] * axes[r, c]
        for r in range(6):
            out[r] += axes[r, c] * part / length
