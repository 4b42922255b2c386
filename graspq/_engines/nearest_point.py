"""The point of a polytope nearest to the origin, from what its vertices are in a direction.

P. Wolfe: Finding the nearest point in a polytope, Mathematical Programming 11, 1976. The polytope
is given by a function that finds a vertex farthest in a direction, so that sums of sets need not
be multiplied out; at most d + 2 vertices are kept at a time.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graspq.errors import GraspError

# Of the squared distance, over the largest vertex's squared norm: what is aimed at, and what is
# accepted where round-off lets no further vertex come nearer.
TOLERANCE, ROUND_OFF = 1e-15, 1e-11
# A point this near, over the largest vertex's norm, is the origin: round-off ranks no grasps.
ORIGIN = 1e-12
MOST_ITERATIONS = 5000
# Weights below it are zero.
SMALLEST_WEIGHT = 1e-13


def nearest_point(farthest: Callable[[np.ndarray], np.ndarray], start: np.ndarray) -> np.ndarray:
    """Point of a polytope nearest to the origin (d,).

    Args:
        farthest: for a direction (d,), a vertex (d,) with the largest inner product.
        start: any vertex (d,).

    Raises:
        GraspError: it does not converge.
    """
    vertices, weights = start[None].copy(), np.ones(1)
    point, scale, before = start.copy(), float(start @ start), np.inf
    for _ in range(MOST_ITERATIONS):
        vertex = farthest(-point)
        scale = max(scale, float(vertex @ vertex))
        square = float(point @ point)
        gap = float(point @ (point - vertex))
        if square <= ORIGIN**2 * scale:
            return np.zeros_like(point)
        if gap <= TOLERANCE * scale:
            return point
        if square >= before or (vertices == vertex).all(axis=1).any():
            if gap <= ROUND_OFF * scale:
                return point
            break
        before = square
        vertices, weights = _exchange(np.vstack([vertices, vertex]), np.append(weights, 0.0))
        point = weights @ vertices
    raise GraspError(
        "nearest_point: Wolfe's method does not converge; are the contacts' positions in metres?"
    )


def _exchange(vertices: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Those of the vertices (k, d) whose simplex has its nearest point inside, with its weights.

    Args:
        vertices: (k, d).
        weights: of a point of their simplex, >= 0 (k,); the result is nearer to the origin.
    """
    while True:
        aim = _flat_weights(vertices)
        if (aim > SMALLEST_WEIGHT).all():
            return vertices, aim
        # From the old weights towards the new ones, until the first of them is zero.
        falling = aim <= SMALLEST_WEIGHT
        fall = weights[falling] - aim[falling]
        step = float((weights[falling] / np.where(fall > 0, fall, 1.0)).min())
        weights = weights + min(step, 1.0) * (aim - weights)
        kept = weights > SMALLEST_WEIGHT
        if kept.all():
            kept[np.argmin(weights)] = False
        vertices, weights = vertices[kept], weights[kept] / weights[kept].sum()


def _flat_weights(vertices: np.ndarray) -> np.ndarray:
    """Weights, of either sign and adding up to 1, of the nearest point of the vertices' span."""
    first, others = vertices[0], (vertices[1:] - vertices[0]).T
    found = np.linalg.lstsq(others, -first, rcond=None)[0]
    return np.concatenate([[1.0 - found.sum()], found])
