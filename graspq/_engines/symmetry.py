"""Rotations that leave a wrench space of ellipsoids as it is.

Sets of revolution, as those of two opposed exact friction cones, touch their largest ball along
whole arcs, which no hull of points closes in on. An antisymmetric G whose rotations exp(t G) take
every set to itself has G c = 0 for every point and centre c, and G M = M G for the shape M = A Aᵀ
of every ellipsoid: linear equations for G. In a plane (e, G e) that G turns, every direction u can
be turned until u·e = 0 without changing h(u). So ε = min h(u) is that of the space projected
along e.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.body import Bodies

# What equations in units of the set may be off by where a rotation leaves it as it is.
SAME = 1e-9
PLANES = [(r, c) for r in range(6) for c in range(r)]


def turned_direction(body: Bodies) -> np.ndarray | None:
    """Return a unit vector e that a rotation of one body onto itself moves, (6,), or None."""
    vectors = np.hstack([body.points, body.centres])
    shapes = body.axes @ body.axes.transpose(0, 2, 1)
    scale = max(float(np.abs(vectors).max(initial=0.0)), 1e-300)
    equations = np.empty((6 * vectors.shape[1] + 36 * len(shapes), len(PLANES)))
    for k, (r, c) in enumerate(PLANES):
        turn = np.zeros((6, 6))
        turn[r, c], turn[c, r] = 1.0, -1.0
        equations[:, k] = np.concatenate(
            [
                (turn @ vectors).ravel() / scale,
                (turn @ shapes - shapes @ turn).ravel() / scale**2,
            ]
        )
    rows = np.linalg.svd(equations, full_matrices=False)[2]
    turn = np.zeros((6, 6))
    for (r, c), value in zip(PLANES, rows[-1], strict=True):
        turn[r, c], turn[c, r] = value, -value
    if np.abs(equations @ rows[-1]).max() > SAME:
        return None
    return np.linalg.eigh(turn.T @ turn)[1][:, -1]
