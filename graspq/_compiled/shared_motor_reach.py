"""How far every task of a set can be scaled when contacts share motors.

One linear program per task: the largest q with A x = 0 within bounds (``bounded_simplex``), whose
columns are

    0 ... 5        slacks of the wrench, fixed at 0
    6 ... m - 1    slacks of the motors and passive motions, between the bounds of their loads
    m              q, the task wrench times -1
    m + 1          the share of the torques that the motors must at least bear (first phase)
    m + 2 ...      edges of the friction cones and preloads, >= 0

Tasks differ in column m alone, so the basis of one stays dual feasible for the next, which takes a
few dual steps. Exact cones are spanned by edges that are added where the multipliers ask for them:
column generation (Gilmore and Gomory: A linear programming approach to the cutting stock problem,
1961; Kelley: The cutting-plane method, 1960, in the dual).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.bounded_simplex import (
    BASIC,
    FAILED,
    INFEASIBLE,
    LOWER,
    OPTIMAL,
    UNBOUNDED,
    UPPER,
    Simplex,
    dual,
    find_values,
    primal,
    refactor,
    row_of,
    simplex_for,
)
from graspq._compiled.jit import compiled, entry

# Stages of a task: go on from the last task's basis by dual steps; or start anew with bounds
# relaxed around zero, where doing nothing is feasible, and restore them by dual steps; when that
# fails with exact cones, scale the torques that the motors must bear from nothing to all of them,
# which adds the edges that it takes; add edges for the largest scale; note it; go for the smallest.
# Plain numbers are types of their own, for which Numba compiles once more.
ZERO = np.int64(0)
NEXT, START, RESTORE, SHARE, LARGEST, RECORD, SMALLEST, DONE = range(8)
# Bounds are relaxed to at least this, times 1 to 2.2: unequal, so that the start is not degenerate.
RELAXED = 1e-3
# A task that the last task's multipliers see less than this starts anew.
SEEN = 1e-6
# Edges are added until the next would gain less than this per unit of normal force.
EDGE_GAIN = 1e-11
# Edges between two inversions of the basis.
REFACTOR_EDGES = 25
# Scales compare as equal within this share.
SAME_SCALE = 1e-9


class Hand(NamedTuple):
    """The bounds, the tasks, the exact cones, and memory.

    Attributes:
        lower, upper: bounds of every column, (N,).
        relaxed_lower, relaxed_upper: memory for other bounds, (N,).
        tasks: unit wrenches, (6, j), and their ``lengths``, (j,).
        cones: exact cones per unit normal force, (K, m, 4); K = 0 when edges span them.
        made: cone of every column that was added, (N,).
        multipliers: memory for y, (m,), and for a direction in a cone, ``side`` (3,).
        best_basis, best_values: basis and values of the critical task, (m,).
        kept: the simplex's state before it went for the smallest scale.
    """

    lower: np.ndarray
    upper: np.ndarray
    relaxed_lower: np.ndarray
    relaxed_upper: np.ndarray
    tasks: np.ndarray
    lengths: np.ndarray
    cones: np.ndarray
    made: np.ndarray
    multipliers: np.ndarray
    side: np.ndarray
    best_basis: np.ndarray
    best_values: np.ndarray
    kept_basis: np.ndarray
    kept_status: np.ndarray
    kept_inverse: np.ndarray


def hand_for(
    columns: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    tasks: np.ndarray,
    lengths: np.ndarray,
    cones: np.ndarray,
) -> tuple[Simplex, Hand]:
    """The program and its memory, for ``reach``."""
    lp = simplex_for(columns)
    hand = Hand(
        lower,
        upper,
        lower.copy(),
        upper.copy(),
        np.ascontiguousarray(tasks),
        lengths,
        cones,
        np.zeros(columns.shape[1], np.int64),
        np.zeros(len(columns)),
        np.zeros(3),
        lp.basis.copy(),
        lp.values.copy(),
        lp.basis.copy(),
        lp.status.copy(),
        lp.inverse.copy(),
    )
    return lp, hand


@compiled
def _begin(lp, hand, count, stage):
    """Start a stage from all slacks basic and every value 0, with bounds that allow it."""
    low, high = hand.relaxed_lower, hand.relaxed_upper
    m = lp.basis.shape[0]
    for j in range(count):
        low[j], high[j], lp.status[j] = hand.lower[j], hand.upper[j], LOWER
    for r in range(m):
        for c in range(m):
            lp.inverse[r, c] = 0.0
        lp.inverse[r, r] = 1.0 if r < 6 else -1.0
        lp.basis[r], lp.status[r], lp.values[r] = r, BASIC, 0.0
        if stage == START:
            margin = RELAXED * (1.0 + 0.1 * ((r * 7) % 13))
            low[r], high[r] = min(low[r], -margin), max(high[r], margin)
        elif r >= 6:
            least = low[r] if low[r] > 0.0 else (high[r] if high[r] < 0.0 else 0.0)
            lp.columns[r, m + 1] = -least
            low[r], high[r] = low[r] - least, high[r] - least
    if stage == SHARE:
        low[m + 1], high[m + 1], high[m] = 0.0, 1.0, 0.0


@compiled
def _end_share(lp, hand, count):
    """Whether the motors can bear all that they must; take the share out of the program."""
    m = lp.basis.shape[0]
    row = row_of(lp.basis, m + 1)
    share = lp.values[row] if row >= 0 else 0.0
    for j in range(m + 2, count):
        hand.lower[j], hand.upper[j] = 0.0, np.inf
    for k in range(6, m):
        lp.columns[k, m + 1] = 0.0
    return share >= 1.0 - SAME_SCALE or lp.status[m + 1] == UPPER


@compiled
def _sees_task(lp):
    """Whether the last task's multipliers see the task in column m well enough to go on."""
    m = lp.basis.shape[0]
    row, seen = row_of(lp.basis, m), 0.0
    if row < 0:
        return False
    for r in range(m):
        seen += lp.inverse[row, r] * lp.columns[r, m]
    return seen >= SEEN


