"""Compiled volume of a Minkowski sum from its facets, each a sum of faces.

In general position the faces F_i of a facet have dimensions that add up to five, and
V = 1/6 Σ h(u) vol(F_1 + ... + F_n). Faces whose dimensions add up to four leave a plane of
normals, in which those that support all the faces form a wedge; along it the other bodies'
outlines are walked, and every edge met completes a facet. An edge that is walked belongs to a
later body than the edges that were chosen, so every facet is met once.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry

ROUND_OFF = 1e-13


@compiled
def _push(rows, used, vertices, base, basis, dim):
    """Add a face's directions to the orthonormal rows; return (rows used, volume factor)."""
    factor = 1.0
    for k in range(dim):
        for c in range(6):
            rows[used, c] = vertices[basis[k], c] - vertices[base, c]
        for _ in range(2):
            for r in range(used):
                along = 0.0
                for c in range(6):
                    along += rows[r, c] * rows[used, c]
                for c in range(6):
                    rows[used, c] -= along * rows[r, c]
        length = 0.0
        for c in range(6):
            length += rows[used, c] * rows[used, c]
        length = np.sqrt(length)
        if length < ROUND_OFF:
            return used, 0.0
        for c in range(6):
            rows[used, c] /= length
        used += 1
        factor *= length
    return used, factor


@compiled
def _complement(rows, used):
    """Complete four (or five) orthonormal rows to six."""
    while used < 6:
        pick, best = 0, -1.0
        for c in range(6):
            left = 1.0
            for r in range(used):
                left -= rows[r, c] * rows[r, c]
            if left > best:
                pick, best = c, left
        rows[used, :] = 0.0
        rows[used, pick] = 1.0
        length = 0.0
        for _ in range(2):
            for r in range(used):
                along = 0.0
                for c in range(6):
                    along += rows[r, c] * rows[used, c]
                for c in range(6):
                    rows[used, c] -= along * rows[r, c]
            length = 0.0
            for c in range(6):
                length += rows[used, c] * rows[used, c]
            length = np.sqrt(length)
            for c in range(6):
                rows[used, c] /= length
        used += 1


@compiled
def _dot(a, i, b, j):
    return (
        a[i, 0] * b[j, 0]
        + a[i, 1] * b[j, 1]
        + a[i, 2] * b[j, 2]
        + a[i, 3] * b[j, 3]
        + a[i, 4] * b[j, 4]
        + a[i, 5] * b[j, 5]
    )


@compiled
def _wedge(rows, chosen, count, polytopes, wedge):
    """Normals in the plane of rows 4, 5 that support the chosen faces; False when none."""
    vertices, _, _, _, base, _, _, cover_first, cover = polytopes
    open_ = True
    cx, cy = 0.0, 0.0
    for i in range(count):
        f = chosen[i, 1]
        b = base[f]
        bx, by = _dot(vertices, b, rows, 4), _dot(vertices, b, rows, 5)
        for k in range(cover_first[f], cover_first[f + 1]):
            ax = _dot(vertices, cover[k], rows, 4) - bx
            ay = _dot(vertices, cover[k], rows, 5) - by
            if open_:
                # The half plane u·a <= 0, from its start counter-clockwise to its end.
                size = np.sqrt(ax * ax + ay * ay)
                if size == 0.0:
                    continue
                cx, cy = -ax / size, -ay / size
                wedge[0], wedge[1], wedge[2], wedge[3] = cy, -cx, -cy, cx
                open_ = False
                continue
            start = wedge[0] * ax + wedge[1] * ay
            end = wedge[2] * ax + wedge[3] * ay
            if start <= 0.0 and end <= 0.0:
                # A half plane's both ends may agree while it is cut to a ray; that ray is
                # on the boundary and has no width.
                continue
            if start >= 0.0 and end >= 0.0:
                return False, False
            dx, dy = -ay, ax
            if dx * cx + dy * cy < 0.0:
                dx, dy = -dx, -dy
            size = np.sqrt(dx * dx + dy * dy)
            if start > 0.0:
                wedge[0], wedge[1] = dx / size, dy / size
            else:
                wedge[2], wedge[3] = dx / size, dy / size
    return True, open_


