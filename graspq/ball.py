"""The largest ball inside the wrench space: ε and force closure."""

from __future__ import annotations

from typing import Any

import numpy as np

from graspq.errors import GraspError, as_number
from graspq.sets import Packed, as_bound, pack

FIRST_FACETS, MOST_FACETS = 16_384, 131_072
FIRST_VERTICES, MOST_VERTICES = 1024, 32_000


def epsilon(
    wrenches: Any, bound: str = "linf", unloading: bool = True, tol: float = 1e-5
) -> float:
    """Return the radius ε of the largest ball around the origin inside the wrench space.

    0.0 when the origin is not strictly inside. Force and moment are weighed as they come in
    ``wrenches``: one newton beside one (scaled) newton metre, about their own origin.
    Polytopes are solved to round-off. For ellipsoids ``tol`` bounds the relative gap between
    the returned support value, which is never below ε, and the proven lower bound.

    Raises:
        GraspError: for bad input, or when the hull outgrows its limits.
    """
    gap = as_number("tol", tol, positive=True)
    return ball_of(pack(wrenches, as_bound(bound), bool(unloading)), gap)


def is_force_closure(wrenches: Any) -> bool:
    """Return whether the contacts can exert every wrench, given enough normal force.

    True when the origin is strictly inside the wrench space with unloading; both bounds agree.
    """
    from graspq._flat import spread
    from graspq._ray import CAPPED, SOLVED, reach

    packed = pack(wrenches, "l1", True)
    inner, size = np.empty(6), np.empty(6)
    if spread(packed.body, inner, size, np.empty((6, 6))) == 0.0 and _is_flat(packed, size):
        return False
    if np.abs(inner / size).max() <= 1e-12:
        return True
    # Seen from an inner point of the space, the origin must not be the last point of the way.
    stop = 1e-6 if packed.smooth else 1e-12
    status, *_ = reach(-inner[:, None], packed.body, np.zeros((0, 6)), stop, packed.owners,
                       packed.ball_owners, np.zeros((packed.contacts, 6)))
    if status == CAPPED:
        raise GraspError("is_force_closure: the grasp is too close to degenerate to decide")
    return status == SOLVED


def ball_of(packed: Packed, tol: float) -> float:
    """ε of a checked grasp."""
    from graspq._epsilon import FLAT, ball
    from graspq._hull import FULL, GROWN

    stop = tol if packed.smooth else 0.0
    facets, vertices = FIRST_FACETS, FIRST_VERTICES
    while True:
        status, lower, value = ball(packed.body, stop, facets, vertices)
        if status == GROWN:
            return float(value)
        if status == FLAT:
            return 0.0
        if status != FULL:
            raise GraspError("epsilon: the hull could not be grown reliably (the grasp is close"
                             " to degenerate); move the contacts apart")
        if facets >= MOST_FACETS:
            raise GraspError(f"epsilon: did not close the gap [{lower:.6g}, {value:.6g}] within"
                             f" {facets} facets; take a larger tol or fewer edges")
        facets, vertices = min(8 * facets, MOST_FACETS), min(4 * vertices, MOST_VERTICES)


def _is_flat(packed: Packed, size: np.ndarray) -> bool:
    from graspq.ray import missing_directions

    return len(missing_directions(packed, size)) > 0
