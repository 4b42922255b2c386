"""Compiled: the interval of scales q at which q t lies in a set that may miss the origin.

Seen from an inner point p, the gauge of q t - p is convex in q and is 1 on the boundary.
Newton's method on it from the right stops after finitely many facets, each found by one shot.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from graspq._pivot import dot, row_sum
from graspq._ray import CAPPED, SOLVED, collect, shoot

EMPTY = 3


@njit(cache=True, nogil=True, error_model="numpy")
def highest(state, task, inner, size, body, pads, stop, score, choice):
    """Return (status, q): the largest q, of any sign, with q t in the set."""
    u, ray = np.empty(6), task.copy()
    q = np.inf
    for _ in range(200):
        status, value, _, _ = shoot(state, False, ray, size, body, pads, stop, score, choice)
        if status != SOLVED:
            return CAPPED, 0.0
        row_sum(state[1], u)
        along = dot(u, task)
        if q < np.inf and value >= 1.0 - 1e-12 - 4.0 * stop:
            return SOLVED, q
        if along <= 0.0:
            return EMPTY, 0.0
        below = (1.0 + dot(u, inner)) / along
        if q < np.inf and below >= q - 1e-15 * abs(q):
            return SOLVED, q
        q = below
        far, near = 0.0, 0.0
        for r in range(6):
            ray[r] = q * task[r] - inner[r]
            far = max(far, abs(ray[r]) / size[r])
            near = max(near, abs(inner[r]) / size[r])
        if far <= 1e-12 * near or far == 0.0:
            return SOLVED, q
    return CAPPED, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def between(tasks, inner, size, body, pads, stop, owners, ball_owners, forces):
    """Return (status, q, critical): the largest q >= 0 that puts every q t in the set."""
    score, choice = np.empty(body[0].shape[1]), np.empty(body[1].shape[0] - 1, np.int64)
    state = (np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6)), np.zeros(6, np.int64),
             np.zeros(6))
    points, starts, centres, axes, balls, zero, _ = body
    body = (points, starts, centres, axes, balls, zero, inner)
    task = np.empty(6)
    value, critical, least, last = np.inf, 0, 0.0, 0
    for j in range(tasks.shape[1]):
        for sign in (1.0, -1.0):
            for r in range(6):
                task[r] = sign * tasks[r, j]
            status, q = highest(state, task, inner, size, body, pads, stop, score, choice)
            if status != SOLVED:
                return status, q, j
            far = 0.0
            for r in range(6):
                far = max(far, abs(task[r]) / size[r])
            if abs(q) * far < 10.0 * stop:
                q = 0.0  # the boundary passes through the origin, up to round-off
            if sign > 0 and q < value:
                value, critical = q, j
                collect(state, value, body, owners, ball_owners, score, choice, forces)
            elif sign < 0 and -q > least:
                least, last = -q, j
    if value < 0.0 or least > value * (1.0 + 1e-9 + 10.0 * stop):
        return EMPTY, 0.0, critical if value < 0.0 else last
    return SOLVED, value, critical
