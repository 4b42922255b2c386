"""Compiled pivots of the revised simplex method whose columns a support function generates.

The linear program is min Σ λ_k subject to Σ λ_k v_k = t over all points v_k of a set, with six of
them in the basis. Primal pivots (G. B. Dantzig, "Linear Programming and Extensions", 1963,
chapters 8 and 9) keep the weights λ non-negative: the support point of u = B⁻ᵀ 1 has the most
negative reduced cost 1 - h(u) and enters, and the ratio test says which vertex leaves. Dual pivots
(C. E. Lemke, 1954) keep the plane u·x = 1 above the set: the vertex of negative weight leaves, and
u is tilted about the other five until the set supports it.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.small_matrices import dot
from graspq._compiled.support_function import candidate_support, remember, support
from graspq._compiled.workspace import (
    CHOSEN,
    KEPT,
    OBJECTIVE,
    VERTEX,
    WEIGHTS,
    WIDTH,
    aim,
    refactor,
)

# An entry of the entering column of less is no place to pivot on; ratios this close are a tie.
LEAST_PIVOT, TIE = 1e-11, 1e-13
# Bodies of more points are asked through a list of candidates first (partial pricing), which must
# gain this much: less may be round-off of a long u about a point that is in the basis.
MANY, LEAST_GAIN = 256, 1e-7
# Share of the best direction so far in the one that is asked along first.
SMOOTHING = 0.4
# Pivots after which the tableau is formed anew, to rid it of round-off.
FRESH_PRIMAL, FRESH_DUAL = 40, 20
# Most tilts of one dual pivot: each is a vertex nearer, and few are needed.
MOST_TILTS = 60
# Along a direction with less of a support value the set does not reach past the origin.
NO_REACH = 1e-12
DONE, UNREACHABLE, CAPPED = 0, 1, 2


@compiled
def enter_column(tableau, vertex, column):
    """Write B⁻¹ times the vertex to ``column``, and what it gains, h(u) - 1, below it."""
    v0, v1, v2, v3, v4, v5 = vertex[0], vertex[1], vertex[2], vertex[3], vertex[4], vertex[5]
    for k in range(WIDTH):
        column[k] = (
            v0 * tableau[0, k]
            + v1 * tableau[1, k]
            + v2 * tableau[2, k]
            + v3 * tableau[3, k]
            + v4 * tableau[4, k]
            + v5 * tableau[5, k]
        )
    column[OBJECTIVE] -= 1.0


@compiled
def _subtract(row, factor, column):
    """Take ``factor`` times the column off a row of the tableau."""
    # All sums before the first is stored: vector code, as none can depend on another.
    x0, x1 = row[0] - factor * column[0], row[1] - factor * column[1]
    x2, x3 = row[2] - factor * column[2], row[3] - factor * column[3]
    x4, x5 = row[4] - factor * column[4], row[5] - factor * column[5]
    x6, x7 = row[6] - factor * column[6], row[7] - factor * column[7]
    row[0], row[1], row[2], row[3] = x0, x1, x2, x3
    row[4], row[5], row[6], row[7] = x4, x5, x6, x7


@compiled
def pivot(work, leave, vertex, direction, which):
    """Exchange basis vertex ``leave`` for ``vertex``, whose entering column is given.

    The direction it supports and what each set contributes to it are kept beside it.
    """
    state = work.state
    tableau, column = state.tableau, state.column
    scale = 1.0 / column[leave]
    for c in range(WEIGHTS + 1):
        factor = tableau[c, leave] * scale
        _subtract(tableau[c], factor, column)
        tableau[c, leave] = factor
    state.kinds[leave] = VERTEX
    for r in range(6):
        state.basis[leave, r] = vertex[r]
        state.directions[leave, r] = direction[r]
    for i in range(work.parts.shape[1]):
        work.parts[leave, i] = work.parts[which, i]


@compiled
def ratio_test(tableau, column, ratios):
    """Basis vertex whose weight reaches zero first, the largest pivot of equals; -1 if none.

    ``ratios`` is scratch, shape (6,).
    """
    # Every quotient before any is looked at: vector code, and no branch that depends on signs.
    for k in range(6):
        ratios[k] = max(tableau[WEIGHTS, k], 0.0) / column[k]
    least = np.inf
    for k in range(6):
        ratio = ratios[k] if column[k] > LEAST_PIVOT else np.inf
        least = ratio if ratio < least else least
    leave, most = -1, LEAST_PIVOT
    for k in range(6):
        if ratios[k] <= least * (1.0 + TIE) and column[k] > most:
            leave, most = k, column[k]
    return leave


@compiled
def _between(u, along, best, out):
    """Write the smoothed direction between u and the best, each over what it has along the task."""
    rest = (1.0 - SMOOTHING) / along
    for c in range(6):
        out[c] = SMOOTHING * best[c] + rest * u[c]


@compiled
def _note_best(upper, direction, scale, best):
    """Keep a direction, times ``scale``, whose bound ``upper`` is the least; return the bound."""
    for c in range(6):
        best[c] = scale * direction[c]
    return upper


@compiled
def primal(work, body, target, task, stop, cap, cold):
    """Pivot until no point of the set improves ``target``; return (solved, upper bound on q).

    The bound h(u) / u·task holds for ``task`` with every u on the way. From a ``cold`` start u
    jumps about at first; the support point of a direction between it and the best so far takes
    fewer pivots, until one gains nothing (P. Wentges, "Weighted Dantzig-Wolfe decomposition for
    linear mixed-integer programming", International Transactions in Operational Research 4, 1997).
    """
    state = work.state
    tableau, u, vertex, column = state.tableau, state.u, state.vertex, state.column
    best, between = state.best, state.between
    columns = body.first_point[body.first_point.shape[0] - 1]
    polytope = body.centres.shape[1] == 0
    many = polytope and columns > MANY
    # Vertices of a smooth set that are found so lie too close together for accurate weights.
    smoothed = polytope and cold and not many
    aim(tableau, target)
    upper = np.inf
    for step in range(1, cap):
        if step % FRESH_PRIMAL == 0 and not refactor(state, target):
            return False, upper
        for c in range(6):
            u[c] = tableau[c, OBJECTIVE]
        along = dot(u, task)
        gain, asked = -np.inf, u
        if many:
            gain = candidate_support(u, body, work, vertex)
        elif smoothed and upper < np.inf and along > 0.0:
            _between(u, along, best, between)
            bound, asked = support(between, body, work, vertex), between
            if bound < upper:
                upper = _note_best(bound, between, 1.0, best)
            gain = dot(u, vertex)
            smoothed = gain > 1.0 + LEAST_GAIN
        if gain <= 1.0 + LEAST_GAIN:
            h, asked = support(u, body, work, vertex), u
            if many:
                remember(work)
            if along > 0.0 and h < upper * along:
                upper = _note_best(h / along, u, 1.0 / along, best)
            if h <= 1.0 + stop:
                return True, upper
        enter_column(tableau, vertex, column)
        leave = ratio_test(tableau, column, state.row)
        if leave < 0:
            return False, upper
        pivot(work, leave, vertex, asked, CHOSEN)
    return False, upper


@compiled
def _keep(parts):
    for i in range(parts.shape[1]):
        parts[KEPT, i] = parts[CHOSEN, i]


@compiled
def dual(work, body, task, stop, cap):
    """Make the weights of ``task`` non-negative while the plane stays above the set.

    Returns ``DONE``, ``UNREACHABLE`` when no weights exist, or ``CAPPED``.
    """
    state = work.state
    tableau, u, vertex, column = state.tableau, state.u, state.vertex, state.column
    row, tilted, direction, nearer = state.row, state.tilted, state.direction, state.nearer
    for step in range(1, cap):
        if step % FRESH_DUAL == 0 and not refactor(state, task):
            return CAPPED
        aim(tableau, task)
        leave, worst, total = -1, 0.0, 0.0
        for k in range(6):
            weight = tableau[WEIGHTS, k]
            total += abs(weight)
            if weight < worst:
                leave, worst = k, weight
        # A negative weight within round-off of the sum it comes from is none.
        noise = 1e-13 * total
        for c in range(6 if leave >= 0 else 0):
            noise = max(noise, 1e-15 * abs(tableau[c, leave] * task[c]))
        if worst >= -noise:
            return DONE
        for c in range(6):
            u[c] = tableau[c, OBJECTIVE]
            row[c] = tableau[c, leave]
            tilted[c] = -row[c]
        h = support(tilted, body, work, vertex)
        if h <= NO_REACH:
            return UNREACHABLE
        _keep(work.parts)
        for _ in range(MOST_TILTS):
            # Tilt u about the five other vertices until it supports the vertex found last.
            angle = max(1.0 - dot(u, vertex), 0.0) / -dot(row, vertex)
            for c in range(6):
                direction[c] = tilted[c]
                tilted[c] = u[c] - angle * row[c]
            h = support(tilted, body, work, nearer)
            if h <= 1.0 + stop or -dot(row, nearer) <= NO_REACH:
                break
            for c in range(6):
                vertex[c] = nearer[c]
            _keep(work.parts)
        enter_column(tableau, vertex, column)
        if column[leave] > -LEAST_PIVOT:
            return CAPPED
        pivot(work, leave, vertex, direction, KEPT)
    return CAPPED
