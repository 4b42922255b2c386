"""Compiled ray shooting: how far a task wrench reaches inside a wrench space.

The reach q along t has 1/q = min Σ λ subject to Σ λ_j v_j = t over the vertices v_j of a set
that holds the origin. Six vertices whose cone contains t are a basis B; u = B⁻ᵀ 1 asks the
support oracle for the vertex v most in need, which the ratio test pivots in. Any such u proves
1 / (u·t) <= q <= h(u) / (u·t). The basis starts from six artificial vertices that are too small
to matter.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry
from graspq._compiled.pivots import SMALL, TALL, dual, price, primal, start_basis, turn_basis
from graspq._compiled.polytope_pivots import ask, climb
from graspq._compiled.small_matrices import dot, row_sum, times
from graspq._compiled.support_function import FAST, add_atom
from graspq._compiled.workspace import (
    ARTIFICIAL,
    DIRECTIONS,
    INVERSE,
    PICKS,
    REAL,
    SCRATCH,
    SIZE,
    TASK,
    WEIGHTS,
    clear,
    new_desk,
    refactor,
    refresh,
)

SOLVED, ZERO, CAPPED = 0, 1, 2
TINY = 1e-9
STEEP = 1e5


@compiled
def _settle(desk, task, size, body, pads, stop):
    """Refresh, recompute and return (good, value, upper, share left on artificials)."""
    kinds, sheet = desk.kinds, desk.sheet
    basis, inverse, weights = sheet[0:6], sheet[INVERSE : INVERSE + 6], sheet[WEIGHTS]
    u, vertex, correction = sheet[SCRATCH], sheet[SCRATCH + 1], sheet[SCRATCH + 2]
    if not refresh(desk):
        return False, 0.0, np.inf, 1.0
    times(inverse, task, weights)
    row_sum(inverse, u)
    # One step of refinement: vertices of a smooth set lie close together.
    for c in range(6):
        rest = task[c]
        for r in range(6):
            rest -= basis[c, r] * weights[r]
        vertex[c] = rest
    times(inverse, vertex, correction)
    for r in range(6):
        weights[r] += correction[r]
    total, real, left = 0.0, 0.0, 0.0
    for r in range(6):
        total += abs(weights[r])
        if kinds[r] == ARTIFICIAL:
            # As a length beside the task's, both in units of the set's extent.
            length, far = 0.0, 0.0
            for c in range(6):
                length = max(length, abs(basis[c, r]) / size[c])
                far = max(far, abs(task[c]) / size[c])
            left = max(left, abs(weights[r]) * length / far)
        else:
            real += max(weights[r], 0.0)
    if body[3].shape[0] == 0 and pads.shape[0] == 0:
        h = ask(u, body, np.inf, desk, vertex)
    else:
        h, _ = price(u, body, pads, np.inf, desk, vertex)
    reach = dot(u, task)
    upper = h / reach if reach > 0.0 else np.inf
    # Dropping a negative weight must cost no more than round-off of the task itself.
    for c in range(6):
        rest, big = task[c], abs(task[c])
        for r in range(6):
            part = basis[c, r] * weights[r]
            big = max(big, abs(part))
            if weights[r] > 0.0:
                rest -= part
        if abs(rest) > 1e-11 * big and abs(rest) > 1e-12 * total * size[c]:
            return False, 0.0, upper, left
    value = 1.0 / real if real > 0.0 else 0.0
    near = 4.0 * stop + 2e-10
    good = h <= 1.0 + near and (left > 1e-12 or value <= upper * (1.0 + near))
    return good, min(value, upper), upper, left


@compiled
def _separate(desk, task, size, body, pads):
    """Upper bound from the plane of the real basis vertices; inf when it cuts the set.

    The plane holds the origin and every vertex of the basis but the artificial ones. When the
    whole set lies below it and the task above, no multiple of the task can be reached.
    """
    inverse, kinds = desk.sheet[INVERSE : INVERSE + 6], desk.kinds
    u, vertex = desk.sheet[SCRATCH], desk.sheet[SCRATCH + 1]
    u[:] = 0.0
    for r in range(6):
        if kinds[r] == ARTIFICIAL:
            for c in range(6):
                u[c] += inverse[r, c]
    h, _ = price(u, body, pads, np.inf, desk, vertex)
    reach = dot(u, task)
    length, far = 0.0, 0.0
    for r in range(6):
        length += abs(u[r]) * size[r]
        far += abs(u[r] * task[r])
    if h > 1e-11 * length or reach <= 1e-9 * far:
        return np.inf
    return max(h, 0.0) / reach


@compiled
def shoot(desk, task, size, body, pads, stop):
    """Return (status, value, lower, upper) of the reach along ``task``.

    The basis stays on the desk, cleared for this set before: the next task starts warm from it.
    """
    kinds, sheet, target = desk.kinds, desk.sheet, desk.sheet[SCRATCH + 7]
    # The task's own length in units of the set decides what counts as zero reach.
    far = 0.0
    for r in range(6):
        far = max(far, abs(task[r]) / size[r])
    zero = TINY / far
    cap = 400 if body[3].shape[0] == 0 else 4000
    plain = body[3].shape[0] == 0 and pads.shape[0] == 0
    warm = True
    for r in range(6):
        warm = warm and kinds[r] != ARTIFICIAL
    if warm and not plain and dual(desk, task, body, pads, stop, cap // 7) == 0:
        good, value, upper, left = _settle(desk, task, size, body, pads, stop)
        if good and left == 0.0 and upper <= value * (1.0 + max(1e-9, 10.0 * stop)):
            return SOLVED, value, value, max(upper, value)
    jitter = 1e-10
    best = np.inf
    # Plain polytopes start warm or in the quick way; the other attempts are the careful ones.
    for attempt in range((-1 if warm else 0) if plain else 1, 5):
        small = TALL if attempt <= 0 else SMALL
        if attempt >= 0:
            start_basis(desk, task, size, small)
        for r in range(6):
            push = jitter * far * size[r] * (1.0 + 0.37 * ((r * 5 + 3 * max(attempt - 1, 0)) % 7))
            target[r] = task[r] + (push if task[r] >= 0.0 else -push)
        if attempt < 0:
            turn_basis(desk, target, small)
        shrunk = False
        while True:
            if plain:
                done, upper = climb(desk, target, task, body, stop, cap)
            else:
                done, upper, _ = primal(desk, target, task, body, pads, stop, cap)
            best = min(best, upper)
            if not done:
                break
            if best > zero:
                dual(desk, task, body, pads, stop, cap // 2)
            good, value, upper, left = _settle(desk, task, size, body, pads, stop)
            best = min(best, upper)
            if left > 1e-12:
                best = min(best, _separate(desk, task, size, body, pads))
            if best <= zero:
                return ZERO, 0.0, 0.0, best
            if not good:
                break
            if left <= max(1e-12, 10.0 * stop):
                if best > value * (1.0 + max(1e-9, 10.0 * stop)) and attempt < 4:
                    break
                return SOLVED, value, value, max(best, value)
            if attempt < 0:
                break
            if shrunk:
                return ZERO, 0.0, 0.0, best
            for r in range(6):
                if kinds[r] == ARTIFICIAL:
                    for c in range(6):
                        sheet[c, r] *= TINY / small * 1e-2
            shrunk = True
            if not refactor(desk):
                break
        if attempt > 0:
            jitter *= 30.0
    return CAPPED, 0.0, 0.0, best


@compiled
def collect(desk, body, owners, ball_owners, forces):
    """Write the contacts' wrenches (n, 6) at the optimum, from the basis and its weights."""
    points, centres, axes = body[0], body[2], body[3]
    kinds, places, weights = desk.kinds, desk.places, desk.sheet[WEIGHTS]
    forces[:, :] = 0.0
    total = 0.0
    for j in range(6):
        total += max(weights[j], 0.0) if kinds[j] == REAL else 0.0
    for j in range(6):
        if kinds[j] != REAL or weights[j] <= 0.0:
            continue
        for i in range(places.shape[1]):
            pick = places[PICKS + j, i]
            if pick == -1:
                continue
            contact = owners[pick] if pick >= 0 else ball_owners[-2 - pick]
            add_atom(
                desk.sheet[DIRECTIONS + j],
                points,
                centres,
                axes,
                pick,
                weights[j] / total,
                forces[contact],
            )


