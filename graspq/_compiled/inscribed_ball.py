"""Compiled ε: grow the hull at its nearest facet until that facet supports the set."""

from __future__ import annotations

import numpy as np

from graspq._compiled.incremental_hull import (
    ALIVE,
    DONE,
    FULL,
    GROWN,
    insert,
    jog_vertex,
    known,
    simplex,
)
from graspq._compiled.jit import compiled, entry
from graspq._compiled.ray_shooting import CAPPED, SOLVED, extent, shoot
from graspq._compiled.small_matrices import invert, times
from graspq._compiled.span_and_whitening import spread, whiten, whitened
from graspq._compiled.support_function import support
from graspq._compiled.workspace import clear, new_desk

STUCK, SMALL, COARSE, FLAT = 3, 4, 5, 6


@entry
def room(max_facets, max_vertices):
    """Room for a hull, to be used again for the next."""
    size = 1
    while size < 12 * max_facets:
        size *= 2
    return (
        np.empty((max_vertices, 6)),
        np.empty((max_vertices, 6)),
        np.empty((max_facets, 6), np.int32),
        np.empty((max_facets, 6), np.int32),
        np.empty((max_facets, 6)),
        np.zeros(max_facets, np.int8),
        np.zeros(max_facets, np.int32),
        np.zeros(max_facets),
        np.empty(max_facets, np.int32),
        np.empty(max_facets, np.int32),
        np.empty(max_facets, np.int32),
        np.empty((1, max_facets)),
        np.empty(size, np.int32),
        np.empty(size, np.int64),
    )


@compiled
def nearest(body, turn, stop, small, jog, seed, work):
    """Return (status, lower, upper, facets made) of the largest ball around the origin.

    The origin must lie strictly inside the set, which is round: ``turn`` took it there, and
    lengths are those before. COARSE asks for a smaller ``jog``.

    ``lower`` is the distance of the nearest facet of the hull and ``upper`` the support of its
    normal; they meet within ``stop``. SMALL says that an artificial vertex is still on it.
    """
    (
        vertices,
        jogged,
        facets,
        links,
        planes,
        state,
        mark,
        length,
        stack,
        free,
        fresh,
        edge,
        table,
        tags,
    ) = work
    max_vertices = vertices.shape[0]
    state[:] = 0
    mark[:] = 0
    score, choice = np.empty(body[0].shape[1]), np.empty(body[1].shape[0] - 1, np.int64)
    vertex = np.empty(6)
    points, starts, centres, axes, balls, zero, shift = body
    count, top = simplex(small, vertices, jogged, facets, links, planes, state)
    free_count = 0
    for f in range(top):
        length[f] = _length(planes[f], turn)
    upper, confirmed, distance = np.inf, np.inf, 0.0
    for step in range(20 * max_vertices):
        # The facet nearest the origin has the longest u.
        f, most = -1, 0.0
        for g in range(top):
            if state[g] == ALIVE and length[g] > most:
                f, most = g, length[g]
        if f < 0:
            break
        distance = 1.0 / most
        artificial = False
        for k in range(6):
            artificial = artificial or facets[f, k] < 7
        # What jogging may change is relative to how flat the set is along u.
        noise = 0.0
        for r in range(6):
            noise += jog * abs(planes[f, r])
        coarse = noise > 1e-4 and not artificial
        if confirmed < np.inf and distance > confirmed * (1.0 + 10.0 * noise):
            break
        plane = planes[f].copy()
        exact = False
        if not artificial:
            exact = _exact_plane(f, facets, vertices, plane)
            if not exact:
                plane[:] = planes[f]
        h = support(plane, points, starts, centres, axes, balls, zero, shift, score, choice, vertex)
        reach = _length(plane, turn)
        if h > 0.0:
            upper = min(upper, h / reach)
        elif h <= 0.0:
            return SMALL, 0.0, 0.0, top
        if exact and h <= 1.0 + 1e-12:
            if coarse:
                return COARSE, distance, upper, top
            confirmed = min(confirmed, h / reach)
            state[f] = DONE
            continue
        if stop > 1e-12 and upper - distance <= stop * upper and not artificial:
            return GROWN, distance, upper, top
        if count >= max_vertices:
            return FULL, distance, upper, top
        grows = False
        for way in range(2):
            if way == 1:
                # An exact plane through a sliver points anywhere: ask along the jogged one.
                support(
                    planes[f],
                    points,
                    starts,
                    centres,
                    axes,
                    balls,
                    zero,
                    shift,
                    score,
                    choice,
                    vertex,
                )
            if known(vertex, vertices, count) < 0:
                vertices[count] = vertex
                jog_vertex(vertex, count, jog, seed, jogged[count])
                grows = _height_of(planes, f, jogged[count]) > 1.0
            if grows or not exact:
                break
        if not grows:
            if artificial:
                return SMALL, 0.0, upper, top
            if coarse:
                return COARSE, distance, upper, top
            if exact and h <= 1.0 + 1e-9:
                confirmed = min(confirmed, h / reach)
            state[f] = DONE
            continue
        status, top, free_count, made = insert(
            count,
            f,
            top,
            jogged,
            facets,
            links,
            planes,
            state,
            mark,
            step + 1,
            stack,
            edge,
            free,
            free_count,
            table,
            tags,
            fresh,
        )
        if status != GROWN:
            return status, distance, upper, top
        for i in range(made):
            length[fresh[i]] = _length(planes[fresh[i]], turn)
        count += 1
    if confirmed > upper * (1.0 + 1e-12):
        # Some direction reaches less far than the facets that were found.
        return STUCK, confirmed, upper, top
    return GROWN, confirmed, confirmed, top


