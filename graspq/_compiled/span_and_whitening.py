"""Compiled: whether a wrench space spans all six directions, its inner point, a round image."""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry
from graspq._compiled.ray_shooting import extent
from graspq._compiled.support_function import FAST


@compiled
def _add(scatter, x):
    for r in range(x.shape[0]):
        for c in range(r + 1):
            scatter[r, c] += x[r] * x[c]


@compiled(fastmath=FAST)
def _row_total(points, r, begin, end):
    total = 0.0
    for k in range(begin, end):
        total += points[r, k]
    return total


@compiled(fastmath=FAST)
def _scatter(scatter, points, begin, end, stride, mean, size):
    """Add the products of every stride-th point, row by row."""
    for r in range(size.shape[0]):
        for c in range(r + 1):
            total, a, b = 0.0, mean[r], mean[c]
            for k in range(begin, end, stride):
                total += (points[r, k] - a) * (points[c, k] - b)
            scatter[r, c] += total / (size[r] * size[c])


@entry
def spread(body, inner, size, scatter):
    """``spread_of`` a few points of every body, and of all where those seem flat."""
    pivot = 0.0
    for thin in (True, False):
        if pivot == 0.0:
            pivot = spread_of(body, inner, size, scatter, thin)
    return pivot


@compiled
def spread_of(body, inner, size, scatter, thin):
    """Write a relative inner point, the extent and the scatter; return the smallest pivot.

    The scatter matrix of the atoms (about each body's mean when the origin is no vertex) is
    in units of ``size``; a pivot below 1e-14 of the largest is round-off, or nearly so, and
    is returned as 0.
    """
    points, starts, centres, axes, balls, zero, _ = body
    extent(body, size)
    scatter[:, :] = 0.0
    inner[:] = 0.0
    x, mean = np.empty(6), np.empty(6)
    for i in range(starts.shape[0] - 1):
        count = starts[i + 1] - starts[i] + balls[i + 1] - balls[i]
        for r in range(size.shape[0]):
            total = _row_total(points, r, starts[i], starts[i + 1])
            for k in range(balls[i], balls[i + 1]):
                total += centres[r, k]
            mean[r] = total / (count + 1 if zero else count)
            inner[r] += mean[r]
        if zero:
            mean[:] = 0.0
        stride = 1 + (starts[i + 1] - starts[i]) // 64 if thin else 1
        _scatter(scatter, points, starts[i], starts[i + 1], stride, mean, size)
        for k in range(balls[i], balls[i + 1]):
            for r in range(size.shape[0]):
                x[r] = (centres[r, k] - mean[r]) / size[r]
            _add(scatter, x)
            for c in range(3):
                for r in range(size.shape[0]):
                    x[r] = axes[k, r, c] / size[r]
                _add(scatter, x)
    return _smallest_pivot(scatter)


@compiled
def _smallest_pivot(scatter):
    a = scatter.copy()
    used = np.zeros(6, np.bool_)
    first = 0.0
    pivot = 0.0
    for step in range(a.shape[0]):
        p = -1
        for r in range(a.shape[0]):
            if not used[r] and (p < 0 or a[r, r] > a[p, p]):
                p = r
        pivot = a[p, p]
        if step == 0:
            first = pivot
        if not pivot > max(1e-14 * first, 1e-26):
            return 0.0
        used[p] = True
        for r in range(a.shape[0]):
            for c in range(r + 1):
                if not used[r] and not used[c]:
                    rp = a[r, p] if r >= p else a[p, r]
                    cp = a[c, p] if c >= p else a[p, c]
                    a[r, c] -= rp * cp / pivot
    return pivot / first


@compiled
def whiten(scatter, size, turn):
    """Write the map that makes a set of this scatter (lower half, in units of size) round."""
    low = np.zeros((6, 6))
    for r in range(size.shape[0]):
        for c in range(r + 1):
            total = scatter[r, c]
            for k in range(c):
                total -= low[r, k] * low[c, k]
            if r == c:
                low[r, r] = np.sqrt(max(total, 1e-15 * scatter[r, r]))
            else:
                low[r, c] = total / low[c, c]
    turn[:, :] = 0.0
    for c in range(size.shape[0]):
        turn[c, c] = 1.0 / low[c, c]
        for r in range(c + 1, size.shape[0]):
            total = 0.0
            for k in range(c, r):
                total -= low[r, k] * turn[k, c]
            turn[r, c] = total / low[r, r]
    for r in range(size.shape[0]):
        for c in range(size.shape[0]):
            turn[r, c] /= size[c]


@compiled
def whitened(body, turn):
    """The body in turned coordinates; ``turn`` is scaled so that its rows' extents are 1."""
    points, starts, centres, axes, balls, zero, shift = body
    columns, round_ = points.shape[1], centres.shape[1]
    moved, middles = np.zeros(points.shape), np.zeros(centres.shape)
    sides, away = np.zeros(axes.shape), np.zeros(6)
    for r in range(turn.shape[0]):
        for c in range(turn.shape[0]):
            factor = turn[r, c]
            if factor == 0.0:
                continue
            away[r] += factor * shift[c]
            for k in range(columns):
                moved[r, k] += factor * points[c, k]
            for k in range(round_):
                middles[r, k] += factor * centres[c, k]
                for i in range(3):
                    sides[k, r, i] += factor * axes[k, c, i]
    for r in range(turn.shape[0]):
        big = 0.0
        for k in range(columns):
            big = max(big, abs(moved[r, k]))
        for k in range(round_):
            big = max(big, abs(middles[r, k]))
            for c in range(3):
                big = max(big, abs(sides[k, r, c]))
        moved[r] /= big
        middles[r] /= big
        turn[r] /= big
        away[r] /= big
        for k in range(sides.shape[0]):
            sides[k, r] /= big
    return moved, starts, middles, sides, balls, zero, away
