"""The largest ball inside the wrench space: ε and force closure."""

from __future__ import annotations

from typing import Any

from graspq.errors import GraspError, as_number
from graspq.inputs import Packed, as_bound, pack

FIRST_FACETS, MOST_FACETS = 16_384, 131_072
FIRST_VERTICES, MOST_VERTICES = 1024, 8192


def epsilon(wrenches: Any, bound: str = "linf", unloading: bool = True, tol: float = 1e-5) -> float:
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
    from graspq._engines.ball_engine import inside_of

    packed = pack(wrenches, "l1", True)
    inside, outside = inside_of(packed.body)
    return bool(inside[0]) if inside[0] or outside[0] else ball_of(packed, 1e-5) > 0


def ball_of(packed: Packed, tol: float) -> float:
    """ε of a checked grasp."""
    from graspq._compiled.incremental_hull import FULL, GROWN
    from graspq._engines.ball_engine import IS_FLAT, balls_of

    stop = tol if packed.smooth else 0.0
    facets, vertices = FIRST_FACETS, FIRST_VERTICES
    while True:
        status, lower, value = (x[0] for x in balls_of(packed.body, stop, facets, vertices))
        if status == GROWN:
            return float(value)
        if status == IS_FLAT:
            return 0.0
        if status != FULL:
            raise GraspError(
                "epsilon: the hull could not be grown reliably (the grasp is close"
                " to degenerate); move the contacts apart"
            )
        if facets >= MOST_FACETS:
            raise GraspError(
                f"epsilon: did not close the gap [{lower:.6g}, {value:.6g}] within"
                f" {facets} facets; take a larger tol or fewer edges"
            )
        facets, vertices = min(8 * facets, MOST_FACETS), min(4 * vertices, MOST_VERTICES)
