"""Compiled pivots of ray shooting on plain polytopes: what ``_pivot.primal`` does, faster.

u and the weights are updated with every pivot instead of formed anew. Where contacts have many
columns, those that ever were the best of theirs are asked first, and all only when these few
have nothing left to gain.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.simd_lanes import best_lane, leaving, product, sweep
from graspq._compiled.support_function import FAST
from graspq._compiled.workspace import (
    CHOICE,
    COLUMN,
    COUNT,
    FIRST,
    MANY,
    PICKS,
    REAL,
    ROOM,
    SHARE,
    from_lanes,
    refresh,
    remember,
    to_lanes,
)

GAIN = 1e-7


@compiled(fastmath=FAST)
def _scores(u, points, out):
    """out = u · points."""
    u0, u1, u2, u3, u4, u5 = u
    for k in range(points.shape[1]):
        out[k] = (
            u0 * points[0, k]
            + u1 * points[1, k]
            + u2 * points[2, k]
            + u3 * points[3, k]
            + u4 * points[4, k]
            + u5 * points[5, k]
        )


@compiled(fastmath=FAST)
def _top(score, first, last):
    best = score[first]
    for k in range(first + 1, last):
        best = score[k] if score[k] > best else best
    return best


@compiled
def six(vector):
    """The vector as a tuple, which needs no memory."""
    return vector[0], vector[1], vector[2], vector[3], vector[4], vector[5]


@compiled
def along(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@compiled
def _best_of(u, desk, body):
    """Best vertex in direction u of all columns; its own become the chosen."""
    points, starts, zero, shift = body[0], body[1], body[5], body[6]
    score, places = desk.score, desk.places
    _scores(u, points, score)
    v0, v1, v2 = -shift[0], -shift[1], -shift[2]
    v3, v4, v5 = -shift[3], -shift[4], -shift[5]
    for i in range(places.shape[1]):
        best = _top(score, starts[i], starts[i + 1])
        places[CHOICE, i] = -1
        if best > 0.0 or not zero:
            k = starts[i]
            while score[k] != best:
                k += 1
            places[CHOICE, i] = k
            v0, v1, v2 = v0 + points[0, k], v1 + points[1, k], v2 + points[2, k]
            v3, v4, v5 = v3 + points[3, k], v4 + points[4, k], v5 + points[5, k]
    return v0, v1, v2, v3, v4, v5


@compiled(forceinline=True)
def _listed_best(u, desk, body):
    """``_best_of`` the listed columns."""
    zero, shift = body[5], body[6]
    lanes, names, places = desk.lanes, desk.names, desk.places
    floor = 0.0 if zero else -np.inf
    v0, v1, v2 = -shift[0], -shift[1], -shift[2]
    v3, v4, v5 = -shift[3], -shift[4], -shift[5]
    for i in range(places.shape[1]):
        at = places[FIRST, i]
        row = ROOM + 6 * at
        k = best_lane(lanes, row, (places[COUNT, i] + 7) >> 3, floor, u)
        if k < 0:
            places[CHOICE, i] = -1
            continue
        places[CHOICE, i] = names[8 * at + k]
        row = 8 * row + 48 * (k >> 3) + (k & 7)
        v0, v1, v2 = v0 + lanes[row], v1 + lanes[row + 8], v2 + lanes[row + 16]
        v3, v4, v5 = v3 + lanes[row + 24], v4 + lanes[row + 32], v5 + lanes[row + 40]
    return v0, v1, v2, v3, v4, v5


@compiled
def ask(u, body, enough, desk, out):
    """Support value of u and its vertex; a vertex worth more than ``enough`` will do."""
    way = six(u)
    complete = body[0].shape[1] <= MANY
    vertex, h = way, -np.inf
    if complete or desk.places[COUNT].max() > 0:
        vertex = _listed_best(way, desk, body)
        h = along(way, vertex)
    if not complete and h <= enough:
        vertex = _best_of(way, desk, body)
        h = along(way, vertex)
        remember(desk, body[0])
    for r in range(6):
        out[r] = vertex[r]
    return h


@compiled
def climb(desk, target, task, body, stop, cap):
    """Pivot until no vertex improves ``target``; return (solved, upper bound on q).

    Directions are not kept: only ellipsoids need them.
    """
    lanes, sheet, places = desk.lanes, desk.sheet, desk.places
    complete = body[0].shape[1] <= MANY
    listed = complete or places[COUNT].max() > 0
    goal = six(task)
    upper = np.inf
    u = goal
    for step in range(cap):
        if step % 40 == 0:
            if step > 0:
                from_lanes(desk)
                if not refresh(desk):
                    return False, upper
            to_lanes(desk)
            product(lanes, SHARE, 0, six(target))
            u = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            for r in range(6):
                u = (
                    u[0] + lanes[r],
                    u[1] + lanes[8 + r],
                    u[2] + lanes[16 + r],
                    u[3] + lanes[24 + r],
                    u[4] + lanes[32 + r],
                    u[5] + lanes[40 + r],
                )
        vertex, h = goal, 0.0
        if listed:
            vertex = _listed_best(u, desk, body)
            h = along(u, vertex)
        # Less of a gain may be round-off of a long u about a vertex that is in the basis.
        if not complete and (not listed or h <= 1.0 + GAIN):
            vertex = _best_of(u, desk, body)
            h = along(u, vertex)
            listed = remember(desk, body[0]) or listed
            final = True
        else:
            final = complete
        if final:
            reach = along(u, goal)
            if reach > 0.0 and h < upper * reach:
                upper = h / reach
            if h <= 1.0 + stop:
                from_lanes(desk)
                return True, upper
        product(lanes, COLUMN, 0, vertex)
        leave = leaving(lanes, COLUMN, SHARE)
        if leave < 0:
            return False, upper
        desk.kinds[leave] = REAL
        for r in range(6):
            sheet[r, leave] = vertex[r]
        for i in range(places.shape[1]):
            places[PICKS + leave, i] = places[CHOICE, i]
        scale = 1.0 / lanes[8 * COLUMN + leave]
        p0, p1, p2 = lanes[leave] * scale, lanes[8 + leave] * scale, lanes[16 + leave] * scale
        p3, p4, p5 = (
            lanes[24 + leave] * scale,
            lanes[32 + leave] * scale,
            lanes[40 + leave] * scale,
        )
        share = lanes[8 * SHARE + leave] * scale
        # The column's entries add up to h.
        slip = h - 1.0
        u = (
            u[0] - slip * p0,
            u[1] - slip * p1,
            u[2] - slip * p2,
            u[3] - slip * p3,
            u[4] - slip * p4,
            u[5] - slip * p5,
        )
        sweep(lanes, 0, COLUMN, p0, leave)
        sweep(lanes, 1, COLUMN, p1, leave)
        sweep(lanes, 2, COLUMN, p2, leave)
        sweep(lanes, 3, COLUMN, p3, leave)
        sweep(lanes, 4, COLUMN, p4, leave)
        sweep(lanes, 5, COLUMN, p5, leave)
        sweep(lanes, SHARE, COLUMN, share, leave)
    return False, upper
