"""Normal cones of faces, seen in the orthogonal complement of the directions of those faces.

A face with a vertex v supports direction u where u·(w - v) <= 0 for one vertex w out of every face
that covers it (has it as a facet); each w - v is a *cut*. In a complement of three dimensions the
directions that support several faces form a cone, kept as its rays, and the directions that support
an edge inside it form an arc. Cones are cut by one half-space after the other (Sutherland and
Hodgman: Reentrant polygon clipping, 1974).

Rows are passed as an array and a number: a view of a row costs more than what is done with it.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.polytopes import BASE, BASIS, COVER, COVERS, ZERO


@compiled
def between(a, i, j, height_i, height_j, out, k):
    """Row k of ``out``: where heights of opposite signs meet 0 between rows i and j of ``a``."""
    share = abs(height_i) / (abs(height_i) + abs(height_j))
    for c in range(3):
        out[k, c] = a[i, c] + share * (a[j, c] - a[i, c])


@compiled
def start_cone(rays, number):
    """The cone over face ``number`` (0 to 3) of a regular tetrahedron; the four fill the space."""
    count = ZERO
    for corner in range(4):
        if corner != number:
            for c in range(3):
                rays[count, c] = 1.0 if corner == 0 or corner == c + 1 else -1.0
            count += 1
    return count


@compiled
def cut_cone(rays, first, count, cuts, k):
    """Cut the cone of ``count`` rays by u·cuts[k] <= 0; return its first ray and their number.

    What is left takes the other half of ``rays`` when it has other rays.
    """
    above, kept, last = ZERO, (rays.shape[0] // 2 if first == 0 else ZERO), first + count - 1
    for i in range(first, first + count):
        rays[i, 3] = rays[i, 0] * cuts[k, 0] + rays[i, 1] * cuts[k, 1] + rays[i, 2] * cuts[k, 2]
        above += rays[i, 3] > 0.0
    if above == 0 or above == count:
        return first, count - above
    start = kept
    for i in range(first, first + count):
        if (rays[i, 3] > 0.0) != (rays[last, 3] > 0.0):
            between(rays, last, i, rays[last, 3], rays[i, 3], rays, kept)
            kept += 1
        if rays[i, 3] <= 0.0:
            for c in range(3):
                rays[kept, c] = rays[i, c]
            kept += 1
        last = i
    return start, kept - start


@compiled
def hide_vertices(rays, first, count, flat, begin, end, levels):
    """Find the heights of vertices along rays, and hide vertices: those that are below another.

    A vertex that is nowhere higher than another one along the rays is nowhere higher inside the
    cone; it is compared with those that are highest along a ray. ``flat[k, 3]`` is 1 for a hidden
    vertex. Returns how many are not hidden.
    """
    seen = end - begin
    for k in range(begin, end):
        flat[k, 3] = 0.0
        for i in range(count):
            total = 0.0
            for c in range(3):
                total += rays[first + i, c] * flat[k, c]
            levels[k, i] = total
    for i in range(count):
        highest = begin
        for k in range(begin, end):
            if levels[k, i] > levels[highest, i]:
                highest = k
        for k in range(begin, end):
            r = 0 if k != highest and flat[k, 3] == 0.0 else count + 1
            while r < count and levels[k, r] <= levels[highest, r]:
                r += 1
            if r == count:
                flat[k, 3] = 1.0
                seen -= 1
    return seen


@compiled
def edge_arc(rays, first, count, faces, e, flat, levels, arcs, arc):
    """Whether edge e has normals inside the cone; its arc receives them.

    An arc is three rows of ``arcs``: its two ends and the direction of its edge.
    """
    base, other = faces[e, BASE], faces[e, BASIS]
    for c in range(3):
        arcs[arc + 2, c] = flat[other, c] - flat[base, c]
    # The plane across the edge meets the cone where one end is higher, then the other.
    ends, last, before = arc, count - 1, levels[other, count - 1] - levels[base, count - 1]
    for i in range(count):
        height = levels[other, i] - levels[base, i]
        if (before > 0.0) != (height > 0.0) and ends < arc + 2:
            between(rays, first + last, first + i, before, height, arcs, ends)
            ends += 1
        last, before = i, height
    if ends < arc + 2:
        return False
    for k in range(COVER, COVER + faces[e, COVERS]):
        start, end, cover = 0.0, 0.0, faces[e, k]
        for c in range(3):
            cut = flat[cover, c] - flat[base, c]
            start += cut * arcs[arc, c]
            end += cut * arcs[arc + 1, c]
        if start > 0.0 and end > 0.0:
            return False
        if start > 0.0 or end > 0.0:
            between(arcs, arc, arc + 1, start, end, arcs, arc if start > 0.0 else arc + 1)
    return True


@compiled
def crossing(arcs, i, j, u):
    """The area that the edges of two arcs span, and the unit normal where they cross; or 0."""
    i_start, i_end, j_start, j_end = 0.0, 0.0, 0.0, 0.0
    for c in range(3):
        i_start += arcs[i, c] * arcs[j + 2, c]
        i_end += arcs[i + 1, c] * arcs[j + 2, c]
        j_start += arcs[j, c] * arcs[i + 2, c]
        j_end += arcs[j + 1, c] * arcs[i + 2, c]
    if (i_start > 0.0) == (i_end > 0.0) or (j_start > 0.0) == (j_end > 0.0):
        return 0.0
    share, side, area, a, b = i_start / (i_start - i_end), 0.0, 0.0, 1, 2
    for c in range(3):
        u[c] = arcs[i + 2, a] * arcs[j + 2, b] - arcs[i + 2, b] * arcs[j + 2, a]
        a, b = b, c
        area += u[c] * u[c]
        side += u[c] * (arcs[i, c] + share * (arcs[i + 1, c] - arcs[i, c]))
    # The normal is along the cross product of the edges, on the side of the arcs.
    area = np.sqrt(area)
    for c in range(3):
        u[c] /= area if side > 0.0 else -area
    return area
