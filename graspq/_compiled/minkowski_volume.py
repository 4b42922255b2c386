"""Volume of a Minkowski sum of polytopes in R⁶ from its facets, each a sum of faces.

A face of P_1 + ... + P_n in direction u is the sum of the faces F_i of the P_i in direction u, and
in general position the dimensions of the F_i of a facet add up to five (Schneider: Convex Bodies,
1993, theorem 1.7.5; Gruber: Convex and Discrete Geometry, 2007, chapter 6; Fukuda: From the
zonotope construction to the Minkowski addition of convex polytopes, 2004). With the support
function h(u) = Σ h_i(u) of the sum and the outer unit normals u of the facets,

    V = 1/6 Σ h(u) vol₅(F_1 + ... + F_n),     vol₅ = Π vol(F_i) |det of the stacked bases|.

Faces go together when some u is inside the normal cones of all. All faces but up to two edges are
chosen one after the other, and what their normals leave is searched in the orthogonal complement
of their directions:

    dimensions 3 (3; 2+1; 1+1+1)    a cone in space: two edges of two more bodies, whose normals
                                    are arcs on the sphere, complete a facet where they cross
    dimensions 4 (4; 2+2)           a wedge in a plane: an edge of one more body completes it
    dimensions 5 (5; 3+2)           a line: its two directions

The edges that complete a facet belong to later bodies than the edges that were chosen, so every
facet is met once. The area vectors of all facets cancel (Minkowski's relation Σ vol₅ u = 0); what
is left of them shows whether a facet is missing.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry
from graspq._compiled.normal_cones import (
    crossing,
    cut_cone,
    edge_arc,
    hide_vertices,
    start_cone,
)
from graspq._compiled.polytopes import (
    AREA,
    BASE,
    BASIS,
    CLOSURE,
    COVER,
    COVERS,
    END_VERTEX,
    FIRST_VERTEX,
    TAKEN,
    VERTEX,
    VOLUME,
    ZERO,
)

# Directions shorter than this, in sets about one in size, do not span a face.
ROUND_OFF = 1e-13
# A direction of which less than this share (squared) is across those before is made orthogonal
# once more, since digits cancelled.
KEPT = 0.1
# Dimensions of the chosen faces, largest first; equal ones are taken from rising bodies.
PATTERNS = np.array([(3, 0, 0), (2, 1, 0), (1, 1, 1), (4, 0, 0), (2, 2, 0), (3, 2, 0), (5, 0, 0)])


@compiled
def _orthogonalise(rows, used):
    """Make row ``used`` orthonormal to those before; return how long it is across them."""
    before, square = 0.0, 0.0
    for c in range(6):
        before += rows[used, c] * rows[used, c]
    # Twice is enough (Kahan; Parlett: The Symmetric Eigenvalue Problem, 1980, section 6.9).
    for _ in range(2):
        for r in range(used):
            along = 0.0
            for c in range(6):
                along += rows[r, c] * rows[used, c]
            for c in range(6):
                rows[used, c] -= along * rows[r, c]
        square = 0.0
        for c in range(6):
            square += rows[used, c] * rows[used, c]
        if square > KEPT * before:
            break
    length = np.sqrt(square)
    if length <= ROUND_OFF:
        return 0.0
    for c in range(6):
        rows[used, c] /= length
    return length


@compiled
def _add_face(vertices, faces, f, dim, rows, used):
    """Add a face's directions to the rows; return the volume of their parallelotope across them."""
    volume = 1.0
    for k in range(dim):
        for c in range(6):
            rows[used + k, c] = vertices[faces[f, BASIS + k], c] - vertices[faces[f, BASE], c]
        volume *= _orthogonalise(rows, used + k)
        if volume == 0.0:
            break
    return volume


@compiled
def _complete(rows, used):
    """Complete orthonormal rows to six, by the axes that are farthest from them."""
    for r in range(used, 6):
        axis, least = 0, np.inf
        for c in range(6):
            square = 0.0
            for k in range(r):
                square += rows[k, c] * rows[k, c]
            if square < least:
                axis, least = c, square
        for c in range(6):
            rows[r, c] = 1.0 if c == axis else 0.0
        _orthogonalise(rows, r)