@compiled
def _walk(rows, chosen, count, polytopes, px, py, rx, ry, size, flat):
    """Sum of h·vol over the facets that edges met between directions p and r complete."""
    vertices, vertex_first, _, _, base, _, _, _, _ = polytopes
    bodies = vertex_first.shape[0] - 1
    last = -1
    total = 0.0
    fixed_x, fixed_y = 0.0, 0.0
    for i in range(count):
        b = base[chosen[i, 1]]
        fixed_x += _dot(vertices, b, rows, 4)
        fixed_y += _dot(vertices, b, rows, 5)
        if chosen[i, 2] == 1:
            last = max(last, chosen[i, 0])
    for m in range(bodies):
        taken = False
        for i in range(count):
            taken = taken or chosen[i, 0] == m
        for k in range(vertex_first[m], vertex_first[m + 1]):
            flat[k, 2] = 1.0 if taken else 0.0
            if not taken:
                flat[k, 0] = _dot(vertices, k, rows, 4)
                flat[k, 1] = _dot(vertices, k, rows, 5)
    for m in range(last + 1, bodies):
        begin, end = vertex_first[m], vertex_first[m + 1]
        if flat[begin, 2] == 1.0:
            continue
        at, best, second = begin, -np.inf, -np.inf
        for k in range(begin, end):
            value = flat[k, 0] * px + flat[k, 1] * py
            later = flat[k, 0] * rx + flat[k, 1] * ry
            if value > best or (value == best and later > second):
                at, best, second = k, value, later
        for _ in range(end - begin):
            following, ux, uy = -1, 0.0, 0.0
            for k in range(begin, end):
                dx, dy = flat[k, 0] - flat[at, 0], flat[k, 1] - flat[at, 1]
                gain = dx * rx + dy * ry
                if gain <= 0.0:
                    continue
                loss = min(dx * px + dy * py, 0.0)
                # Where vertex k overtakes, as a combination of p and r.
                vx, vy = gain * px - loss * rx, gain * py - loss * ry
                if following >= 0:
                    turn = ux * vy - uy * vx
                    if turn > 0.0:
                        continue
                    if turn == 0.0:
                        old = (flat[following, 0] - flat[at, 0]) * rx + (
                            flat[following, 1] - flat[at, 1]
                        ) * ry
                        if gain <= old:
                            continue
                following, ux, uy = k, vx, vy
            if following < 0:
                break
            length = np.sqrt(ux * ux + uy * uy)
            ux, uy = ux / length, uy / length
            edge_x = flat[following, 0] - flat[at, 0]
            edge_y = flat[following, 1] - flat[at, 1]
            height = ux * (fixed_x + flat[at, 0]) + uy * (fixed_y + flat[at, 1])
            for o in range(bodies):
                if o != m and flat[vertex_first[o], 2] == 0.0:
                    top = -np.inf
                    for k in range(vertex_first[o], vertex_first[o + 1]):
                        top = max(top, ux * flat[k, 0] + uy * flat[k, 1])
                    height += top
            total += height * np.sqrt(edge_x * edge_x + edge_y * edge_y)
            at = following
    return total * size


@compiled
def _plane(rows, chosen, count, polytopes, size, wedge, flat):
    """Contribution of faces whose dimensions add up to four."""
    _complement(rows, 4)
    some, open_ = _wedge(rows, chosen, count, polytopes, wedge)
    if not some:
        return 0.0
    if open_:
        total = 0.0
        for q in range(4):
            px, py = (1.0, 0.0) if q % 2 == 0 else (0.0, 1.0)
            if q >= 2:
                px, py = -px, -py
            total += _walk(rows, chosen, count, polytopes, px, py, -py, px, size, flat)
        return total
    px, py, rx, ry = wedge[0], wedge[1], wedge[2], wedge[3]
    if px * rx + py * ry < 0.0:
        # More than a right angle: two walks keep the combinations of p and r well apart.
        return _walk(rows, chosen, count, polytopes, px, py, -py, px, size, flat) + _walk(
            rows, chosen, count, polytopes, -py, px, rx, ry, size, flat
        )
    return _walk(rows, chosen, count, polytopes, px, py, rx, ry, size, flat)


