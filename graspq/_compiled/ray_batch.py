"""Compiled entry: q* of many grasps, or of one; it runs without the interpreter's lock."""

from __future__ import annotations

import numpy as np

from graspq._compiled.body import Bodies
from graspq._compiled.body_reading import extent, largest, take
from graspq._compiled.jit import compiled, entry
from graspq._compiled.ray_shooting import CAPPED, SOLVED, ZERO, collect, shoot
from graspq._compiled.workspace import ARTIFICIAL, CANDIDATES, OBJECTIVE, PART_ROWS, Workspace

# A basis whose inverse is larger, in units of the extent, may be that of a flat set.
STEEP = 1e5
# Status of a body with entries, or a task, that are not finite, or a task of nothing.
REFUSED = 4
# Columns of ``results``: of one body, and of one ray, whose plane follows.
STATUS, VALUE, LOWER, UPPER, TASK, SOUND, RESULTS = range(7)
PLANE, RAY_RESULTS = 2, 8


@compiled
def _sound(state):
    """Whether six well-conditioned vertices carry the task, as in no flat set."""
    for k in range(6):
        if state.kinds[k] == ARTIFICIAL:
            return False
        for c in range(6):
            if not abs(state.tableau[c, k]) * state.size[c] < STEEP:
                return False
    return True


@compiled
def _tasks_are_sound(tasks, begin, end):
    """Whether every task is finite, short of 1e308, and none is zero."""
    for j in range(begin, end):
        force = abs(tasks[0, j]) + abs(tasks[1, j]) + abs(tasks[2, j])
        moment = abs(tasks[3, j]) + abs(tasks[4, j]) + abs(tasks[5, j])
        if not 0.0 < force + moment < np.inf:
            return False
    return True


@entry
def shoot_bodies(
    points,
    first_point,
    centres,
    axes,
    first_ellipsoid,
    first_set,
    holds_origin,
    shifts,
    tasks,
    first_task,
    last_task,
    stop,
    owners,
    ellipsoid_owners,
    results,
    forces,
    rays,
    states,
):
    """Find the smallest reach of each body's task set.

    Args:
        points, ..., holds_origin: ``Bodies``.
        shifts: what is taken off each body, shape (N, 6).
        tasks: task wrenches of all bodies, shape (6, M).
        first_task, last_task: where each body's tasks begin and end, shape (N,).
        stop: relative gain below which no point improves a task.
        owners, ellipsoid_owners: contact of every point and ellipsoid, where ``forces`` has rows.
        results: receives status (``REFUSED`` for what is not finite, or a zero task), value, lower
            and upper bound, critical task, and whether six well-conditioned vertices carry every
            task, as in no flat set; shape (N, 6).
        forces: receives the contacts' wrenches of the last body, shape (contacts or 0, 6).
        rays: where it has rows, receives status, reach and plane u of every task, shape (M, 8),
            and no task ends the search.
        states: one record of ``STATE``, scratch.
    """
    bodies = Bodies(points, first_point, centres, axes, first_ellipsoid, first_set, holds_origin)
    columns, sets = largest(first_point, first_set)
    state = states[0]
    parts = np.empty((PART_ROWS, sets), np.int64)
    candidates = np.empty((sets, 1 + CANDIDATES), np.int64)
    work = Workspace(state, parts, candidates, np.empty(columns))
    own, own_first = np.empty((6, columns)), np.empty(sets + 1, np.int64)
    for g in range(first_set.shape[0] - 1):
        body = take(bodies, g, shifts[g], own, own_first)
        results[g, SOUND] = 0.0
        finite = extent(body, state.size)
        if not (finite and _tasks_are_sound(tasks, first_task[g], last_task[g])):
            results[g, STATUS] = REFUSED
            continue
        for i in range(sets):
            candidates[i, 0] = 0
        for k in range(6):
            state.kinds[k] = ARTIFICIAL
        value, lower, upper, critical = np.inf, np.inf, np.inf, 0
        status, sound = SOLVED, True
        for j in range(first_task[g], last_task[g]):
            for r in range(6):
                state.task[r] = tasks[r, j]
            outcome, q, high = shoot(work, body, stop)
            sound = sound and _sound(state)
            if rays.shape[0] > 0:
                rays[j, STATUS], rays[j, VALUE] = outcome, q
                for c in range(6):
                    rays[j, PLANE + c] = state.tableau[c, OBJECTIVE]
                continue
            if outcome == CAPPED:
                status = CAPPED
                break
            lower, upper = min(lower, q), min(upper, high)
            if q < value:
                value, critical = q, j - first_task[g]
                if outcome == ZERO:
                    status, lower, upper = ZERO, 0.0, high
                    break
                if forces.shape[0] > 0:
                    collect(work, body, owners, ellipsoid_owners, forces)
        results[g, STATUS], results[g, VALUE], results[g, LOWER] = status, value, lower
        results[g, UPPER], results[g, TASK] = upper, critical
        results[g, SOUND] = 1.0 if sound else 0.0
