"""Compiled entry: ε of many grasps, or of one; it runs without the interpreter's lock."""

from __future__ import annotations

import numpy as np

from graspq._compiled.body import Bodies
from graspq._compiled.body_reading import largest, take
from graspq._compiled.incremental_hull import FACET, POINT, RIDGE, TALLY, Hull
from graspq._compiled.inscribed_ball import grow
from graspq._compiled.jit import entry
from graspq._compiled.workspace import CANDIDATES, PART_ROWS, Workspace

STATUS, LOWER, UPPER, RESULTS = range(4)
MOST_RIDGES = 1 << 20


def new_hull(facets: int, vertices: int) -> Hull:
    """Return room for a hull of so many facets and vertices."""
    # Six places or more per ridge of the horizon keep the hash table sparse; no horizon has more
    # ridges than this has room for.
    ridges = min(1 << int(6 * facets - 1).bit_length(), MOST_RIDGES)
    return Hull(
        np.zeros(1, TALLY),
        np.empty(vertices, POINT),
        np.empty(facets, FACET),
        np.empty(facets),
        np.empty(facets, np.int32),
        np.empty(facets, np.int32),
        np.empty(facets, np.int32),
        np.empty(facets, np.int32),
        np.empty(ridges, RIDGE),
    )


@entry
def balls_in_bodies(
    points,
    first_point,
    centres,
    axes,
    first_ellipsoid,
    first_set,
    holds_origin,
    turns,
    stop,
    most_jog,
    seed,
    results,
    states,
    tally,
    vertices,
    facets,
    length,
    visible,
    free,
    fresh,
    horizon,
    ridges,
):
    """Find the largest ball around the origin in each body, which must hold it strictly inside.

    Args:
        points, ..., holds_origin: ``Bodies``, each about round.
        turns: the map that made each of them round, shape (N, 6, 6).
        stop: relative gap between the bounds at which a smooth body is accurate enough.
        most_jog: what vertices are moved by, per row; ``seed`` of the random numbers.
        results: receives status, lower and upper bound, shape (N, 3).
        states: one record of ``STATE``, scratch.
        tally, ..., ridges: ``Hull``, scratch.
    """
    bodies = Bodies(points, first_point, centres, axes, first_ellipsoid, first_set, holds_origin)
    hull = Hull(tally, vertices, facets, length, visible, free, fresh, horizon, ridges)
    columns, sets = largest(first_point, first_set)
    parts = np.empty((PART_ROWS, sets), np.int64)
    candidates = np.empty((sets, 1 + CANDIDATES), np.int64)
    work = Workspace(states[0], parts, candidates, np.empty(columns))
    own, own_first = np.empty((6, columns)), np.empty(sets + 1, np.int64)
    shift = np.empty(6)
    for r in range(6):
        shift[r] = 0.0
    for g in range(first_set.shape[0] - 1):
        body = take(bodies, g, shift, own, own_first)
        status, lower, upper = grow(hull, tally[0], body, work, turns[g], stop, most_jog, seed)
        results[g, STATUS], results[g, LOWER], results[g, UPPER] = status, lower, upper
