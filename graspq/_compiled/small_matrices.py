"""Compiled: small dense linear algebra."""

from __future__ import annotations

from graspq._compiled.jit import compiled


@compiled
def invert(matrix, scratch, inverse):
    """Invert a square matrix by Gauss-Jordan elimination with partial pivoting.

    ``scratch`` is overwritten. Returns False when the matrix is singular.
    """
    # A size that the compiler does not know keeps it from unrolling these loops.
    n = matrix.shape[0]
    for r in range(n):
        for c in range(n):
            scratch[r, c] = matrix[r, c]
            inverse[r, c] = 1.0 if r == c else 0.0
    for c in range(n):
        p = c
        for r in range(c + 1, n):
            if abs(scratch[r, c]) > abs(scratch[p, c]):
                p = r
        if scratch[p, c] == 0.0:
            return False
        scale = 1.0 / scratch[p, c]
        for k in range(n):
            # Swap the rows and scale the one that stays in place.
            top, own = scratch[p, k], inverse[p, k]
            scratch[p, k], inverse[p, k] = scratch[c, k], inverse[c, k]
            scratch[c, k], inverse[c, k] = scale * top, scale * own
        for r in range(n):
            factor = scratch[r, c]
            if r != c and factor != 0.0:
                for k in range(n):
                    scratch[r, k] -= factor * scratch[c, k]
                    inverse[r, k] -= factor * inverse[c, k]
    return True


@compiled
def dot(a, b):
    """Inner product of two vectors (6,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