@compiled(fastmath=FAST)
def _row_extent(points, r):
    big = 0.0
    for k in range(points.shape[1]):
        size = abs(points[r, k])
        big = size if size > big else big
    return big


@entry
def extent(body, size):
    """Largest absolute entry per row of the atoms; 1 for a row without any."""
    points, _, centres, axes, _, _, shift = body
    for r in range(size.shape[0]):
        big = max(abs(shift[r]), _row_extent(points, r))
        for k in range(centres.shape[1]):
            big = max(big, abs(centres[r, k]))
            for c in range(3):
                big = max(big, abs(axes[k, r, c]))
        size[r] = big
    most = size.max()
    for r in range(size.shape[0]):
        size[r] = max(size[r], 1e-6 * most)


@entry
def reach(tasks, body, pads, stop, owners, ball_owners, forces):
    """Return (status, value, lower, upper, critical, sound) of the task set's smallest reach.

    ``sound`` says that six well-conditioned vertices carry every task, as in no flat set.
    """
    desk = new_desk(body[0].shape[1], body[1].shape[0] - 1)
    return reach_at(desk, tasks, body, pads, stop, owners, ball_owners, forces)


@compiled
def reach_at(desk, tasks, body, pads, stop, owners, ball_owners, forces):
    """``reach`` at a desk of the body's size; ``forces`` may have no rows."""
    clear(desk, body)
    size, task = desk.sheet[SIZE], desk.sheet[TASK]
    extent(body, size)
    value, lower, upper, critical = np.inf, np.inf, np.inf, -1
    sound = True
    for j in range(tasks.shape[1]):
        for r in range(6):
            task[r] = tasks[r, j]
        status, q, low, high = shoot(desk, task, size, body, pads, stop)
        if status == CAPPED:
            return CAPPED, q, low, high, j, False
        for r in range(6):
            sound = sound and desk.kinds[r] != ARTIFICIAL
            for c in range(6):
                sound = sound and abs(desk.sheet[INVERSE + r, c]) * size[c] < STEEP
        lower, upper = min(lower, low), min(upper, high)
        if q < value:
            value, critical = q, j
            if status != SOLVED:
                forces[:, :] = 0.0
                return ZERO, 0.0, 0.0, high, j, False
            if forces.shape[0] > 0:
                collect(desk, body, owners, ball_owners, forces)
    return SOLVED, value, lower, upper, critical, sound