@compiled
def strictly_inside(body, inner, size):
    """Return (status, inside): whether the origin is interior to a set of full dimension.

    It is when the set, seen from its inner point, reaches past the origin.
    """
    points, starts, centres, axes, balls, zero, _ = body
    far = 0.0
    for r in range(6):
        far = max(far, abs(inner[r]) / size[r])
    if far <= 1e-12:
        return SOLVED, True
    desk = new_desk(points.shape[1], starts.shape[0] - 1)
    clear(desk, body)
    stop = 1e-6 if centres.shape[1] > 0 else 1e-12
    if not zero:
        body = (points, starts, centres, axes, balls, zero, inner)
    status, value, _, _ = shoot(desk, -inner, size, body, np.zeros((0, 6)), stop)
    return status, status == SOLVED and (zero or value > 1.0 + 1e-9)


@entry
def ball(body, stop, work):
    """Return (status, lower, value) of the largest ball around the origin; 0 when outside.

    Without room for vertices, the value only says whether the origin is inside.
    """
    inner, size, scatter, turn = np.empty(6), np.empty(6), np.empty((6, 6)), np.empty((6, 6))
    if spread(body, inner, size, scatter) == 0.0:
        return FLAT, 0.0, 0.0
    whiten(scatter, size, turn)
    return ball_of(body, turn, inner, stop, work)


@entry
def ball_of(body, turn, inner, stop, work):
    """``ball`` of a set that ``turn`` takes to a round one; ``inner`` is a point inside."""
    body = whitened(body, turn)
    middle, size = np.empty(6), np.empty(6)
    times(turn, inner, middle)
    extent(body, size)
    status, inside = strictly_inside(body, middle, size)
    if status != CAPPED and not inside:
        return GROWN, 0.0, 0.0
    if work[0].shape[0] == 0:
        return (STUCK if status == CAPPED else GROWN), 0.0, np.inf
    status, lower, upper = STUCK, 0.0, 0.0
    # Points of a smooth set share no plane by chance, and their spacing must stay above the jog.
    power = -7.0 if body[3].shape[0] == 0 else -10.0
    for attempt in range(12):
        jog = 10.0**power
        status, lower, upper, _ = nearest(body, turn, stop, 1e-2 * jog, jog, attempt, work)
        if status in (GROWN, FULL):
            return status, lower, upper
        if status in (COARSE, SMALL) or attempt % 3 == 2:
            power -= 1.0
        if power < -12.0:
            break
    if status == SMALL:
        return GROWN, 0.0, 0.0
    return status, lower, upper


@compiled
def _length(plane, turn):
    """Length of a plane's u before the set was turned."""
    total = 0.0
    for c in range(6):
        part = 0.0
        for r in range(6):
            part += turn[r, c] * plane[r]
        total += part * part
    return np.sqrt(total)


@compiled
def _height_of(planes, f, v):
    total = 0.0
    for r in range(6):
        total += planes[f, r] * v[r]
    return total


@compiled
def _exact_plane(f, facets, vertices, plane):
    """Solve u·v = 1 through the exact vertices of f; False when they do not span it."""
    matrix, inverse = np.empty((6, 6)), np.empty((6, 6))
    for k in range(6):
        for r in range(6):
            matrix[k, r] = vertices[facets[f, k], r]
    if not invert(matrix, inverse):
        return False
    for r in range(6):
        total = 0.0
        for k in range(6):
            total += inverse[r, k]
        plane[r] = total
    for k in range(6):
        total = 0.0
        for r in range(6):
            total += plane[r] * matrix[k, r]
        if not abs(total - 1.0) < 1e-9:
            return False
    return True
