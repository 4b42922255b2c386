"""Compiled: small dense linear algebra."""

from __future__ import annotations

from graspq._compiled.jit import compiled


@compiled
def invert_in_place(matrix, inverse, least):
    """Write the inverse of ``matrix``, which is overwritten: Gauss-Jordan, partial pivoting.

    Returns False when a pivot is at most ``least`` in magnitude.
    """
    # A size that the compiler does not know keeps it from unrolling these loops.
    n = matrix.shape[0]
    for r in range(n):
        for c in range(n):
            inverse[r, c] = 1.0 if r == c else 0.0
    for c in range(n):
        p = c
        for r in range(c + 1, n):
            if abs(matrix[r, c]) > abs(matrix[p, c]):
                p = r
        if abs(matrix[p, c]) <= least:
            return False
        scale = 1.0 / matrix[p, c]
        for k in range(n):
            # Swap the rows and scale the one that stays in place.
            top, own = matrix[p, k], inverse[p, k]
            matrix[p, k], inverse[p, k] = matrix[c, k], inverse[c, k]
            matrix[c, k], inverse[c, k] = scale * top, scale * own
        for r in range(n):
            factor = matrix[r, c]
            if r != c and factor != 0.0:
                for k in range(n):
                    matrix[r, k] -= factor * matrix[c, k]
                    inverse[r, k] -= factor * inverse[c, k]
    return True


@compiled
def dot(a, b):
    """Inner product of two vectors (6,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