@compiled
def _single(rows, chosen, count, polytopes, size):
    """Contribution of faces whose dimensions add up to five: one normal and its opposite."""
    vertices, vertex_first, _, _, base, _, _, cover_first, cover = polytopes
    _complement(rows, 5)
    total = 0.0
    for sign in (1.0, -1.0):
        good, height = True, 0.0
        for i in range(count):
            f = chosen[i, 1]
            level = sign * _dot(vertices, base[f], rows, 5)
            height += level
            for k in range(cover_first[f], cover_first[f + 1]):
                if sign * _dot(vertices, cover[k], rows, 5) > level:
                    good = False
        if not good:
            continue
        for m in range(vertex_first.shape[0] - 1):
            taken = False
            for i in range(count):
                taken = taken or chosen[i, 0] == m
            if not taken:
                top = -np.inf
                for k in range(vertex_first[m], vertex_first[m + 1]):
                    top = max(top, sign * _dot(vertices, k, rows, 5))
                height += top
        total += height * size
    return total


@entry
def sum_volume(polytopes, wanted):
    """Volume of the sum of ``polytopes`` = (vertices, vertex_first, face_first, _, base, ...).

    ``wanted`` lists patterns of dimensions, one per row, in the order in which the bodies'
    faces are chosen; equal dimensions take rising bodies.
    """
    vertices, _, face_first, _, _, _, _, _, _ = polytopes
    bodies = face_first.shape[0]
    rows, wedge = np.empty((6, 6)), np.empty(4)
    flat = np.empty((vertices.shape[0], 3))
    chosen = np.zeros((4, 3), np.int64)
    total = 0.0
    for p in range(wanted.shape[0]):
        total += _choose(rows, chosen, polytopes, wanted[p], bodies, wedge, flat)
    return total / 6.0


@compiled
def _choose(rows, chosen, polytopes, pattern, bodies, wedge, flat):
    """Run through the faces of one pattern, depth first, without recursion."""
    vertices, _, face_first, _, base, basis, volume, _, _ = polytopes
    total_dim, length = 0, 0
    for k in range(4):
        if pattern[k] > 0:
            length += 1
            total_dim += pattern[k]
    body, face = np.zeros(4, np.int64), np.zeros(4, np.int64)
    filled, factor = np.zeros(5, np.int64), np.ones(5)
    body[0], face[0] = 0, -1
    total = 0.0
    depth = 0
    while depth >= 0:
        dim = pattern[depth]
        b = body[depth]
        first, end = face_first[b, dim], face_first[b, dim + 1]
        taken = False
        for k in range(depth):
            taken = taken or body[k] == b
        if total_dim == 4 and dim == 1 and not taken:
            # An edge must leave a later body to walk.
            later = bodies - 1 - b
            for k in range(depth):
                later -= 1 if body[k] > b else 0
            taken = later <= 0
        face[depth] = first if face[depth] < 0 else face[depth] + 1
        if taken or face[depth] >= end:
            body[depth] += 1
            face[depth] = -1
            if body[depth] >= bodies:
                depth -= 1
            continue
        f = face[depth]
        used, scale = _push(rows, filled[depth], vertices, base[f], basis[f], dim)
        if scale == 0.0:
            continue
        filled[depth + 1] = used
        factor[depth + 1] = factor[depth] * scale * volume[f]
        chosen[depth, 0], chosen[depth, 1], chosen[depth, 2] = b, f, dim
        if depth + 1 < length:
            depth += 1
            face[depth] = -1
            body[depth] = 0
            if pattern[depth] == dim:
                body[depth] = b + 1
            if body[depth] >= bodies:
                depth -= 1
            continue
        if total_dim == 4:
            total += _plane(rows, chosen, length, polytopes, factor[length], wedge, flat)
        else:
            total += _single(rows, chosen, length, polytopes, factor[length])
    return total
