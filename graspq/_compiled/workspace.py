"""Compiled: the basis of ray shooting and all scratch, allocated once for many tasks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.small_matrices import invert_in_place

# Kinds of basis vertices: points of the body, or of the artificial start.
VERTEX, ARTIFICIAL = 0, 1
# Row of the tableau with the target's weights, and column with the objective.
WEIGHTS, OBJECTIVE = 6, 6
# Columns of the tableau: six basis vertices, the objective, and one more, as vector code works
# on eight numbers at a time.
WIDTH = 8
# Rows of ``parts`` after those of the six basis vertices: of the point that was asked for last,
# and of an earlier one.
CHOSEN, KEPT, PART_ROWS = 6, 7, 8
# Candidates of one set, and before them their number.
CANDIDATES = 64

# With the basis vertices v_k as columns of B, ``tableau`` holds B⁻ᵀ in its first six rows and
# columns, tableau[c, k] = (B⁻¹)[k, c]; u = B⁻ᵀ 1, the normal of the plane u·x = 1 through the six
# vertices, in column OBJECTIVE; and the weights B⁻¹ t of the target in row WEIGHTS, with their sum
# where the two meet. ``basis`` has the vertices as rows, ``directions`` what each is the support
# point of, ``kinds`` whether it is a VERTEX or ARTIFICIAL. The rest is scratch: ``size`` is the
# extent of the body per row, ``target`` the perturbed task, ``column`` B⁻¹ times the ``vertex``
# that enters.
# One record instead of many arrays is passed as one pointer, which compiles and runs faster.
STATE = np.dtype(
    [
        ("tableau", np.float64, (7, WIDTH)),
        ("basis", np.float64, (6, 6)),
        ("directions", np.float64, (6, 6)),
        ("kinds", np.int64, (6,)),
        ("size", np.float64, (6,)),
        ("task", np.float64, (6,)),
        ("target", np.float64, (6,)),
        ("u", np.float64, (6,)),
        ("vertex", np.float64, (6,)),
        ("column", np.float64, (WIDTH,)),
        ("row", np.float64, (6,)),
        ("tilted", np.float64, (6,)),
        ("direction", np.float64, (6,)),
        ("nearer", np.float64, (6,)),
        ("best", np.float64, (6,)),
        ("between", np.float64, (6,)),
        ("rest", np.float64, (6,)),
        ("matrix", np.float64, (6, 6)),
        ("inverse", np.float64, (6, 6)),
    ]
)


class Workspace(NamedTuple):
    """What ray shooting and the hull work with.

    Attributes:
        state: one record of ``STATE``, of an array that the caller keeps alive.
        parts: what each set contributes to each basis vertex, and to the points chosen last and
            before (rows ``CHOSEN`` and ``KEPT``), shape (8, n): see ``support_function``.
        candidates: per set the number of points that were ever chosen, then these, (n, 65).
        score: scratch of the support function, shape (K,).
    """

    state: np.ndarray
    parts: np.ndarray
    candidates: np.ndarray
    score: np.ndarray


@compiled
def refactor(state, target):
    """Form the tableau anew from the basis; False when the basis is singular."""
    for k in range(6):
        for c in range(6):
            state.matrix[k, c] = state.basis[k, c]
    if not invert_in_place(state.matrix, state.inverse, 0.0):
        return False
    for c in range(6):
        total = 0.0
        for k in range(6):
            state.tableau[c, k] = state.inverse[c, k]
            total += state.inverse[c, k]
        state.tableau[c, OBJECTIVE] = total
    aim(state.tableau, target)
    return True


@compiled
def aim(tableau, target):
    """Put the weights of another target into the tableau."""
    for k in range(WIDTH):
        total = 0.0
        for c in range(6):
            total += tableau[c, k] * target[c]
        tableau[WEIGHTS, k] = total
