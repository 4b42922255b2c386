"""Compiled support oracle of a sum of convex hulls of points and ellipsoids.

A body i is the hull of its points ``points[:, starts[i]:starts[i + 1]]``, of its ellipsoids
``{centres[:, k] + axes[k] x : |x| <= 1}`` for k in ``balls[i]:balls[i + 1]`` and, when ``zero``,
of the origin. The set is the Minkowski sum of the bodies less ``shift``.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled

FAST = {"contract", "nsz", "reassoc", "nnan"}


@compiled(fastmath=FAST)
def support(u, points, starts, centres, axes, balls, zero, shift, score, choice, out):
    """Write the support point of direction u to ``out`` and return the support value.

    ``score`` is scratch of size (number of points,); ``choice`` (number of bodies,) receives
    the chosen point k >= 0, -1 for the origin, or -2 - k for ellipsoid k.
    """
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    for k in range(points.shape[1]):
        score[k] = (
            u0 * points[0, k]
            + u1 * points[1, k]
            + u2 * points[2, k]
            + u3 * points[3, k]
            + u4 * points[4, k]
            + u5 * points[5, k]
        )
    total = 0.0
    for r in range(6):
        out[r] = -shift[r]
        total -= u[r] * shift[r]
    for i in range(starts.shape[0] - 1):
        best, pick = -np.inf, -1
        if zero:
            best = 0.0
        # Two plain loops, which become vector code, instead of one that keeps the place.
        top = -np.inf
        for k in range(starts[i], starts[i + 1]):
            top = score[k] if score[k] > top else top
        if top > best:
            best = top
            pick = starts[i]
            while score[pick] != top:
                pick += 1
        for k in range(balls[i], balls[i + 1]):
            value = _ball_value(u, centres, axes, k)
            if value > best:
                best, pick = value, -2 - k
        total += best
        choice[i] = pick
        add_atom(u, points, centres, axes, pick, 1.0, out)
    return total


@compiled
def _ball_value(u, centres, axes, k):
    value, square = 0.0, 0.0
    for r in range(6):
        value += u[r] * centres[r, k]
    for c in range(3):
        part = 0.0
        for r in range(6):
            part += u[r] * axes[k, r, c]
        square += part * part
    return value + np.sqrt(square)


@compiled
def add_atom(u, points, centres, axes, pick, weight, out):
    """Add ``weight`` times the support point that ``pick`` names in direction u to ``out``."""
    if pick >= 0:
        for r in range(6):
            out[r] += weight * points[r, pick]
    elif pick <= -2:
        k = -2 - pick
        part = np.zeros(3)
        square = 0.0
        for c in range(3):
            for r in range(6):
                part[c] += u[r] * axes[k, r, c]
            square += part[c] * part[c]
        length = np.sqrt(square)
        for r in range(6):
            value = centres[r, k]
            if length > 0.0:
                for c in range(3):
                    value += axes[k, r, c] * part[c] / length
            out[r] += weight * value
