"""Compiled pivots of ray shooting: bases of six vertices, chosen through a support oracle."""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.polytope_pivots import GAIN, ask
from graspq._compiled.small_matrices import dot, row_sum, times
from graspq._compiled.support_function import support
from graspq._compiled.workspace import (
    ARTIFICIAL,
    CHOICE,
    DIRECTIONS,
    INVERSE,
    KEPT,
    PAD,
    PICKS,
    REAL,
    SCRATCH,
    refactor,
)

# Length of the artificial vertices in units of the set's extent; TALL where the set is a plain
# polytope: fewer pivots, and no smooth surface that needs them out of the way.
SMALL, TALL = 1e-3, 1e-2


@compiled
def price(u, body, pads, enough, desk, out):
    """Support of the set together with the pads ±p that stand for directions it lacks.

    Of plain polytopes any vertex worth more than ``enough`` will do. Returns (value, kind).
    """
    points, starts, centres, axes, balls, zero, shift = body
    if axes.shape[0] == 0 and pads.shape[0] == 0:
        return ask(u, body, enough, desk, out), REAL
    h = support(
        u, points, starts, centres, axes, balls, zero, shift, desk.score, desk.places[CHOICE], out
    )
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
def replace(desk, leave, vertex, u, kind, picks, column):
    """Pivot ``vertex`` into place ``leave``; ``column`` is B⁻¹ times the vertex.

    Its direction and the atoms that make it up, row ``picks`` of the places, are kept beside it.
    """
    sheet, places = desk.sheet, desk.places
    inverse = sheet[INVERSE : INVERSE + 6]
    scale = 1.0 / column[leave]
    for c in range(6):
        inverse[leave, c] *= scale
    for r in range(6):
        if r != leave and column[r] != 0.0:
            for c in range(6):
                inverse[r, c] -= column[r] * inverse[leave, c]
    for r in range(6):
        sheet[r, leave] = vertex[r]
        sheet[DIRECTIONS + leave, r] = u[r]
    desk.kinds[leave] = kind
    for i in range(places.shape[1]):
        places[PICKS + leave, i] = places[picks, i]


@compiled
def start_basis(desk, task, size, small):
    """Set up the artificial basis of ``small`` times the extent ``size`` around ``task``."""
    sheet = desk.sheet
    for r in range(6):
        for c in range(6):
            sheet[r, c] = 0.0
            sheet[INVERSE + r, c] = 0.0
            sheet[DIRECTIONS + r, c] = 0.0
        length = small * size[r] if task[r] >= 0.0 else -small * size[r]
        sheet[r, r] = length
        sheet[INVERSE + r, r] = 1.0 / length
        desk.kinds[r] = ARTIFICIAL


@compiled
def turn_basis(desk, target, small):
    """Make a basis hold another target: what it lies away from gives way to short opposites."""
    sheet = desk.sheet
    for r in range(6):
        weight = 0.0
        for c in range(6):
            weight += sheet[INVERSE + r, c] * target[c]
        if weight < 0.0:
            for c in range(6):
                sheet[c, r] *= -small
                sheet[INVERSE + r, c] /= -small
            desk.kinds[r] = ARTIFICIAL


@compiled
def primal(desk, target, task, body, pads, stop, cap):
    """Pivot until no vertex improves ``target``; return (solved, upper bound on q, steps)."""
    inverse, scratch = desk.sheet[INVERSE : INVERSE + 6], desk.sheet[SCRATCH:]
    u, vertex, weight, column = scratch[0], scratch[1], scratch[2], scratch[3]
    upper = np.inf
    for step in range(cap):
        if step % 40 == 39 and not refactor(desk):
            return False, upper, step
        row_sum(inverse, u)
        h, kind = price(u, body, pads, np.inf, desk, vertex)
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
                if (
                    leave < 0
                    or value < ratio * (1.0 - 1e-13)
                    or (value <= ratio * (1.0 + 1e-13) and column[r] > column[leave])
                ):
                    leave, ratio = r, value
        replace(desk, leave, vertex, u, kind, CHOICE, column)
    return False, upper, cap


@compiled
def _keep(desk):
    """Keep the chosen atoms while others are asked for."""
    places = desk.places
    for i in range(places.shape[1]):
        places[KEPT, i] = places[CHOICE, i]


@compiled
def dual(desk, task, body, pads, stop, cap):
    """Keep u feasible and make the weights of ``task`` non-negative.

    Returns 0 when done, 1 when no weights exist (the task is outside the cone), 2 at the cap.
    """
    inverse, scratch = desk.sheet[INVERSE : INVERSE + 6], desk.sheet[SCRATCH:]
    u, vertex, weight, column = scratch[0], scratch[1], scratch[2], scratch[3]
    trial, row, direction = scratch[4], scratch[5], scratch[6]
    for step in range(cap):
        if step % 20 == 19 and not refactor(desk):
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
        for r in range(6):
            row[r] = inverse[leave, r]
            trial[r] = -row[r]
        h, kind = price(trial, body, pads, 1e-12, desk, vertex)
        if h <= 1e-12:
            return 1
        direction[:] = trial
        _keep(desk)
        for _ in range(60):
            fall = -dot(row, vertex)
            angle = max(1.0 - dot(u, vertex), 0.0) / fall
            direction[:] = trial
            for r in range(6):
                trial[r] = u[r] - angle * row[r]
            new = column
            h, kind_new = price(trial, body, pads, 1.0 + GAIN, desk, new)
            if h <= 1.0 + stop or -dot(row, new) <= 1e-12:
                break
            kind = kind_new
            vertex[:] = new
            _keep(desk)
        times(inverse, vertex, column)
        if column[leave] > -1e-11:
            return 2
        replace(desk, leave, vertex, direction, kind, KEPT, column)
    return 2
