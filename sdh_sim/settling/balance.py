"""Newton's method for the balance of one increment, compiled.

The equations are those of ``increment``, whose ``solve_increment`` calls this: c contacts, r
bounded springs, n coordinates. Plain loops, since with some fifty contacts and a dozen coordinates
NumPy spends its time in calls.
"""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry

ROUNDS = 12
CLOSE = 1e-4  # what is left of the balance, as a share of the largest force
AWAY = 5.0  # Newton's method is given up beyond that many of the longest motions
TRIES, MORE = 8, 4.0  # with so many times the viscosity each time


@compiled
def forces_at(
    z, jacobian, normal, gap, stiffness, friction, carried, rows, pull, spring, lower, upper, load,
    drag, pressed, trial, length, rubbed, pulled, rest,
):  # fmt: skip
    """Forces at a motion z (n,), and what is left of the balance; results go into the last six."""
    c, n = len(gap), len(z)
    for j in range(n):
        rest[j] = load[j] - drag[j] * z[j]
    for k in range(c):
        approach = 0.0
        for i in range(3):
            moved = 0.0
            for j in range(n):
                moved += jacobian[k, i, j] * z[j]
            trial[k, i] = moved
            approach += normal[k, i] * moved
        pressed[k] = stiffness[k] * max(0.0, -gap[k] - approach)
        square = 0.0
        for i in range(3):
            trial[k, i] = carried[k, i] - stiffness[k] * (trial[k, i] - approach * normal[k, i])
            square += trial[k, i] ** 2
        length[k] = np.sqrt(square)
        limit = friction[k] * pressed[k]
        share = 1.0 if length[k] <= limit else limit / length[k]
        for i in range(3):
            rubbed[k, i] = share * trial[k, i]
        if pressed[k] > 0.0:
            for i in range(3):
                force = pressed[k] * normal[k, i] + rubbed[k, i]
                for j in range(n):
                    rest[j] += force * jacobian[k, i, j]
    for k in range(len(pull)):
        stretch = 0.0
        for j in range(n):
            stretch += rows[k, j] * z[j]
        pulled[k] = min(max(pull[k] - spring[k] * stretch, lower[k]), upper[k])
        for j in range(n):
            rest[j] += pulled[k] * rows[k, j]


@compiled
def tangent_at(
    jacobian, normal, stiffness, friction, rows, spring, lower, upper, drag, pressed, trial, length,
    pulled, matrix,
):  # fmt: skip
    """Minus the derivative of the balance by the motion, into ``matrix`` (n, n)."""
    n = len(drag)
    matrix[:] = 0.0
    block, stiff = np.empty((3, 3)), np.empty((3, n))
    for k in range(len(pressed)):
        if pressed[k] <= 0.0:
            continue
        limit = friction[k] * pressed[k]
        slips = length[k] > limit
        share = limit / length[k] if slips else 1.0
        for i in range(3):
            for m in range(3):
                both = normal[k, i] * normal[k, m]
                value = both + share * ((1.0 if i == m else 0.0) - both)
                if slips:
                    along = trial[k, i] / length[k]
                    value -= share * along * trial[k, m] / length[k]
                    value += friction[k] * along * normal[k, m]
                block[i, m] = stiffness[k] * value
        for i in range(3):
            for j in range(n):
                stiff[i, j] = (
                    block[i, 0] * jacobian[k, 0, j]
                    + block[i, 1] * jacobian[k, 1, j]
                    + block[i, 2] * jacobian[k, 2, j]
                )
        for i in range(3):
            for a in range(n):
                arm = jacobian[k, i, a]
                if arm != 0.0:
                    for b in range(n):
                        matrix[a, b] += arm * stiff[i, b]
    for k in range(len(spring)):
        if lower[k] < pulled[k] < upper[k]:
            for a in range(n):
                arm = spring[k] * rows[k, a]
                if arm != 0.0:
                    for b in range(n):
                        matrix[a, b] += arm * rows[k, b]
    for j in range(n):
        matrix[j, j] += drag[j]


@compiled
def solve(matrix, right):
    """The solution of a linear system, by elimination with row pivots; both are overwritten."""
    n = len(right)
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            right[k], right[pivot] = right[pivot], right[k]
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                right[i] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
    return right


@compiled
def largest(values, reach):
    """Largest of generalised forces, moments over the reach of their coordinates [N]."""
    size = 0.0
    for j in range(len(values)):
        size = max(size, abs(values[j]) / reach[j])
    return size


@compiled
def longest_of(z, reach):
    """Length by which a motion moves anything, at most [m]."""
    size = 0.0
    for j in range(len(z)):
        size = max(size, abs(z[j]) * reach[j])
    return size


@entry
def balanced_motion(
    jacobian, normal, gap, stiffness, friction, carried, rows, pull, spring, lower, upper, load,
    viscosity, reach, longest, factor,
):  # fmt: skip
    """Motion (n,), normal forces (c,), friction forces (c, 3), spring forces (r,), final factor."""
    c, n, r = len(gap), len(load), len(pull)
    z, step, rest, drag = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    pressed, trial, length, rubbed = np.zeros(c), np.zeros((c, 3)), np.zeros(c), np.zeros((c, 3))
    pulled, matrix = np.zeros(r), np.zeros((n, n))
    for attempt in range(TRIES + 1):
        drag[:] = factor * viscosity
        z[:] = 0.0
        forces_at(
            z, jacobian, normal, gap, stiffness, friction, carried, rows, pull, spring, lower,
            upper, load, drag, pressed, trial, length, rubbed, pulled, rest,
        )  # fmt: skip
        size = largest(rest, reach)
        scale = max(size, largest(load, reach), 1e-3)
        for _ in range(ROUNDS):
            if size <= CLOSE * scale or longest_of(z, reach) > AWAY * longest:
                break
            tangent_at(
                jacobian, normal, stiffness, friction, rows, spring, lower, upper, drag, pressed,
                trial, length, pulled, matrix,
            )  # fmt: skip
            step[:] = solve(matrix, rest)
            z += step
            before = size
            for half in range(2):
                forces_at(
                    z, jacobian, normal, gap, stiffness, friction, carried, rows, pull, spring,
                    lower, upper, load, drag, pressed, trial, length, rubbed, pulled, rest,
                )  # fmt: skip
                size = largest(rest, reach)
                if half == 1 or size <= before:
                    break
                z -= 0.5 * step
        moved = longest_of(z, reach)
        if size <= CLOSE * scale and moved <= longest:
            break
        if attempt == TRIES:  # what was found is shortened
            z *= min(1.0, longest / max(moved, 1e-12)) if np.isfinite(z).all() else 0.0
            z[:] = np.where(np.isfinite(z), z, 0.0)
            forces_at(
                z, jacobian, normal, gap, stiffness, friction, carried, rows, pull, spring, lower,
                upper, load, drag, pressed, trial, length, rubbed, pulled, rest,
            )  # fmt: skip
            break
        factor *= MORE
    return z, pressed, rubbed, pulled, factor
