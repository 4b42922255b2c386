"""Compiled: the reach of a task set when contacts share motors."""

from __future__ import annotations

import numpy as np

from graspq._compiled.bounded_simplex import (
    BASIC,
    FAILED,
    INFEASIBLE,
    LOWER,
    OPTIMAL,
    UNBOUNDED,
    UPPER,
    dual,
    primal,
    refactor,
    values,
)
from graspq._compiled.jit import compiled, entry

CAP = 2000
RELAXED = 1e-3


@compiled
def _start(columns, count, basis, inverse, where, lo, hi, x):
    """All slacks basic, everything zero."""
    m = basis.shape[0]
    where[:count] = LOWER
    inverse[:, :] = 0.0
    for r in range(m):
        basis[r] = r
        where[r] = BASIC
        inverse[r, r] = 1.0 if r < 6 else -1.0
        x[r] = 0.0


@compiled
def _cold(columns, count, basis, inverse, where, lo, hi, x):
    """Solve with bounds relaxed around zero, where a start is free, then tighten them."""
    m = basis.shape[0]
    wide_lo, wide_hi = lo.copy(), hi.copy()
    for j in range(m):
        # Unequal margins keep the start from being degenerate.
        margin = RELAXED * (1.0 + 0.1 * ((j * 7) % 13))
        wide_lo[j] = min(lo[j], -margin)
        wide_hi[j] = max(hi[j], margin)
    _start(columns, count, basis, inverse, where, lo, hi, x)
    code = primal(columns, count, basis, inverse, where, wide_lo, wide_hi, x, m, 1.0, CAP)
    if code != OPTIMAL:
        return code
    return dual(columns, count, basis, inverse, where, lo, hi, x, m, 1.0, CAP)


@compiled
def _warm(columns, count, basis, inverse, where, lo, hi, x):
    """Go on from the last task's basis, whose u still supports the set."""
    m = basis.shape[0]
    row, before = -1, 0.0
    for r in range(m):
        if basis[r] == m:
            row = r
    if row < 0:
        return FAILED
    for r in range(m):
        before += inverse[row, r] * columns[r, m]
    if before < 1e-6 or not refactor(columns, basis, inverse):
        return FAILED
    return dual(columns, count, basis, inverse, where, lo, hi, x, m, 1.0, CAP)


@compiled
def _violated(columns, count, y, cones, where, lo, hi, made):
    """Append the cone generator that gains most per unit; return its gain."""
    m = columns.shape[0]
    best, pick = 0.0, -1
    for k in range(cones.shape[0]):
        gain, square = 0.0, 0.0
        for c in range(4):
            part = 0.0
            for r in range(m):
                part -= y[r] * cones[k, r, c]
            if c == 0:
                gain = part
            else:
                square += part * part
        gain += np.sqrt(square)
        if gain > best:
            best, pick = gain, k
    if pick < 0:
        return 0.0
    part, length = np.zeros(3), 0.0
    for c in range(3):
        for r in range(m):
            part[c] -= y[r] * cones[pick, r, c + 1]
        length += part[c] * part[c]
    length = np.sqrt(length)
    for r in range(m):
        value = cones[pick, r, 0]
        for c in range(3):
            if length > 0.0:
                value += cones[pick, r, c + 1] * part[c] / length
        columns[r, count] = value
    where[count], made[count] = LOWER, pick
    lo[count], hi[count] = 0.0, np.inf
    return best


@compiled
def _refine(columns, count, basis, inverse, where, lo, hi, x, goal, sense, cones, tol, made):
    """Add generators of the exact cones until none gains more than ``tol``."""
    m = basis.shape[0]
    y = np.empty(m)
    first = count
    gain = 0.0
    while count < columns.shape[1]:
        row = -1
        for r in range(m):
            if basis[r] == goal:
                row = r
        if row < 0:
            return OPTIMAL, count, 0.0
        for r in range(m):
            y[r] = sense * inverse[row, r]
        gain = _violated(columns, count, y, cones, where, lo, hi, made)
        if gain <= tol:
            return OPTIMAL, count, gain
        count += 1
        code = primal(columns, count, basis, inverse, where, lo, hi, x, goal, sense, CAP)
        if code != OPTIMAL:
            return code, count, gain
        if (count - first) % 25 == 0:
            if not refactor(columns, basis, inverse):
                return FAILED, count, gain
            values(columns, basis, inverse, where, lo, hi, x)
    return FAILED, count, gain


@compiled
def _possible(columns, count, basis, inverse, where, lo, hi, x, cones, tol, made):
    """Whether the exact cones hold any equilibrium; return (code, columns used).

    The motors that must push are scaled from nothing to what they push, as far as it goes;
    the generators found on the way stay in the pool.
    """
    m = basis.shape[0]
    push = m + 1
    near_lo, near_hi = lo.copy(), hi.copy()
    for k in range(6, m):
        least = lo[k] if lo[k] > 0.0 else (hi[k] if hi[k] < 0.0 else 0.0)
        columns[k, push] = -least
        near_lo[k], near_hi[k] = lo[k] - least, hi[k] - least
    near_lo[push], near_hi[push] = 0.0, 1.0
    near_hi[m] = 0.0
    _start(columns, count, basis, inverse, where, near_lo, near_hi, x)
    code = primal(columns, count, basis, inverse, where, near_lo, near_hi, x, push, 1.0, CAP)
    # The scale may leave the basis at its upper bound, where nothing more is to be gained.
    if code == OPTIMAL and where[push] == BASIC:
        code, count, _ = _refine(
            columns, count, basis, inverse, where, near_lo, near_hi, x, push, 1.0, cones, tol, made
        )
    if code == OPTIMAL and where[push] != UPPER:
        scale = 0.0
        for r in range(m):
            if basis[r] == push:
                scale = x[r]
        if scale < 1.0 - 1e-9:
            code = INFEASIBLE
    lo[m + 2 : count] = 0.0
    hi[m + 2 : count] = np.inf
    for k in range(6, m):
        columns[k, push] = 0.0
    return code, count


