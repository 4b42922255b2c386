"""Compiled bounded simplex for: the largest x_goal with  A x = 0,  lo <= x <= hi.

Columns of A come in this order: m unit columns (six wrench slacks e_i, then motor slacks -e_k),
one for -q t, one that scales the motors' least torques, then the generators of the friction
cones. The inverse of the basis is kept
explicitly: m is a dozen. Everything is in units in which the entries are of size one.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled

OPTIMAL, INFEASIBLE, UNBOUNDED, FAILED = 0, 1, 2, 3
LOWER, UPPER, BASIC = 0, 1, 2
PRICE, FEASIBLE, PIVOT = 1e-11, 1e-11, 1e-9


@compiled(fastmath={"contract", "reassoc", "nsz"})
def times_columns(y, columns, count, out):
    """out = y A over the first ``count`` columns."""
    for j in range(count):
        out[j] = 0.0
    for r in range(columns.shape[0]):
        factor = y[r]
        if factor != 0.0:
            for j in range(count):
                out[j] += factor * columns[r, j]


@compiled
def refactor(columns, basis, inverse):
    """Invert the basis by Gauss-Jordan elimination with pivoting; False when singular."""
    m = basis.shape[0]
    a = np.empty((m, m))
    for r in range(m):
        for c in range(m):
            a[r, c] = columns[r, basis[c]]
            inverse[r, c] = 1.0 if r == c else 0.0
    for c in range(m):
        p = c
        for r in range(c + 1, m):
            if abs(a[r, c]) > abs(a[p, c]):
                p = r
        if abs(a[p, c]) < 1e-13:
            return False
        if p != c:
            for k in range(m):
                a[c, k], a[p, k] = a[p, k], a[c, k]
                inverse[c, k], inverse[p, k] = inverse[p, k], inverse[c, k]
        scale = 1.0 / a[c, c]
        for k in range(m):
            a[c, k] *= scale
            inverse[c, k] *= scale
        for r in range(m):
            factor = a[r, c]
            if r != c and factor != 0.0:
                for k in range(m):
                    a[r, k] -= factor * a[c, k]
                    inverse[r, k] -= factor * inverse[c, k]
    return True


@compiled
def values(columns, basis, inverse, where, lo, hi, x):
    """Recompute the basic values from the slacks that rest on their bounds."""
    m = basis.shape[0]
    rest = np.zeros(m)
    for j in range(m):
        if where[j] != BASIC:
            bound = lo[j] if where[j] == LOWER else hi[j]
            sign = 1.0 if j < 6 else -1.0
            rest[j] -= sign * bound
    for r in range(m):
        total = 0.0
        for c in range(m):
            total += inverse[r, c] * rest[c]
        x[r] = total


@compiled
def exchange(inverse, column, leave):
    """Update the inverse when a column with B⁻¹ a = ``column`` enters at row ``leave``."""
    m = inverse.shape[0]
    scale = 1.0 / column[leave]
    for c in range(m):
        inverse[leave, c] *= scale
    for r in range(m):
        factor = column[r]
        if r != leave and factor != 0.0:
            for c in range(m):
                inverse[r, c] -= factor * inverse[leave, c]


@compiled
def _prices(columns, count, basis, inverse, goal, sense, reduced):
    """Reduced costs of the objective sense·x_goal."""
    m = basis.shape[0]
    row = -1
    for r in range(m):
        if basis[r] == goal:
            row = r
    if row < 0:
        reduced[:count] = 0.0
        reduced[goal] = sense
        return
    times_columns(inverse[row] * (-sense), columns, count, reduced)
    reduced[goal] = 0.0


@compiled
def _column(columns, inverse, j, out):
    m = inverse.shape[0]
    for r in range(m):
        total = 0.0
        for c in range(m):
            total += inverse[r, c] * columns[c, j]
        out[r] = total


@compiled
def primal(columns, count, basis, inverse, where, lo, hi, x, goal, sense, cap):
    """Improve sense·x_goal from a feasible basis."""
    m = basis.shape[0]
    reduced, column = np.empty(columns.shape[1]), np.empty(m)
    stalled = 0
    for step in range(cap):
        if step % 50 == 49:
            if not refactor(columns, basis, inverse):
                return FAILED
            values(columns, basis, inverse, where, lo, hi, x)
        _prices(columns, count, basis, inverse, goal, sense, reduced)
        enter, best = -1, PRICE
        for j in range(count):
            if where[j] == BASIC or lo[j] == hi[j]:
                continue
            gain = reduced[j] if where[j] == LOWER else -reduced[j]
            if gain > best:
                enter, best = j, gain
                if stalled > 40:
                    break
        if enter < 0:
            return OPTIMAL
        sign = 1.0 if where[enter] == LOWER else -1.0
        _column(columns, inverse, enter, column)
        # Two passes: the longest step that breaks no bound by more than a tolerance, then
        # the largest pivot among the rows that block by then.
        longest = hi[enter] - lo[enter]
        flip = longest
        for r in range(m):
            rate = -sign * column[r]
            if rate < -PIVOT:
                longest = min(longest, (x[r] - lo[basis[r]] + FEASIBLE) / -rate)
            elif rate > PIVOT:
                longest = min(longest, (hi[basis[r]] - x[r] + FEASIBLE) / rate)
        if longest == np.inf:
            return UNBOUNDED
        leave, step_size = -1, flip
        for r in range(m):
            rate = -sign * column[r]
            room = np.inf
            if rate < -PIVOT:
                room = (x[r] - lo[basis[r]]) / -rate
            elif rate > PIVOT:
                room = (hi[basis[r]] - x[r]) / rate
            if room <= longest and (leave < 0 or abs(rate) > abs(column[leave])):
                leave, step_size = r, max(room, 0.0)
        stalled = stalled + 1 if step_size <= 1e-14 else 0
        for r in range(m):
            x[r] -= sign * column[r] * step_size
        if leave < 0 or flip < step_size:
            where[enter] = UPPER if where[enter] == LOWER else LOWER
            continue
        start = lo[enter] if where[enter] == LOWER else hi[enter]
        out = basis[leave]
        where[out] = LOWER if -sign * column[leave] < 0.0 else UPPER
        basis[leave] = enter
        where[enter] = BASIC
        exchange(inverse, column, leave)
        x[leave] = start + sign * step_size
    return FAILED


@compiled
def dual(columns, count, basis, inverse, where, lo, hi, x, goal, sense, cap):
    """Restore feasibility while the reduced costs keep their signs."""
    m = basis.shape[0]
    reduced, alpha = np.empty(columns.shape[1]), np.empty(columns.shape[1])
    column = np.empty(m)
    for step in range(cap):
        if step % 50 == 49 and not refactor(columns, basis, inverse):
            return FAILED
        values(columns, basis, inverse, where, lo, hi, x)
        leave, worst, rising = -1, 1e-10, False
        for r in range(m):
            if lo[basis[r]] - x[r] > worst:
                leave, worst, rising = r, lo[basis[r]] - x[r], True
            if x[r] - hi[basis[r]] > worst:
                leave, worst, rising = r, x[r] - hi[basis[r]], False
        if leave < 0:
            return OPTIMAL
        _prices(columns, count, basis, inverse, goal, sense, reduced)
        times_columns(inverse[leave], columns, count, alpha)
        limit = np.inf
        for j in range(count):
            a = alpha[j] if rising else -alpha[j]
            if where[j] == LOWER and a < -PIVOT and lo[j] < hi[j]:
                limit = min(limit, (max(-reduced[j], 0.0) + PRICE) / -a)
            elif where[j] == UPPER and a > PIVOT and lo[j] < hi[j]:
                limit = min(limit, (max(reduced[j], 0.0) + PRICE) / a)
        enter, most = -1, 0.0
        for j in range(count):
            a = alpha[j] if rising else -alpha[j]
            ratio = np.inf
            if where[j] == LOWER and a < -PIVOT and lo[j] < hi[j]:
                ratio = max(-reduced[j], 0.0) / -a
            elif where[j] == UPPER and a > PIVOT and lo[j] < hi[j]:
                ratio = max(reduced[j], 0.0) / a
            if ratio <= limit and ratio < np.inf and abs(a) > most:
                enter, most = j, abs(a)
        if enter < 0:
            return INFEASIBLE
        _column(columns, inverse, enter, column)
        where[basis[leave]] = LOWER if rising else UPPER
        basis[leave] = enter
        where[enter] = BASIC
        exchange(inverse, column, leave)
    return FAILED
