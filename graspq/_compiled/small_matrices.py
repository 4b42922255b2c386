"""Small dense linear algebra inside compiled code."""

from __future__ import annotations

from graspq._compiled.jit import compiled


@compiled
def invert(matrix, inverse):
    """Invert a 6×6 matrix by Gauss-Jordan elimination with pivoting; False when singular."""
    # A size that the compiler does not know keeps it from unrolling this at every call.
    a, n = matrix.copy(), matrix.shape[0]
    inverse[:, :] = 0.0
    for r in range(n):
        inverse[r, r] = 1.0
    for c in range(n):
        p = c
        for r in range(c + 1, n):
            if abs(a[r, c]) > abs(a[p, c]):
                p = r
        if a[p, c] == 0.0:
            return False
        if p != c:
            for k in range(n):
                a[c, k], a[p, k] = a[p, k], a[c, k]
                inverse[c, k], inverse[p, k] = inverse[p, k], inverse[c, k]
        scale = 1.0 / a[c, c]
        for k in range(n):
            a[c, k] *= scale
            inverse[c, k] *= scale
        for r in range(n):
            if r != c:
                factor = a[r, c]
                if factor != 0.0:
                    for k in range(n):
                        a[r, k] -= factor * a[c, k]
                        inverse[r, k] -= factor * inverse[c, k]
    return True


@compiled
def times(inverse, vector, out):
    for r in range(6):
        total = 0.0
        for c in range(6):
            total += inverse[r, c] * vector[c]
        out[r] = total


@compiled
def row_sum(inverse, u):
    for c in range(6):
        u[c] = (
            inverse[0, c]
            + inverse[1, c]
            + inverse[2, c]
            + inverse[3, c]
            + inverse[4, c]
            + inverse[5, c]
        )


@compiled
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