@compiled
def _add_edge(lp, hand, low, high, count, row, sense):
    """Append the edge of an exact cone that gains most per normal force; return its gain."""
    cones, y, side = hand.cones, hand.multipliers, hand.side
    m = lp.basis.shape[0]
    for r in range(m):
        y[r] = sense * lp.inverse[row, r]
    best, pick = 0.0, -1
    for k in range(cones.shape[0]):
        gain, square = 0.0, 0.0
        for c in range(4):
            along = 0.0
            for r in range(m):
                along -= y[r] * cones[k, r, c]
            if c == 0:
                gain = along
            else:
                square += along * along
        gain += np.sqrt(square)
        if gain > best:
            best, pick = gain, k
    if pick < 0:
        return 0.0
    length = 0.0
    for c in range(3):
        side[c] = 0.0
        for r in range(m):
            side[c] -= y[r] * cones[pick, r, c + 1]
        length += side[c] * side[c]
    length = np.sqrt(length)
    for r in range(m):
        value = cones[pick, r, 0]
        for c in range(3):
            if length > 0.0:
                value += cones[pick, r, c + 1] * side[c] / length
        lp.columns[r, count] = value
    lp.status[count], hand.made[count] = LOWER, pick
    low[count], high[count] = 0.0, np.inf
    return best


@compiled
def _upper_bound(lp, hand, gain):
    """Upper bound on q from the multipliers: the most that motors can put in, and missing edges."""
    m, total, load = lp.basis.shape[0], 0.0, 0.0
    row = row_of(lp.basis, m)
    if row < 0:
        return 0.0
    for k in range(6, m):
        y = lp.inverse[row, k]
        if y != 0.0:
            total += max(y * hand.lower[k], y * hand.upper[k])
    for r in range(m):
        if lp.basis[r] > m + 1:
            load += abs(lp.values[r])
    return total + gain * load


@compiled
def _copy_state(count, basis, status, inverse, to_basis, to_status, to_inverse):
    """Copy a basis, where ``count`` columns rest, and the inverse."""
    for j in range(count):
        to_status[j] = status[j]
    for r in range(basis.shape[0]):
        to_basis[r] = basis[r]
        for c in range(basis.shape[0]):
            to_inverse[r, c] = inverse[r, c]


@compiled
def _next_stage(stage, code, may_share):
    """What follows a stage that ended with a code; DONE when nothing does."""
    if stage == NEXT:
        return RECORD if code == OPTIMAL else START
    if stage == START:
        return RESTORE if code == OPTIMAL else DONE
    if stage == RESTORE and code == INFEASIBLE and may_share:
        return SHARE
    if stage == SHARE:
        return START if code == OPTIMAL else DONE
    return RECORD if code == OPTIMAL and stage != SMALLEST else DONE