@compiled
def _project(vertices, bodies, rows, used, flat):
    """Bring the vertices of bodies without a chosen face into the complement."""
    for m in range(bodies.shape[0]):
        if bodies[m, TAKEN] == 0:
            for k in range(bodies[m, FIRST_VERTEX], bodies[m, END_VERTEX]):
                for c in range(min(3, 6 - used)):
                    total = 0.0
                    for r in range(6):
                        total += vertices[k, r] * rows[used + c, r]
                    flat[k, c] = total


@compiled
def _find_cuts(vertices, faces, choice, count, rows, used, cuts, sums):
    """Find the cuts of the chosen faces, and a vertex of their sum; return how many cuts."""
    found = ZERO
    for c in range(3):
        sums[VERTEX + c] = 0.0
    for i in range(count):
        f = choice[i, 1]
        for k in range(-1, faces[f, COVERS]):
            # First the vertex itself, then what leads to those that cover the face.
            to, base = faces[f, COVER + k] if k >= 0 else faces[f, BASE], faces[f, BASE]
            for c in range(min(3, 6 - used)):
                total = 0.0
                for r in range(6):
                    start = vertices[base, r] if k >= 0 else 0.0
                    total += (vertices[to, r] - start) * rows[used + c, r]
                if k < 0:
                    sums[VERTEX + c] += total
                else:
                    cuts[found + k, c] = total
        found += faces[f, COVERS]
    return found


@compiled
def _add_facet(bodies, flat, rows, used, area, normal, sums):
    """Add the facet with this unit normal in the complement and this area."""
    height, complement = 0.0, 6 - used
    for m in range(bodies.shape[0]):
        top = -np.inf if bodies[m, TAKEN] == 0 else 0.0
        if bodies[m, TAKEN] == 0:
            for k in range(bodies[m, FIRST_VERTEX], bodies[m, END_VERTEX]):
                level = 0.0
                for c in range(complement):
                    level += normal[c] * flat[k, c]
                top = max(top, level)
        height += top
    for r in range(complement):
        height += normal[r] * sums[VERTEX + r]
        for c in range(6):
            sums[CLOSURE + c] += area * normal[r] * rows[used + r, c]
    sums[VOLUME] += height * area
    sums[AREA] += area


@compiled
def _facets_in_space(polytopes, work, used, cuts, last, size):
    """Add the facets that edges of two bodies after ``last`` complete."""
    bodies, faces, rays, flat = polytopes.bodies, polytopes.faces, work.rays, work.flat
    arcs = work.arcs
    projected = False
    for number in range(4):
        first, count = ZERO, start_cone(rays, number)
        for k in range(cuts):
            first, count = cut_cone(rays, first, count, work.cuts, k)
            if count == 0:
                break
        if count == 0:
            continue
        if not projected:
            _project(polytopes.vertices, bodies, work.rows, used, flat)
            projected = True
        found = ZERO
        for m in range(last + 1, bodies.shape[0]):
            begin, end, before = bodies[m, FIRST_VERTEX], bodies[m, END_VERTEX], found
            if bodies[m, TAKEN]:
                continue
            if hide_vertices(rays, first, count, flat, begin, end, work.levels) == 1:
                continue
            for e in range(bodies[m, 1], bodies[m, 2]):
                hidden = flat[faces[e, BASE], 3] + flat[faces[e, BASIS], 3]
                if hidden == 0.0 and edge_arc(
                    rays, first, count, faces, e, flat, work.levels, arcs, found
                ):
                    for i in range(0, before, 3):
                        area = size * crossing(arcs, i, found, work.normal)
                        if area > 0.0:
                            _add_facet(bodies, flat, work.rows, used, area, work.normal, work.sums)
                    found += 3


