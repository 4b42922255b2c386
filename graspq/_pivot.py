"""Compiled pivots of ray shooting: bases of six vertices, chosen through a support oracle."""


from __future__ import annotations

import numpy as np

from graspq._climb import GAIN, ask
from graspq._jit import compiled
from graspq._oracle import invert, support

# Length of the artificial vertices in units of the set's extent; TALL where the set is a plain
# polytope: fewer pivots, and no smooth surface that needs them out of the way.
SMALL, TALL = 1e-3, 1e-2
REAL, PAD, ARTIFICIAL = 0, 1, 2


@compiled
def price(u, body, pads, score, choice, out):
    """Support of the set together with the pads ±p that stand for directions it lacks."""
    points, starts, centres, axes, balls, zero, shift = body
    h = support(u, points, starts, centres, axes, balls, zero, shift, score, choice, out)
    kind = REAL
    for k in range(pads.shape[0]):
        along = 0.0
        for r in range(6):
            along += u[r] * pads[k, r]
        if abs(along) > h:
            h, kind = abs(along), PAD
            for r in range(6):
                out[r] = pads[k, r] if along > 0 else -pads[k, r]
    return h, kind


@compiled
def replace(state, leave, vertex, u, kind, choice, column):
    """Pivot ``vertex`` into place ``leave``; ``column`` is B⁻¹ times the vertex.

    Its direction and the atoms that make it up are kept beside it.
    """
    basis, inverse, directions, kinds, _, picks = state
    scale = 1.0 / column[leave]
    for c in range(6):
        inverse[leave, c] *= scale
    for r in range(6):
        if r != leave and column[r] != 0.0:
            for c in range(6):
                inverse[r, c] -= column[r] * inverse[leave, c]
    for r in range(6):
        basis[r, leave] = vertex[r]
        directions[leave, r] = u[r]
    kinds[leave] = kind
    for i in range(choice.shape[0]):
        picks[leave, i] = choice[i]


@compiled
def new_state(bodies):
    """Scratch of a basis: (basis, inverse, directions, kinds, weights, atoms of the vertices)."""
    return (np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6)),
            np.full(6, ARTIFICIAL), np.zeros(6), np.zeros((6, bodies), np.int64))


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
        u[c] = (inverse[0, c] + inverse[1, c] + inverse[2, c]
                + inverse[3, c] + inverse[4, c] + inverse[5, c])


@compiled
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@compiled
def start_basis(state, task, size, small):
    """Set up the artificial basis of ``small`` times the extent ``size`` around ``task``."""
    basis, inverse, directions, kinds = state[0], state[1], state[2], state[3]
    basis[:, :] = 0.0
    inverse[:, :] = 0.0
    directions[:, :] = 0.0
    for r in range(6):
        length = small * size[r] if task[r] >= 0.0 else -small * size[r]
        basis[r, r] = length
        inverse[r, r] = 1.0 / length
        kinds[r] = ARTIFICIAL


@compiled
def primal(state, target, task, body, pads, stop, cap, score, choice):
    """Pivot until no vertex improves ``target``; return (solved, upper bound on q, steps)."""
    inverse = state[1]
    u, vertex = np.empty(6), np.empty(6)
    weight, column = np.empty(6), np.empty(6)
    upper = np.inf
    for step in range(cap):
        if step % 40 == 39 and not invert(state[0], inverse):
            return False, upper, step
        row_sum(inverse, u)
        h, kind = price(u, body, pads, score, choice, vertex)
        reach = dot(u, task)
        if reach > 0.0 and h / reach < upper:
            upper = h / reach
        if h <= 1.0 + stop:
            return True, upper, step
        times(inverse, target, weight)
        times(inverse, vertex, column)
        leave, ratio = -1, np.inf
        for r in range(6):
            if column[r] > 1e-11:
                value = max(weight[r], 0.0) / column[r]
                if leave < 0 or value < ratio * (1.0 - 1e-13) or (
                    value <= ratio * (1.0 + 1e-13) and column[r] > column[leave]
                ):
                    leave, ratio = r, value
        replace(state, leave, vertex, u, kind, choice, column)
    return False, upper, cap


@compiled
def _worth(u, body, pads, enough, score, choice, short, out):
    """``price``; of plain polytopes any vertex worth more than ``enough``."""
    if body[3].shape[0] > 0 or pads.shape[0] > 0:
        return price(u, body, pads, score, choice, out)
    return ask(u, body, enough, score, choice, short, out), REAL


@compiled
def dual(state, task, body, pads, stop, cap, score, choice, short):
    """Keep u feasible and make the weights of ``task`` non-negative.

    Returns 0 when done, 1 when no weights exist (the task is outside the cone), 2 at the cap.
    """
    inverse = state[1]
    u, vertex, trial = np.empty(6), np.empty(6), np.empty(6)
    weight, column, kept = np.empty(6), np.empty(6), choice.copy()
    for step in range(cap):
        if step % 20 == 19 and not invert(state[0], inverse):
            return 2
        times(inverse, task, weight)
        leave, worst, total = -1, 0.0, 0.0
        for r in range(6):
            total += abs(weight[r])
            if weight[r] < worst:
                leave, worst = r, weight[r]
        noise = 1e-13 * total
        if leave >= 0:
            for c in range(6):
                noise = max(noise, 1e-15 * abs(inverse[leave, c] * task[c]))
        if leave < 0 or worst >= -noise:
            return 0
        # Tilt u about the five other vertices until the next vertex of the set supports it.
        row_sum(inverse, u)
        row = inverse[leave].copy()
        for r in range(6):
            trial[r] = -row[r]
        h, kind = _worth(trial, body, pads, 1e-12, score, choice, short, vertex)
        if h <= 1e-12:
            return 1
        direction = trial.copy()
        kept[:] = choice
        for _ in range(60):
            fall = -dot(row, vertex)
            angle = max(1.0 - dot(u, vertex), 0.0) / fall
            direction[:] = trial
            for r in range(6):
                trial[r] = u[r] - angle * row[r]
            new = column
            h, kind_new = _worth(trial, body, pads, 1.0 + GAIN, score, choice, short, new)
            if h <= 1.0 + stop or -dot(row, new) <= 1e-12:
                break
            kind = kind_new
            vertex[:] = new
            kept[:] = choice
        times(inverse, vertex, column)
        if column[leave] > -1e-11:
            return 2
        replace(state, leave, vertex, direction, kind, kept, column)
    return 2
