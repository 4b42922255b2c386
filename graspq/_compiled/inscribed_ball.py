"""Compiled ε: grow the hull at its nearest facet until that facet supports the set.

ε is the radius of the largest ball around the origin inside the wrench space (C. Ferrari and J.
Canny, "Planning optimal grasps", ICRA 1992): the distance of the nearest facet. Only that facet has
to be right, so the hull is grown through the support function where it is nearest, which takes some
dozens of vertices instead of all sums of the contacts' own (as Y. Zheng, "An efficient algorithm
for a grasp quality measure", IEEE Transactions on Robotics 29, 2013, does).
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.incremental_hull import FIRST, FULL, GROWN, insert, is_vertex, jog, start
from graspq._compiled.jit import compiled
from graspq._compiled.small_matrices import dot, invert_in_place
from graspq._compiled.support_function import support

STUCK, ARTIFICIAL_LEFT, COARSE = 3, 4, 5
# A facet supports the set when no point is further out by more than round-off; where jogged and
# exact vertices disagree about a sliver, by more than this.
SUPPORTS, NEARLY = 1e-12, 1e-9
# Inradius of the first simplex in units of the jog.
SIMPLEX = 1e-2
# What jogging may move a facet by, relative to its distance, before a smaller jog is asked for.
MOST_NOISE = 1e-4
# Rounds per vertex that there is room for, as a facet done with adds none.
ROUNDS = 20


@compiled
def grow(hull, tally, body, work, turn, stop, most_jog, seed):
    """Return (status, lower, upper) of the largest ball around the origin.

    The origin must lie strictly inside the set, which is round: ``turn`` took it there, and
    lengths are those before. ``lower`` is the distance of the nearest facet of the hull and
    ``upper`` the support of its normal; they meet within ``stop``. ``COARSE`` asks for a smaller
    jog; ``ARTIFICIAL_LEFT`` says that a vertex of the first simplex is still on that facet.
    """
    state = work.state
    u, vertex = state.u, state.vertex
    start(hull, tally, SIMPLEX * most_jog)
    for f in range(FIRST):
        hull.length[f] = _length(hull.facets[f].plane, turn)
    upper, confirmed, lower = np.inf, np.inf, 0.0
    for _ in range(ROUNDS * hull.vertices.shape[0]):
        f = _nearest(hull, tally)
        if f < 0:
            break
        lower = 1.0 / hull.length[f]
        facet = hull.facets[f]
        artificial, noise = False, 0.0
        for k in range(6):
            artificial = artificial or facet.vertices[k] < FIRST
            noise += most_jog * abs(facet.plane[k])
        coarse = noise > MOST_NOISE and not artificial
        if confirmed < np.inf and lower > confirmed * (1.0 + 10.0 * noise):
            break
        exact = not artificial and _exact_plane(hull, facet, state)
        for r in range(6):
            u[r] = u[r] if exact else facet.plane[r]
        h = support(u, body, work, vertex)
        if h <= 0.0:
            return ARTIFICIAL_LEFT, 0.0, 0.0
        reach = h / _length(u, turn)
        upper = min(upper, reach)
        if exact and h <= 1.0 + SUPPORTS:
            if coarse:
                return COARSE, lower, upper
            confirmed = min(confirmed, reach)
            hull.length[f] = 0.0
            continue
        if stop > SUPPORTS and upper - lower <= stop * upper and not artificial:
            return GROWN, lower, upper
        if tally.vertices >= hull.vertices.shape[0]:
            return FULL, lower, upper
        grows = _raises(hull, tally, facet, vertex, most_jog, seed)
        if exact and not grows:
            # An exact plane through a sliver points anywhere: ask along the jogged one.
            support(facet.plane, body, work, vertex)
            grows = _raises(hull, tally, facet, vertex, most_jog, seed)
        if grows:
            status = insert(hull, tally, f)
            if status != GROWN:
                return status, lower, upper
            for i in range(tally.fresh):
                fresh = hull.fresh[i]
                hull.length[fresh] = _length(hull.facets[fresh].plane, turn)
            continue
        if artificial:
            return ARTIFICIAL_LEFT, 0.0, upper
        if coarse:
            return COARSE, lower, upper
        if exact and h <= 1.0 + NEARLY:
            confirmed = min(confirmed, reach)
        hull.length[f] = 0.0
    if confirmed > upper * (1.0 + SUPPORTS):
        # Some direction reaches less far than the facets that were found.
        return STUCK, confirmed, upper
    return GROWN, confirmed, confirmed


@compiled
def _nearest(hull, tally):
    """The facet nearest the origin, which has the longest u; -1 when all are done with."""
    f, most = -1, 0.0
    for g in range(tally.facets):
        if hull.length[g] > most:
            f, most = g, hull.length[g]
    return f


@compiled
def _raises(hull, tally, facet, vertex, most_jog, seed):
    """Put a vertex after the last and tell whether it is new and lies above the facet."""
    if is_vertex(hull, tally, vertex):
        return False
    point = hull.vertices[tally.vertices]
    for r in range(6):
        point.exact[r] = vertex[r]
    jog(point, tally.vertices, most_jog, seed)
    return dot(facet.plane, point.jogged) > 1.0


@compiled
def _length(plane, turn):
    """Length of a plane's u before the set was turned."""
    u0, u1, u2, u3, u4, u5 = plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]
    total = 0.0
    for c in range(6):
        part = (
            u0 * turn[0, c]
            + u1 * turn[1, c]
            + u2 * turn[2, c]
            + u3 * turn[3, c]
            + u4 * turn[4, c]
            + u5 * turn[5, c]
        )
        total += part * part
    return np.sqrt(total)


@compiled
def _exact_plane(hull, facet, state):
    """Solve u·v = 1 through a facet's exact vertices; False when they do not span it."""
    for k in range(6):
        exact = hull.vertices[facet.vertices[k]].exact
        for r in range(6):
            state.basis[k, r] = state.matrix[k, r] = exact[r]
    if not invert_in_place(state.matrix, state.inverse, 0.0):
        return False
    for r in range(6):
        total = 0.0
        for k in range(6):
            total += state.inverse[r, k]
        state.u[r] = total
    worst = 0.0
    for k in range(6):
        off = abs(dot(state.u, state.basis[k]) - 1.0)
        # An entry that is no number counts as far off.
        worst = worst if off <= worst else off
    return worst < NEARLY
