"""The simplex method with bounded variables, for the largest (or smallest) x_goal of

    A x = 0,    lower <= x <= upper.

A column that is not basic rests at its lower or its upper bound (Dantzig: Upper bounds, secondary
constraints, and block triangularity in linear programming, 1955; Chvátal: Linear Programming, 1983,
chapter 8). The entering column is the one with the best reduced cost, or the first that improves
after a row of degenerate steps, as in Bland's rule against cycling (New finite pivoting rules for
the simplex method, 1977). The ratio test has two passes: how far the step goes when every bound may
be missed by a tolerance, then the largest pivot among the rows that block by then (Harris: Pivot
selection methods of the Devex LP code, 1973). A column that reaches its other bound first flips
there, without a pivot. The dual method restores bounds while the reduced costs keep their signs.

The inverse of the basis is kept as such, since m is a dozen. Entries of A are about one in size;
its first m columns are the slacks: e_r for the first six rows, -e_r for those after.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.small_matrices import invert_in_place

OPTIMAL, INFEASIBLE, UNBOUNDED, FAILED = 0, 1, 2, 3
# Where a column rests.
LOWER, UPPER, BASIC = 0, 1, 2
# Reduced costs below the first are 0; bounds may be missed by the second in a ratio test; the third
# is the smallest pivot, below which a direction does not move a row.
REDUCED_COST, FEASIBLE, PIVOT = 1e-11, 1e-11, 1e-9
# The dual method ends when no bound is missed by more than this: above the ratio tests' tolerance.
RESTORED = 1e-10
# Pivots below this make a basis singular.
SINGULAR = 1e-13
# Steps shorter than this are degenerate; after so many of them the first column enters.
DEGENERATE, PATIENCE = 1e-14, 40
# The inverse is computed anew after so many steps. Solutions take a few dozen.
REFACTOR_EVERY, MOST_STEPS = 50, 2000
# A row that starts from a plain -1 has a type of its own, for which Numba compiles once more.
NONE = np.int64(-1)


class Simplex(NamedTuple):
    """The columns, a basis, and memory for a step.

    Attributes:
        columns: A, shape (m, N), of which the first ``count`` columns are in use.
        basis: column of every row, (m,).
        status: where every column rests: LOWER, UPPER or BASIC, (N,).
        inverse: inverse of the basis, (m, m).
        values: values of the basic columns, (m,).
        reduced: reduced costs, (N,).
        pivot_row: row of B⁻¹ A, (N,).
        direction: B⁻¹ a of the entering column, (m,); also what the columns at bounds add up to.
        scratch: the basis while it is inverted, (m, m).
    """

    columns: np.ndarray
    basis: np.ndarray
    status: np.ndarray
    inverse: np.ndarray
    values: np.ndarray
    reduced: np.ndarray
    pivot_row: np.ndarray
    direction: np.ndarray
    scratch: np.ndarray


def simplex_for(columns: np.ndarray) -> Simplex:
    """Memory for a program with these columns, (m, N)."""
    m, width = columns.shape
    return Simplex(
        columns,
        np.zeros(m, np.int64),
        np.zeros(width, np.int8),
        np.zeros((m, m)),
        np.zeros(m),
        np.zeros(width),
        np.zeros(width),
        np.zeros(m),
        np.zeros((m, m)),
    )


@compiled
def row_of(basis, j):
    """The row in which column j is basic, or -1."""
    row = NONE
    for r in range(basis.shape[0]):
        if basis[r] == j:
            row = r
    return row


@compiled(fastmath={"contract", "reassoc", "nsz"})
def combine_rows(inverse, row, factor, columns, count, out):
    """out = factor · (row of the inverse) A, over the first ``count`` columns."""
    for j in range(count):
        out[j] = 0.0
    for r in range(columns.shape[0]):
        weight = factor * inverse[row, r]
        if weight != 0.0:
            for j in range(count):
                out[j] += weight * columns[r, j]


@compiled
def refactor(lp):
    """Invert the basis; False when it is singular."""
    m = lp.scratch.shape[0]
    for r in range(m):
        for c in range(m):
            lp.scratch[r, c] = lp.columns[r, lp.basis[c]]
    return invert_in_place(lp.scratch, lp.inverse, SINGULAR)


@compiled
def find_values(lp, lower, upper):
    """Basic values from the slacks that rest at their bounds; other columns rest at 0."""
    m = lp.basis.shape[0]
    for j in range(m):
        bound = 0.0
        if lp.status[j] != BASIC:
            bound = lower[j] if lp.status[j] == LOWER else upper[j]
        lp.direction[j] = -bound if j < 6 else bound
    for r in range(m):
        total = 0.0
        for c in range(m):
            total += lp.inverse[r, c] * lp.direction[c]
        lp.values[r] = total


@compiled
def find_reduced_costs(lp, count, goal, sense):
    """Reduced costs of the objective sense·x_goal."""
    row = row_of(lp.basis, goal)
    if row < 0:
        for j in range(count):
            lp.reduced[j] = 0.0
        lp.reduced[goal] = sense
        return
    combine_rows(lp.inverse, row, -sense, lp.columns, count, lp.reduced)
    lp.reduced[goal] = 0.0


@compiled
def find_direction(lp, j):
    """How the basic values fall when column j rises: B⁻¹ a_j."""
    m = lp.basis.shape[0]
    for r in range(m):
        total = 0.0
        for c in range(m):
            total += lp.inverse[r, c] * lp.columns[c, j]
        lp.direction[r] = total


@compiled
def pivot(lp, enter, leave, bound):
    """Let a column enter at row ``leave``, whose column comes to rest at a bound."""
    inverse, direction = lp.inverse, lp.direction
    m = inverse.shape[0]
    lp.status[lp.basis[leave]] = bound
    lp.basis[leave] = enter
    lp.status[enter] = BASIC
    scale = 1.0 / direction[leave]
    for c in range(m):
        inverse[leave, c] *= scale
    for r in range(m):
        factor = direction[r]
        if r != leave and factor != 0.0:
            for c in range(m):
                inverse[r, c] -= factor * inverse[leave, c]


@compiled
def primal(lp, lower, upper, count, goal, sense):
    """Improve sense·x_goal from a feasible basis."""
    basis, status, values, direction = lp.basis, lp.status, lp.values, lp.direction
    m, degenerate = basis.shape[0], 0
    for step in range(1, MOST_STEPS + 1):
        if step % REFACTOR_EVERY == 0:
            if not refactor(lp):
                return FAILED
            find_values(lp, lower, upper)
        find_reduced_costs(lp, count, goal, sense)
        enter, best = NONE, REDUCED_COST
        for j in range(count):
            if status[j] == BASIC or lower[j] == upper[j]:
                continue
            gain = lp.reduced[j] if status[j] == LOWER else -lp.reduced[j]
            if gain > best:
                enter, best = j, gain
                if degenerate > PATIENCE:
                    break
        if enter < 0:
            return OPTIMAL
        sign = 1.0 if status[enter] == LOWER else -1.0
        find_direction(lp, enter)
        flip = upper[enter] - lower[enter]
        longest = flip
        for r in range(m):
            rate = -sign * direction[r]
            if rate < -PIVOT:
                longest = min(longest, (values[r] - lower[basis[r]] + FEASIBLE) / -rate)
            elif rate > PIVOT:
                longest = min(longest, (upper[basis[r]] - values[r] + FEASIBLE) / rate)
        if longest == np.inf:
            return UNBOUNDED
        leave, length = NONE, flip
        for r in range(m):
            rate, room = -sign * direction[r], np.inf
            if rate < -PIVOT:
                room = (values[r] - lower[basis[r]]) / -rate
            elif rate > PIVOT:
                room = (upper[basis[r]] - values[r]) / rate
            if room <= longest and (leave < 0 or abs(rate) > abs(direction[leave])):
                leave, length = r, max(room, 0.0)
        degenerate = degenerate + 1 if length <= DEGENERATE else 0
        for r in range(m):
            values[r] -= sign * direction[r] * length
        if leave < 0 or flip < length:
            status[enter] = UPPER if status[enter] == LOWER else LOWER
            continue
        start = lower[enter] if status[enter] == LOWER else upper[enter]
        pivot(lp, enter, leave, LOWER if -sign * direction[leave] < 0.0 else UPPER)
        values[leave] = start + sign * length
    return FAILED


@compiled
def dual(lp, lower, upper, count, goal, sense):
    """Restore bounds that basic values miss, while the reduced costs keep their signs."""
    basis, status, values = lp.basis, lp.status, lp.values
    for step in range(1, MOST_STEPS + 1):
        if step % REFACTOR_EVERY == 0 and not refactor(lp):
            return FAILED
        find_values(lp, lower, upper)
        leave, worst, rising = NONE, RESTORED, False
        for r in range(basis.shape[0]):
            below, above = lower[basis[r]] - values[r], values[r] - upper[basis[r]]
            if max(below, above) > worst:
                leave, worst, rising = r, max(below, above), below > above
        if leave < 0:
            return OPTIMAL
        find_reduced_costs(lp, count, goal, sense)
        # A leaving value that must rise is one that must fall in the row times -1.
        combine_rows(lp.inverse, leave, 1.0 if rising else -1.0, lp.columns, count, lp.pivot_row)
        longest = np.inf
        for j in range(count):
            slope = lp.pivot_row[j] if status[j] == LOWER else -lp.pivot_row[j]
            cost = -lp.reduced[j] if status[j] == LOWER else lp.reduced[j]
            if status[j] != BASIC and slope < -PIVOT and lower[j] < upper[j]:
                longest = min(longest, (max(cost, 0.0) + REDUCED_COST) / -slope)
        enter, largest = NONE, 0.0
        for j in range(count):
            slope = lp.pivot_row[j] if status[j] == LOWER else -lp.pivot_row[j]
            cost = -lp.reduced[j] if status[j] == LOWER else lp.reduced[j]
            if (
                status[j] != BASIC
                and -slope > max(largest, PIVOT)
                and lower[j] < upper[j]
                and max(cost, 0.0) / -slope <= longest
            ):
                enter, largest = j, -slope
        if enter < 0:
            return INFEASIBLE
        find_direction(lp, enter)
        pivot(lp, enter, leave, LOWER if rising else UPPER)
    return FAILED