@compiled
def _facets_in_plane(polytopes, work, used, cuts, size):
    """Add the facets that an edge of one more body completes."""
    bodies, faces, flat, normal = polytopes.bodies, polytopes.faces, work.flat, work.normal
    # The wedge of directions goes from (sx, sy) counter-clockwise to (ex, ey).
    sx, sy, ex, ey = 0.0, 0.0, 0.0, 0.0
    for k in range(cuts):
        x, y = work.cuts[k, 0], work.cuts[k, 1]
        start, end = sx * x + sy * y, ex * x + ey * y
        if sx == 0.0 and sy == 0.0:
            sx, sy, ex, ey = -y, x, y, -x
        elif start > 0.0 and end > 0.0:
            return
        elif start > 0.0:
            sx, sy = -y, x
        elif end > 0.0:
            ex, ey = y, -x
    _project(polytopes.vertices, bodies, work.rows, used, flat)
    for m in range(bodies.shape[0]):
        if bodies[m, TAKEN]:
            continue
        for e in range(bodies[m, 1], bodies[m, 2]):
            b, o = faces[e, BASE], faces[e, BASIS]
            x, y = flat[o, 1] - flat[b, 1], flat[b, 0] - flat[o, 0]
            for _ in range(2):
                x, y = -x, -y
                good = sx * y >= sy * x and x * ey >= y * ex
                k = COVER
                while good and k < COVER + faces[e, COVERS]:
                    c = faces[e, k]
                    good = x * (flat[c, 0] - flat[b, 0]) + y * (flat[c, 1] - flat[b, 1]) <= 0.0
                    k += 1
                length = np.sqrt(x * x + y * y)
                if good and length > 0.0:
                    normal[0], normal[1] = x / length, y / length
                    _add_facet(bodies, flat, work.rows, used, length * size, normal, work.sums)


@compiled
def _facets_on_line(polytopes, work, used, cuts, size):
    """Add the facets that the chosen faces are without another edge."""
    normal = work.normal
    for sign in (1.0, -1.0):
        good = True
        for k in range(cuts):
            good = good and sign * work.cuts[k, 0] <= 0.0
        if good:
            _project(polytopes.vertices, polytopes.bodies, work.rows, used, work.flat)
            normal[0] = sign
            _add_facet(polytopes.bodies, work.flat, work.rows, used, size, normal, work.sums)


@compiled
def _may_choose(bodies, body, later):
    """Whether a body has no chosen face yet, and ``later`` bodies after it have none either."""
    for m in range(body + 1, bodies.shape[0]):
        later -= 1 - bodies[m, TAKEN]
    return later <= 0 and bodies[body, TAKEN] == 0


@compiled
def _next_choice(polytopes, work, pattern, count, depth):
    """Go on to the next choice of faces, the last one fastest; False when there is none."""
    bodies, choice, sizes = polytopes.bodies, work.choice, work.sizes
    while True:
        dim, b, f = pattern[depth], choice[depth, 0], choice[depth, 1] + 1
        if b == bodies.shape[0]:
            # Every face of this depth was chosen: on with the next face of the one before.
            if depth == 0:
                return False
            depth -= 1
            bodies[choice[depth, 0], TAKEN] = 0
            continue
        if f == 0:
            # Edges leave later bodies for the edges after them.
            later = count - depth + 4 - choice[count, 2] if dim == 1 else ZERO
            f = bodies[b, dim] if _may_choose(bodies, b, later) else bodies[b, dim + 1]
        choice[depth, 1] = f
        if f == bodies[b, dim + 1]:
            choice[depth, 0], choice[depth, 1] = b + 1, -1
            continue
        across = _add_face(polytopes.vertices, polytopes.faces, f, dim, work.rows, choice[depth, 2])
        sizes[depth + 1] = sizes[depth] * polytopes.volumes[f] * across
        if across > 0.0:
            bodies[b, TAKEN] = 1
            if depth + 1 == count:
                return True
            depth += 1
            choice[depth, 0], choice[depth, 1] = b + 1 if pattern[depth] == dim else 0, -1


@entry
def add_facets(polytopes, work, pattern):
    """Add the facets that have faces of the pattern's dimensions to ``work.sums``."""
    bodies, choice, rows, count = polytopes.bodies, work.choice, work.rows, ZERO
    for k in range(3):
        choice[k + 1, 2] = choice[k, 2] + pattern[k]
        count += pattern[k] > 0
    used, depth = choice[count, 2], ZERO
    choice[0, 0], choice[0, 1] = 0, -1
    while _next_choice(polytopes, work, pattern, count, depth):
        depth = count - 1
        b, size = choice[depth, 0], work.sizes[count]
        _complete(rows, used)
        cuts = _find_cuts(
            polytopes.vertices, polytopes.faces, choice, count, rows, used, work.cuts, work.sums
        )
        if used == 3:
            last = b if pattern[depth] == 1 else -1
            _facets_in_space(polytopes, work, used, cuts, last, size)
        elif used == 4:
            _facets_in_plane(polytopes, work, used, cuts, size)
        else:
            _facets_on_line(polytopes, work, used, cuts, size)
        bodies[b, TAKEN] = 0
