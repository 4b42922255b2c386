"""Compiled ray shooting: how far a task wrench reaches inside a wrench space.

The reach q along t has 1/q = min Σ λ_k subject to Σ λ_k v_k = t over the points v_k of a set that
holds the origin. Six points whose cone contains t are a basis B;
u = B⁻ᵀ 1 asks the support function for the vertex v most in need, which the ratio test pivots in.
Any such u proves 1 / (u·t) <= q <= h(u) / (u·t). The basis starts from six artificial vertices that
are too small to matter; t is perturbed, so that pivots cannot cycle (A. Charnes, "Optimality and
degeneracy in linear programming", Econometrica 20, 1952), and dual pivots mend what that changed.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.pivots import DONE, dual, primal
from graspq._compiled.small_matrices import dot
from graspq._compiled.support_function import ORIGIN, add_support_point, support
from graspq._compiled.workspace import ARTIFICIAL, OBJECTIVE, VERTEX, WEIGHTS, WIDTH, aim, refactor

SOLVED, ZERO, CAPPED = 0, 1, 2
# A reach of less, in units of the set's extent, counts as none.
LEAST_REACH = 1e-9
# Length of the artificial vertices in units of the set's extent: longer ones need fewer pivots,
# shorter ones leave a smooth surface sooner. Shrunk to the least where they stay in the basis.
LONG, SHORT, SHRUNK = 1e-2, 1e-3, 1e-11
# Size of the first perturbation in units of the target, and its growth after a failed attempt.
PERTURBATION, GROWTH = 1e-10, 30.0
ATTEMPTS = 5
# Most pivots: polytopes of three contacts take about 20, ellipsoids more as they have no corners.
CAP_POLYTOPE, CAP_SMOOTH = 400, 4000
# Weight on artificial vertices, as a length in units of the task's, that is round-off.
NO_WEIGHT = 1e-12


@compiled
def _start(state, length):
    """Set up the artificial basis of ``length`` times the extent around the task."""
    for k in range(6):
        for c in range(WIDTH):
            state.tableau[k, c] = 0.0
        for c in range(6):
            state.basis[k, c] = 0.0
        side = length * state.size[k]
        if state.task[k] < 0.0:
            side = -side
        state.basis[k, k] = side
        state.tableau[k, k] = 1.0 / side
        state.tableau[k, OBJECTIVE] = 1.0 / side
        state.kinds[k] = ARTIFICIAL


@compiled
def _turn(state, length):
    """Make the basis hold the target: what it lies away from gives way to short opposites."""
    tableau = state.tableau
    aim(tableau, state.target)
    for k in range(6):
        if tableau[WEIGHTS, k] < 0.0:
            for c in range(6):
                state.basis[k, c] *= -length
                tableau[c, OBJECTIVE] -= tableau[c, k] * (1.0 + 1.0 / length)
                tableau[c, k] /= -length
            state.kinds[k] = ARTIFICIAL


@compiled
def _shrink(state, factor):
    """Shrink the artificial vertices; the tableau has to be formed anew."""
    for k in range(6):
        if state.kinds[k] == ARTIFICIAL:
            for c in range(6):
                state.basis[k, c] *= factor


@compiled
def _perturb(state, amount, attempt):
    """Move the task by a little in every row, differently in every attempt."""
    for c in range(6):
        push = amount * state.size[c] * (1.0 + 0.37 * ((5 * c + 3 * max(attempt - 1, 0)) % 7))
        state.target[c] = state.task[c] + (push if state.task[c] >= 0.0 else -push)


@compiled
def _refine(state, rows):
    """Form the tableau anew for the task itself and write its plane to ``u``.

    Returns (good, weight on vertices of the body, weight on artificial ones as a length).
    """
    tableau, basis, kinds = state.tableau, state.basis, state.kinds
    u, rest, task, size = state.u, state.rest, state.task, state.size
    if not refactor(state, task):
        return False, 0.0, 1.0
    # One step of refinement: vertices of a smooth set lie close together.
    for c in range(rows):
        rest[c] = task[c]
        for k in range(6):
            rest[c] -= basis[k, c] * tableau[WEIGHTS, k]
        u[c] = tableau[c, OBJECTIVE]
    far = 0.0
    for c in range(6):
        far = max(far, abs(task[c]) / size[c])
    real, left = 0.0, 0.0
    for k in range(rows):
        for c in range(6):
            tableau[WEIGHTS, k] += tableau[c, k] * rest[c]
        weight = tableau[WEIGHTS, k]
        if kinds[k] == VERTEX:
            real += max(weight, 0.0)
        else:
            length = 0.0
            for c in range(6):
                length = max(length, abs(basis[k, c]) / size[c])
            left = max(left, abs(weight) * length / far)
    return True, real, left


@compiled
def _settle(state, rows, h, real, left, stop):
    """Return (good, value, upper) of weights and plane, whose support value is ``h``."""
    basis, weights, task = state.basis, state.tableau[WEIGHTS], state.task
    along = dot(state.u, task)
    upper = h / along if along > 0.0 else np.inf
    total = 0.0
    for k in range(6):
        total += abs(weights[k])
    # Dropping a negative weight must cost no more than round-off of the task itself.
    for c in range(rows):
        missing, big = task[c], abs(task[c])
        for k in range(6):
            part = basis[k, c] * weights[k]
            big = max(big, abs(part))
            if weights[k] > 0.0:
                missing -= part
        if abs(missing) > 1e-11 * big and abs(missing) > 1e-12 * total * state.size[c]:
            return False, 0.0, upper
    value = 1.0 / real if real > 0.0 else 0.0
    near = 1.0 + 4.0 * stop + 2e-10
    good = h <= near and (left > NO_WEIGHT or value <= upper * near)
    return good, min(value, upper), upper


@compiled
def _plane_of_vertices(state, rows):
    """Write to ``u`` the plane through the origin and every basis vertex of the body itself."""
    for c in range(rows):
        state.u[c] = 0.0
        for k in range(6):
            if state.kinds[k] == ARTIFICIAL:
                state.u[c] += state.tableau[c, k]


@compiled
def _separated(state, h):
    """Upper bound on q from a plane u through the origin, of support value ``h``; inf from none.

    When the whole set lies below the plane and the task above, no multiple of it can be reached.
    """
    u, task = state.u, state.task
    along, length, far = 0.0, 0.0, 0.0
    for c in range(6):
        along += u[c] * task[c]
        length += abs(u[c]) * state.size[c]
        far += abs(u[c] * task[c])
    # Round-off of a sum of six.
    if h > 1e-11 * length or along <= 1e-9 * far:
        return np.inf
    return max(h, 0.0) / along


@compiled
def shoot(work, body, stop):
    """Return (status, value, upper) of the reach along the task in ``state``.

    The basis stays in the workspace: the next task starts from it, unless ``kinds`` says that it
    is artificial.
    """
    state = work.state
    kinds, task, target, size = state.kinds, state.task, state.target, state.size
    u, vertex = state.u, state.vertex
    # A size that the compiler does not know keeps it from unrolling loops that are run once.
    rows = body.points.shape[0]
    far = 0.0
    for c in range(6):
        far = max(far, abs(task[c]) / size[c])
    no_reach = LEAST_REACH / far
    near = 1.0 + max(1e-9, 10.0 * stop)
    smooth = body.centres.shape[1] > 0
    cap = CAP_SMOOTH if smooth else CAP_POLYTOPE
    warm = True
    for k in range(6):
        warm = warm and kinds[k] == VERTEX
    best = np.inf
    perturbation = PERTURBATION
    # Attempt -1 starts from the last task's basis; 0 is the quick way of polytopes.
    for attempt in range(-1 if warm else (1 if smooth else 0), ATTEMPTS):
        length = LONG if attempt <= 0 else SHORT
        _perturb(state, perturbation * far, attempt)
        # The last plane lies above a smooth set: dual pivots alone take it to the next task.
        above = attempt < 0 and smooth
        if attempt >= 0:
            _start(state, length)
        elif not above:
            _turn(state, length)
        shrunk = False
        while True:
            done = True
            if not above:
                done, upper = primal(work, body, target, task, stop, cap, attempt >= 0)
                best = min(best, upper)
            if done and best > no_reach:
                outcome = dual(work, body, task, stop, cap // 7 if above else cap // 2)
                done = outcome == DONE or not above
            if not done:
                break
            good, real, left = _refine(state, rows)
            value = 0.0
            if good:
                h = support(u, body, work, vertex)
                good, value, upper = _settle(state, rows, h, real, left, stop)
                best = min(best, upper)
            if left > NO_WEIGHT:
                _plane_of_vertices(state, rows)
                best = min(best, _separated(state, support(u, body, work, vertex)))
            if best <= no_reach:
                return ZERO, 0.0, best
            if not good:
                break
            if left <= max(NO_WEIGHT, 10.0 * stop):
                if best > value * near and attempt < ATTEMPTS - 1:
                    break
                return SOLVED, value, max(best, value)
            if attempt < 0:
                break
            if shrunk:
                return ZERO, 0.0, best
            shrunk = True
            _shrink(state, SHRUNK / length)
            if not refactor(state, target):
                break
        if attempt > 0:
            perturbation *= GROWTH
    return CAPPED, 0.0, best


@compiled
def collect(work, body, owners, ellipsoid_owners, forces):
    """Write the contacts' wrenches (n, 6) at the optimum, from the basis and its weights."""
    state = work.state
    u, part = state.u, state.vertex
    rows = body.points.shape[0]
    for i in range(forces.shape[0]):
        for r in range(6):
            forces[i, r] = 0.0
    total = 0.0
    for k in range(6):
        if state.kinds[k] == VERTEX:
            total += max(state.tableau[WEIGHTS, k], 0.0)
    for k in range(rows):
        weight = state.tableau[WEIGHTS, k] / total
        if state.kinds[k] == VERTEX and weight > 0.0:
            for r in range(6):
                u[r] = state.directions[k, r]
            for i in range(work.parts.shape[1]):
                pick = work.parts[k, i]
                if pick == ORIGIN:
                    continue
                contact = owners[pick] if pick >= 0 else ellipsoid_owners[-2 - pick]
                for r in range(6):
                    part[r] = 0.0
                add_support_point(u, body, pick, part)
                for r in range(6):
                    forces[contact, r] += weight * part[r]
