"""Compiled convex hull of a set known by its support oracle, grown facet by facet.

The hull lives in six dimensions, in coordinates in which the set is about round, and always
holds the origin: a facet is the plane u·x = 1 through six vertices. It starts from a simplex of
artificial vertices too small to matter. A new facet through a ridge of a visible facet f and a
hidden one g is a convex combination of their u, so no linear system is solved. Vertices are
jogged by ``jog``, so that no seven of them share a plane; exact vertices decide in the end.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled

GROWN, FULL, BROKEN = 0, 1, 2
ALIVE, DONE = 1, 2


@compiled
def simplex(small, vertices, jogged, facets, links, planes, state):
    """Start the hull as a regular simplex of inradius ``small``; return the counts."""
    # Seven unit vectors with equal angles: columns of a Helmert matrix.
    for i in range(7):
        for r in range(6):
            value = 0.0
            if r + 1 > i:
                value = 1.0 / np.sqrt((r + 1.0) * (r + 2.0))
            elif r + 1 == i:
                value = -(r + 1.0) / np.sqrt((r + 1.0) * (r + 2.0))
            vertices[i, r] = jogged[i, r] = 6.0 * small * value * np.sqrt(7.0 / 6.0)
    for f in range(7):
        k = 0
        for i in range(7):
            if i != f:
                facets[f, k], links[f, k] = i, i
                k += 1
        for r in range(6):
            # The facet opposite vertex f: its plane is u = -v_f / small / |v_f|.
            planes[f, r] = -vertices[f, r] / (6.0 * small) / small
        state[f] = ALIVE
    return 7, 7


@compiled
def insert(
    count,
    first,
    top,
    jogged,
    facets,
    links,
    planes,
    state,
    mark,
    stamp,
    stack,
    edge,
    free,
    free_count,
    table,
    tags,
    fresh,
):
    """Add vertex ``count`` seen from facet ``first``; return (status, top, free, new facets)."""
    v = jogged[count]
    depth, seen, ridges = 1, 0, 0
    stack[0] = first
    mark[first] = stamp
    height = edge[0]
    height[first] = _height(planes, first, v)
    # Visible facets, found through their neighbours, and the ridges around them.
    while depth > seen:
        f = stack[seen]
        seen += 1
        for k in range(6):
            g = links[f, k]
            if mark[g] == stamp or mark[g] == -stamp:
                continue
            height[g] = _height(planes, g, v)
            if height[g] > 1.0:
                mark[g] = stamp
                stack[depth] = g
                depth += 1
            else:
                mark[g] = -stamp
    made = 0
    size = 64
    for i in range(depth):
        for k in range(6):
            if mark[links[stack[i], k]] == -stamp:
                ridges += 1
    while size < 12 * ridges:
        size *= 2
    if size > table.shape[0] or top + ridges > facets.shape[0]:
        return FULL, top, free_count, 0
    table[:size] = -1
    open_sides = 0
    for i in range(depth):
        f = stack[i]
        for k in range(6):
            g = links[f, k]
            if mark[g] != -stamp:
                continue
            if free_count > 0:
                free_count -= 1
                new = free[free_count]
            else:
                new = top
                top += 1
            fresh[made] = new
            made += 1
            share = (1.0 - height[g]) / (height[f] - height[g])
            for r in range(6):
                planes[new, r] = share * planes[f, r] + (1.0 - share) * planes[g, r]
            spot = 0
            for m in range(6):
                if m != k:
                    facets[new, spot] = facets[f, m]
                    spot += 1
            facets[new, 5] = count
            links[new, 5] = g
            for m in range(6):
                if links[g, m] == f and _opposite(facets, g, m, f):
                    links[g, m] = new
            state[new] = ALIVE
            mark[new] = 0
            open_sides += _join(new, facets, links, table, tags, size)
    for i in range(depth):
        f = stack[i]
        state[f] = 0
        free[free_count] = f
        free_count += 1
    return (GROWN if open_sides == 0 else BROKEN), top, free_count, made


@compiled
def _height(planes, f, v):
    return (
        planes[f, 0] * v[0]
        + planes[f, 1] * v[1]
        + planes[f, 2] * v[2]
        + planes[f, 3] * v[3]
        + planes[f, 4] * v[4]
        + planes[f, 5] * v[5]
    )


@compiled
def _opposite(facets, g, m, f):
    """Whether vertex m of g is the one that facet f lacks."""
    lacking = facets[g, m]
    found = False
    for k in range(6):
        found = found or facets[f, k] == lacking
    return not found


@compiled
def _join(new, facets, links, table, tags, size):
    """Link ``new`` to its neighbours among the new facets by shared four vertices.

    Returns the change in the number of sides still open.
    """
    change = 0
    for drop in range(5):
        a, b, c, d = -1, -1, -1, -1
        for m in range(5):
            if m != drop:
                a, b, c, d = b, c, d, facets[new, m]
        if a > b:
            a, b = b, a
        if c > d:
            c, d = d, c
        if a > c:
            a, c = c, a
        if b > d:
            b, d = d, b
        if b > c:
            b, c = c, b
        key = ((np.int64(a) * 32768 + b) * 32768 + c) * 32768 + d
        mix = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
        at = np.int64(mix >> np.uint64(40)) & (size - 1)
        while True:
            held = table[at]
            if held == -1:
                table[at] = new * 8 + drop
                tags[at] = key
                change += 1
                break
            if tags[at] == key and held >= 0:
                other, side = held // 8, held % 8
                links[new, drop] = other
                links[other, side] = new
                tags[at] = -1
                change -= 1
                break
            at = (at + 1) & (size - 1)
    return change


@compiled
def known(vertex, vertices, count):
    """Index of ``vertex`` among the hull's, or -1."""
    for i in range(count):
        far = 0.0
        for r in range(6):
            far = max(far, abs(vertices[i, r] - vertex[r]))
        if far <= 1e-13:
            return i
    return -1


@compiled
def jog_vertex(vertex, index, jog, seed, out):
    """Move a vertex by a reproducible random amount up to ``jog`` per row."""
    x = np.uint64(index + 1) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed)
    for r in range(6):
        x ^= x >> np.uint64(12)
        x ^= x << np.uint64(25)
        x ^= x >> np.uint64(27)
        part = np.int64((x * np.uint64(0x2545F4914F6CDD1D)) >> np.uint64(33)) / 2147483648.0
        out[r] = vertex[r] + jog * (2.0 * part - 1.0)
