"""The minimum weight: how evenly wrenches can be weighed to cancel.

Reference: A. H. Li, P. Culbertson, J. W. Burdick and A. D. Ames: FRoGGeR: fast robust grasp
generation via the min-weight metric, IROS 2023, arXiv 2302.13687.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from graspq.errors import GraspError
from graspq.inputs import as_polytopes

# Status that scipy.optimize.linprog gives where no weights cancel.
INFEASIBLE = 2


def minimum_weight(wrenches: Any) -> float:
    """Return FRoGGeR's ℓ*, the largest smallest weight of wrenches that add up to zero.

    max t over weights α_j >= t of all m wrenches w_j with Σ α_j = 1 and Σ α_j w_j = 0; a linear
    program, solved by HiGHS. Above 0 every wrench takes part in cancelling the others: force
    closure where they span all six directions. At most 1/m, when equal weights cancel; m ℓ* is
    the normalised minimum weight. Below 0 there is no force closure, and -inf says that no weights
    at all cancel, of either sign. High is good.

    It does not depend on the unit of moments, on the point that they are taken about, or on a turn
    of the frame. It does depend on the edges of the friction cones: FRoGGeR takes four per contact,
    of unit length. It sees neither limits of forces nor how large the wrenches are as compared with
    a task.

    Args:
        wrenches: one (6, l_i) array per contact, from ``contact_wrenches``.

    Raises:
        GraspError: for bad input, or where HiGHS finds no solution.
    """
    from scipy.optimize import linprog

    columns = np.hstack(as_polytopes(wrenches, "minimum_weight"))
    if not np.isfinite(columns).all():
        raise GraspError("wrenches: every entry must be finite")
    size = np.abs(columns).max(axis=1)
    columns = columns[size > 0] / size[size > 0, None]
    count = columns.shape[1]
    # Weights are taken as α = t + β with β >= 0, which leaves t as the one free variable.
    equalities = np.zeros((len(columns) + 1, count + 1))
    equalities[:-1, :count], equalities[:-1, count] = columns, columns.sum(axis=1)
    equalities[-1, :count], equalities[-1, count] = 1.0, count
    found = linprog(
        np.append(np.zeros(count), -1.0),
        A_eq=equalities,
        b_eq=np.append(np.zeros(len(columns)), 1.0),
        bounds=[(0.0, None)] * count + [(None, None)],
        method="highs",
    )
    if found.status == INFEASIBLE:
        return -np.inf
    if found.x is None:
        raise GraspError(f"minimum_weight: HiGHS stopped with {found.message!r}")
    return float(found.x[-1])