@compiled
def _reached(basis, x):
    m = basis.shape[0]
    for r in range(m):
        if basis[r] == m:
            return x[r]
    return 0.0


@entry
def reach(
    columns, count, tasks, lengths, lo, hi, cones, tol, smallest, weights, used, slacks, made
):
    """Return (status, value, upper, critical, least, columns used).

    ``tasks`` (6, m) are unit vectors, to be multiplied by ``lengths``; ``value`` is the smallest
    over tasks of the largest q, ``least`` the largest over tasks of the smallest q (when
    ``smallest``). ``weights`` and ``used`` receive the generators' weights at the optimum and
    their columns, by basis row; ``made`` the cone of every column that was added.
    """
    m = columns.shape[0]
    basis, where = np.empty(m, np.int64), np.empty(columns.shape[1], np.int8)
    inverse, x = np.empty((m, m)), np.empty(m)
    value, critical, least, last, upper = np.inf, 0, 0.0, 0, np.inf
    pool = count
    warm = False
    for j in range(tasks.shape[1]):
        for r in range(6):
            columns[r, m] = -tasks[r, j]
        if columns.shape[1] - pool < (columns.shape[1] - count) // 2:
            pool, warm = count, False
        code = FAILED
        if warm:
            code = _warm(columns, pool, basis, inverse, where, lo, hi, x)
            if code == INFEASIBLE and cones.shape[0] > 0:
                code = FAILED
        if code != OPTIMAL:
            code = _cold(columns, pool, basis, inverse, where, lo, hi, x)
        if code == INFEASIBLE and cones.shape[0] > 0:
            code, pool = _possible(
                columns, pool, basis, inverse, where, lo, hi, x, cones, tol, made
            )
            if code == OPTIMAL:
                code = _cold(columns, pool, basis, inverse, where, lo, hi, x)
                if code == INFEASIBLE:
                    code = FAILED
        gain = 0.0
        if code == OPTIMAL and cones.shape[0] > 0:
            code, pool, gain = _refine(
                columns, pool, basis, inverse, where, lo, hi, x, m, 1.0, cones, tol, made
            )
        if code == UNBOUNDED:
            warm = False
            continue
        if code != OPTIMAL or not refactor(columns, basis, inverse):
            return (code if code != OPTIMAL else FAILED), 0.0, 0.0, j, 0.0, pool
        values(columns, basis, inverse, where, lo, hi, x)
        warm = True
        q = _reached(basis, x) / lengths[j]
        if q < value:
            value, critical = q, j
            upper = _bound(basis, inverse, lo, hi, gain, x) / lengths[j]
            slacks[:] = 0.0
            for r in range(m):
                weights[r], used[r] = x[r], basis[r]
                if 6 <= basis[r] < m:
                    slacks[basis[r] - 6] = x[r]
            for k in range(6, m):
                if where[k] != BASIC:
                    slacks[k - 6] = lo[k] if where[k] == LOWER else hi[k]
        if smallest:
            # The way down starts here; the next task starts from here too.
            first = pool
            kept, places, rows = basis.copy(), where.copy(), inverse.copy()
            code = primal(columns, pool, basis, inverse, where, lo, hi, x, m, -1.0, CAP)
            if code == OPTIMAL and cones.shape[0] > 0:
                code, pool, gain = _refine(
                    columns, pool, basis, inverse, where, lo, hi, x, m, -1.0, cones, tol, made
                )
            if code != OPTIMAL:
                return FAILED, 0.0, 0.0, j, 0.0, pool
            if _reached(basis, x) / lengths[j] > least:
                least, last = _reached(basis, x) / lengths[j], j
            places[first:pool] = LOWER
            basis[:], where[:], inverse[:, :] = kept, places, rows
    if least > value * (1.0 + 1e-9) + 1e-9:
        return INFEASIBLE, 0.0, 0.0, last, least, pool
    return OPTIMAL, value, upper, critical, least, pool


@compiled
def _bound(basis, inverse, lo, hi, gain, x):
    """Upper bound on q from the multipliers: what the motors can put in, at most."""
    m = basis.shape[0]
    row = -1
    for r in range(m):
        if basis[r] == m:
            row = r
    if row < 0:
        return 0.0
    total = 0.0
    for k in range(6, m):
        y = inverse[row, k]
        if y != 0.0:
            total += max(y * lo[k], y * hi[k])
    load = 0.0
    for r in range(m):
        if basis[r] > m + 1:
            load += abs(x[r])
    return total + gain * load
