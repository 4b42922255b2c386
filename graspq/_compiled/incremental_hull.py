"""Compiled convex hull of a set known by its support function, grown vertex by vertex.

The beneath-beyond method as Quickhull orders it (C. B. Barber, D. P. Dobkin and H. Huhdanpaa, "The
Quickhull algorithm for convex hulls", ACM TOMS 22, 1996): from a facet below the new vertex, the
visible facets are found through their neighbours; each ridge of the horizon around them makes a
facet with the vertex, and new facets are joined where they share a ridge.

The hull lives in six dimensions, in coordinates in which the set is about round, and always holds
the origin: a facet is the plane u·x = 1 through six vertices. It starts as a simplex of artificial
vertices too small to matter. A new facet through a ridge of a visible facet f and a hidden one g is
a convex combination of their u, so no linear system is solved. Vertices are jogged (moved by a
little at random), so that no seven of them share a plane; the exact ones decide in the end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.small_matrices import dot

GROWN, FULL, BROKEN = 0, 1, 2
# Vertices of the first simplex.
FIRST = 7

# ``plane``: u; ``vertices``, and the ``neighbours`` opposite them; ``stamp`` is the number of the
# last vertex that looked at the facet, negative where the facet is hidden from it; ``height`` is
# u·x of that vertex.
FACET = np.dtype(
    [
        ("plane", np.float64, (6,)),
        ("height", np.float64),
        ("vertices", np.int32, (6,)),
        ("neighbours", np.int32, (6,)),
        ("stamp", np.int64),
    ],
    align=True,
)
POINT = np.dtype([("exact", np.float64, (6,)), ("jogged", np.float64, (6,))])
# A ridge among new facets: its vertices as one number, and a facet and side, or none.
RIDGE = np.dtype([("key", np.int64), ("side", np.int64)])
NO_SIDE, JOINED = -1, -2
# How many of what there is.
TALLY = np.dtype(
    [
        (name, np.int64)
        for name in ("vertices", "facets", "free", "fresh", "visible", "horizon", "stamp")
    ]
)


class Hull(NamedTuple):
    """A hull, and room for it to grow; every array may be longer than what is in use.

    Attributes:
        tally: one record of ``TALLY``.
        vertices: records of ``POINT``.
        facets: records of ``FACET``.
        length: |u| of every facet before the set was made round; 0 where the facet is gone or
            done with.
        visible: facets below the new vertex.
        free: facets whose room may be used again.
        fresh: facets made last.
        horizon: ridges between the visible and the hidden facets: eight times the visible facet,
            and which of its neighbours lies behind.
        ridges: hash table of records of ``RIDGE``; its size is a power of two.
    """

    tally: np.ndarray
    vertices: np.ndarray
    facets: np.ndarray
    length: np.ndarray
    visible: np.ndarray
    free: np.ndarray
    fresh: np.ndarray
    horizon: np.ndarray
    ridges: np.ndarray


@compiled
def start(hull, tally, small):
    """Make the hull a regular simplex of inradius ``small``."""
    # Seven unit vectors with equal angles: columns of a Helmert matrix.
    for i in range(FIRST):
        point = hull.vertices[i]
        for r in range(6):
            value = 0.0
            if r + 1 > i:
                value = 1.0 / np.sqrt((r + 1.0) * (r + 2.0))
            elif r + 1 == i:
                value = -(r + 1.0) / np.sqrt((r + 1.0) * (r + 2.0))
            point.exact[r] = 6.0 * small * value * np.sqrt(7.0 / 6.0)
            point.jogged[r] = point.exact[r]
    for f in range(FIRST):
        facet = hull.facets[f]
        k = 0
        for i in range(FIRST):
            if i != f:
                facet.vertices[k] = i
                facet.neighbours[k] = i
                k += 1
        for r in range(6):
            # The facet opposite vertex f: its plane is u = -v_f / small / |v_f|.
            facet.plane[r] = -hull.vertices[f].exact[r] / (6.0 * small) / small
        facet.stamp = 0
    tally.vertices = FIRST
    tally.facets = FIRST
    tally.free = 0
    tally.stamp = 0


@compiled
def insert(hull, tally, first):
    """Add the vertex after the last, seen from facet ``first``; new facets are in ``fresh``."""
    new = tally.vertices
    tally.stamp += 1
    _look(hull, tally, first, hull.vertices[new].jogged)
    size = 64
    while size < 6 * tally.horizon:
        size *= 2
    if size > hull.ridges.shape[0] or tally.facets + tally.horizon > hull.facets.shape[0]:
        return FULL
    for i in range(size):
        hull.ridges[i].side = NO_SIDE
    open_sides = 0
    tally.fresh = 0
    for i in range(tally.horizon):
        f, k = hull.horizon[i] // 8, hull.horizon[i] % 8
        g = hull.facets[f].neighbours[k]
        made = _take_room(hull, tally)
        _make_facet(hull.facets[made], hull.facets[f], hull.facets[g], made, f, k, g, new)
        open_sides += _join(hull.facets, hull.ridges, made, size)
    for i in range(tally.visible):
        f = hull.visible[i]
        hull.length[f] = 0.0
        hull.free[tally.free] = f
        tally.free += 1
    tally.vertices += 1
    return GROWN if open_sides == 0 else BROKEN


@compiled
def _look(hull, tally, first, x):
    """List the facets that x is above, found through neighbours, and the horizon around them."""
    stamp = tally.stamp
    hull.visible[0] = first
    hull.facets[first].stamp = stamp
    hull.facets[first].height = dot(hull.facets[first].plane, x)
    depth, seen, ridges = 1, 0, 0
    while depth > seen:
        f = hull.visible[seen]
        seen += 1
        for k in range(6):
            g = hull.facets[f].neighbours[k]
            other = hull.facets[g]
            if abs(other.stamp) != stamp:
                height = dot(other.plane, x)
                other.height = height
                if height > 1.0:
                    other.stamp = stamp
                    hull.visible[depth] = g
                    depth += 1
                else:
                    other.stamp = -stamp
            if other.stamp == -stamp:
                # There is no room for the facets of a horizon that is longer than its list.
                if ridges < hull.horizon.shape[0]:
                    hull.horizon[ridges] = f * 8 + k
                ridges += 1
    tally.visible, tally.horizon = depth, ridges


@compiled
def _take_room(hull, tally):
    """Number of a facet that is not in use, now the last of ``fresh``."""
    if tally.free > 0:
        tally.free -= 1
        made = np.int64(hull.free[tally.free])
    else:
        made = tally.facets
        tally.facets += 1
    hull.fresh[tally.fresh] = made
    tally.fresh += 1
    return made


@compiled
def _make_facet(facet, below, hidden, made, f, k, g, new):
    """Make the facet of vertex ``new`` and the ridge opposite the vertex k of the one below.

    ``made``, ``f`` and ``g`` are the numbers of the facet, the one below the vertex and the hidden
    one. (Three records are passed as three pointers; the hull would be passed as sixty numbers.)
    """
    share = (1.0 - hidden.height) / (below.height - hidden.height)
    for r in range(6):
        facet.plane[r] = share * below.plane[r] + (1.0 - share) * hidden.plane[r]
    place = 0
    for m in range(6):
        if m != k:
            facet.vertices[place] = below.vertices[m]
            place += 1
    facet.vertices[5] = new
    facet.neighbours[5] = g
    facet.stamp = 0
    for m in range(6):
        if hidden.neighbours[m] == f:
            # f and g may be neighbours twice; this side of g lies opposite what f lacks.
            common = False
            for i in range(6):
                common = common or below.vertices[i] == hidden.vertices[m]
            if not common:
                hidden.neighbours[m] = made


@compiled
def _join(facets, ridges, made, size):
    """Join a new facet to others where both have four vertices and the new one in common.

    Returns the change in the number of sides that have no neighbour yet.
    """
    change = 0
    facet = facets[made]
    for side in range(5):
        # A facet's vertices are in ascending order, so that the ridge has one name; at most 2¹⁵
        # vertices make it one number.
        key = np.int64(0)
        for m in range(5):
            if m != side:
                key = key * 32768 + facet.vertices[m]
        # Multiplicative hashing (D. E. Knuth, TAOCP 3, 6.4), open addressing.
        at = np.int64((np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(40))
        at &= size - 1
        while True:
            ridge = ridges[at]
            if ridge.side == NO_SIDE:
                ridge.side = made * 8 + side
                ridge.key = key
                change += 1
                break
            if ridge.key == key and ridge.side >= 0:
                other, back = ridge.side // 8, ridge.side % 8
                facet.neighbours[side] = other
                facets[other].neighbours[back] = made
                ridge.side = JOINED
                change -= 1
                break
            at = (at + 1) & (size - 1)
    return change


@compiled
def is_vertex(hull, tally, x):
    """Whether x is a vertex of the hull already."""
    for i in range(tally.vertices):
        far = 0.0
        for r in range(6):
            far = max(far, abs(hull.vertices[i].exact[r] - x[r]))
        if far <= 1e-13:
            return True
    return False


@compiled
def jog(point, index, most, seed):
    """Move a vertex by a reproducible random amount up to ``most`` per row.

    Random numbers are those of xorshift64* (S. Vigna, ACM TOMS 42, 2016).
    """
    x = np.uint64(index + 1) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed)
    for r in range(6):
        x ^= x >> np.uint64(12)
        x ^= x << np.uint64(25)
        x ^= x >> np.uint64(27)
        part = np.int64((x * np.uint64(0x2545F4914F6CDD1D)) >> np.uint64(33)) / 2147483648.0
        point.jogged[r] = point.exact[r] + most * (2.0 * part - 1.0)
