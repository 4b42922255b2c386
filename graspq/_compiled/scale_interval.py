"""Compiled: the interval of scales q at which q t lies in a set that may miss the origin.

Seen from an inner point p, the gauge of q t - p is convex in q and is 1 on the boundary.
Newton's method on it from the right stops after finitely many facets, each found by one shot.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry
from graspq._compiled.pivots import price
from graspq._compiled.ray_shooting import CAPPED, SOLVED, collect, shoot
from graspq._compiled.small_matrices import dot, row_sum
from graspq._compiled.workspace import INVERSE, clear, new_desk

EMPTY = 3
CLOSE = 1e-6


@compiled
def highest(desk, task, inner, size, body, pads, stop):
    """Return (status, q, upper, gauge) of the largest q, of any sign, with q t in the set.

    ``upper`` is proven by a plane; ``gauge`` is that of q t, 1 up to the tolerance.
    CAPPED where the line passes so close that round-off decides whether it meets the set.
    """
    u, vertex, ray = np.empty(6), np.empty(6), task.copy()
    q, upper, closest = np.inf, np.inf, 0.0
    for _ in range(200):
        status, value, _, _ = shoot(desk, ray, size, body, pads, stop)
        if status != SOLVED:
            return CAPPED, 0.0, 0.0, 0.0
        row_sum(desk.sheet[INVERSE : INVERSE + 6], u)
        along = dot(u, task)
        if along > 0.0:
            h, _ = price(u, body, pads, np.inf, desk, vertex)
            upper = min(upper, (h + dot(u, inner)) / along)
        if q < np.inf and value >= 1.0 - 1e-12 - 4.0 * stop:
            return SOLVED, q, upper, 1.0 / value
        if q < np.inf:
            closest = max(closest, value)
        if along <= 0.0:
            return (EMPTY if closest < 1.0 - CLOSE else CAPPED), 0.0, 0.0, 0.0
        below = (1.0 + dot(u, inner)) / along
        if q < np.inf and below >= q - 1e-15 * abs(q):
            return SOLVED, q, upper, 1.0 / value
        q = below
        if _ray_through(ray, q, task, inner, size):
            return SOLVED, q, upper, 0.0
    return CAPPED, 0.0, 0.0, 0.0


@compiled
def _ray_through(ray, q, task, inner, size):
    """Point the ray from the inner point at q t; True when they are the same point."""
    far, near = 0.0, 0.0
    for r in range(6):
        ray[r] = q * task[r] - inner[r]
        far = max(far, abs(ray[r]) / size[r])
        near = max(near, abs(inner[r]) / size[r])
    return far <= 1e-12 * near or far == 0.0


@entry
def between(tasks, inner, size, body, pads, stop, owners, ball_owners, forces):
    """Return (status, q, lower, upper, critical): the largest q >= 0 with every q t in the set.

    ``upper`` is proven by the plane that stops some task's ray, ``lower`` by the gauge between
    the two ends of every ray, which is convex.
    """
    desk = new_desk(body[0].shape[1], body[1].shape[0] - 1)
    clear(desk, body)
    points, starts, centres, axes, balls, zero, _ = body
    body = (points, starts, centres, axes, balls, zero, inner)
    task, ray = np.empty(6), np.empty(6)
    value, critical, least, last = np.inf, 0, 0.0, 0
    lower, upper = np.inf, np.inf
    for j in range(tasks.shape[1]):
        high, gauge = 0.0, 0.0
        for sign in (1.0, -1.0):
            for r in range(6):
                task[r] = sign * tasks[r, j]
            status, q, top, g = highest(desk, task, inner, size, body, pads, stop)
            if status != SOLVED:
                return status, q, q, q, j
            far = 0.0
            for r in range(6):
                far = max(far, abs(task[r]) / size[r])
            if abs(q) * far < 10.0 * stop:
                q = 0.0  # the boundary passes through the origin, up to round-off
            if sign > 0:
                high, gauge, upper = q, g, min(upper, top)
                if q < value:
                    value, critical = q, j
                    collect(desk, body, owners, ball_owners, forces)
            else:
                if -q > least:
                    least, last = -q, j
                middle = 0.5 * (high - q)
                slip = 0.0
                if gauge > 1.0:
                    for r in range(6):
                        task[r] = tasks[r, j]
                    g = 0.0
                    if not _ray_through(ray, middle, task, inner, size):
                        status, reach, _, _ = shoot(desk, ray, size, body, pads, stop)
                        g = 1.0 / reach if status == SOLVED else 1.0
                    slip = 1.0 if g >= 1.0 else min(1.0, (gauge - 1.0) / (gauge - g))
                lower = min(lower, high - (high - middle) * slip)
    if value < 0.0 or least > value * (1.0 + 1e-9 + 10.0 * stop):
        if least <= value * (1.0 + CLOSE):
            return CAPPED, 0.0, 0.0, 0.0, last
        return EMPTY, 0.0, 0.0, 0.0, critical if value < 0.0 else last
    return SOLVED, value, min(lower, value), max(value, upper), critical