@entry
def reach(lp, hand, count, smallest):
    """Return (status, value, upper, critical, least) for a program of ``count`` columns.

    ``value`` is the smallest over tasks of the largest q, ``least`` the largest over tasks of the
    smallest q (when ``smallest``). ``hand.best_values`` and ``best_basis`` receive the values at
    the optimum and their columns, by row.
    """
    basis, status, inverse, exact = lp.basis, lp.status, lp.inverse, hand.cones.shape[0] > 0
    m, width = lp.columns.shape
    value, critical, least, last, upper = np.inf, 0, 0.0, 0, np.inf
    pool, go_on = count, False
    for j in range(hand.tasks.shape[1]):
        for r in range(6):
            lp.columns[r, m] = -hand.tasks[r, j]
        if width - pool < (width - count) // 2:
            pool, go_on = count, False
        stage, code, gain, added, tried, before = ZERO + START, FAILED, 0.0, 0, False, pool
        if go_on and _sees_task(lp) and refactor(lp):
            stage = NEXT
        else:
            _begin(lp, hand, pool, stage)
        while stage != DONE:
            low, high = hand.lower, hand.upper
            if stage in (START, SHARE):
                low, high = hand.relaxed_lower, hand.relaxed_upper
            goal, sense = (m + 1 if stage == SHARE else m), (-1.0 if stage == SMALLEST else 1.0)
            if stage in (NEXT, RESTORE):
                code = dual(lp, low, high, pool, goal, sense)
            else:
                code = primal(lp, low, high, pool, goal, sense)
            row = row_of(basis, goal)
            gain = 0.0
            if exact and code == OPTIMAL and stage != START and row >= 0:
                if added > 0 and added % REFACTOR_EDGES == 0:
                    if not refactor(lp):
                        return FAILED, 0.0, 0.0, j, 0.0
                    find_values(lp, low, high)
                if pool == width:
                    return FAILED, 0.0, 0.0, j, 0.0
                gain = _add_edge(lp, hand, low, high, pool, row, sense)
                if gain > EDGE_GAIN:
                    pool, added = pool + 1, added + 1
                    stage = LARGEST if stage in (NEXT, RESTORE) else stage
                    continue
            added = 0
            if stage == SHARE:
                good = _end_share(lp, hand, pool)
                code = INFEASIBLE if code == OPTIMAL and not good else code
            elif stage == SMALLEST:
                q = (lp.values[row] if row >= 0 else 0.0) / hand.lengths[j]
                if q > least:
                    least, last = q, j
                _copy_state(
                    before, hand.kept_basis, hand.kept_status, hand.kept_inverse,
                    basis, status, inverse,
                )  # fmt: skip
                for k in range(before, pool):
                    status[k] = LOWER
            stage = _next_stage(stage, code, exact and not tried)
            if stage in (START, SHARE):
                tried = tried or stage == SHARE
                _begin(lp, hand, pool, stage)
            if stage == RECORD:
                if not refactor(lp):
                    return FAILED, 0.0, 0.0, j, 0.0
                find_values(lp, hand.lower, hand.upper)
                row = row_of(basis, m)
                q = (lp.values[row] if row >= 0 else 0.0) / hand.lengths[j]
                if q < value:
                    value, critical = q, j
                    upper = _upper_bound(lp, hand, gain) / hand.lengths[j]
                    for r in range(m):
                        hand.best_values[r], hand.best_basis[r] = lp.values[r], basis[r]
                stage = SMALLEST if smallest else DONE
                if smallest:
                    before = pool
                    _copy_state(
                        before, basis, status, inverse,
                        hand.kept_basis, hand.kept_status, hand.kept_inverse,
                    )  # fmt: skip
        if code == INFEASIBLE and tried and stage != DONE:
            code = FAILED
        if code != OPTIMAL and code != UNBOUNDED:
            return code, 0.0, 0.0, j, 0.0
        go_on = code == OPTIMAL
    if least > value * (1.0 + SAME_SCALE) + SAME_SCALE:
        return INFEASIBLE, 0.0, 0.0, last, least
    return OPTIMAL, value, upper, critical, least
