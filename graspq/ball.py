"""The largest ball inside the wrench space: ε and force closure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from graspq.errors import GraspError, as_choice, as_number
from graspq.inputs import Packed, as_bound, pack

# Room for the hull at first, and at most: about 150 bytes per facet, and as many vertices as the
# hull can number.
FIRST_FACETS, MOST_FACETS = 16_384, 2_097_152
FIRST_VERTICES, MOST_VERTICES = 1024, 32_767
SUBSPACES = ("all", "span", "planar")
AXES = ("fx", "fy", "fz", "mx", "my", "mz")
PLANAR = (0, 1, 5)

TOO_FLAT = (
    "the contacts' wrenches span {rank} of the {dimension} dimensions ({names}); subspace='span'"
    " measures among those"
)
NOT_INSIDE = (
    "the origin is not inside the wrench space: seen from the wrench ({wrench}), which the contacts"
    " can exert, it does not reach past the origin"
)
OFF_ORIGIN = "the wrench space lies in a plane that misses the origin"


@dataclass(frozen=True, eq=False)
class LargestBall:
    """The largest ball around the origin inside a wrench space.

    Attributes:
        value: its radius ε; 0.0 when the origin is not strictly inside.
        lower: certified lower bound on ε.
        upper: certified upper bound on ε.
        axes: orthonormal basis of the subspace in which the ball lies, shape (6, k).
        names: the subspace in words, as "fx, fy, mz" where it lies along axes.
        reason: why ``value`` is 0; empty otherwise.
    """

    value: float
    lower: float
    upper: float
    axes: np.ndarray
    names: str
    reason: str = ""

    @property
    def dimension(self) -> int:
        """Dimension of the ball."""
        return self.axes.shape[1]


def largest_ball(
    wrenches: Any,
    bound: str = "linf",
    unloading: bool = True,
    tol: float = 1e-5,
    *,
    subspace: str = "all",
) -> LargestBall:
    """Return the largest ball around the origin inside the wrench space, with its certificate.

    Args:
        wrenches: one (6, l_i) array or ``EllipsoidSet`` per contact, from ``contact_wrenches``.
        bound: as in ``task_scaling``.
        unloading: as in ``task_scaling``.
        tol: relative gap between the bounds at which ellipsoids are accurate enough; polytopes
            are solved to round-off.
        subspace: "all" is the six-dimensional ball; "planar" that of a grasp in the xy plane, among
            (fx, fy, mz), with what lies across left to the plane's support; "span" that among the
            wrenches that the contacts' wrenches span, whatever their dimension.

    Raises:
        GraspError: for bad input, or when the hull outgrows its limits.
    """
    as_choice("subspace", subspace, SUBSPACES)
    gap = as_number("tol", tol, positive=True)
    packed = pack(wrenches, as_bound(bound), bool(unloading))
    return _largest_ball(packed, gap, subspace)


def epsilon(
    wrenches: Any,
    bound: str = "linf",
    unloading: bool = True,
    tol: float = 1e-5,
    *,
    subspace: str = "all",
) -> float:
    """Return the radius ε of the largest ball around the origin inside the wrench space.

    0.0 when the origin is not strictly inside; ``largest_ball`` gives the reason. Force and moment
    are weighed as they come in ``wrenches``: one newton beside one (scaled) newton metre, about
    their own origin. Polytopes are solved to round-off. For ellipsoids ``tol`` bounds the relative
    gap between the returned support value, which is never below ε, and the proven lower bound.

    The arguments are those of ``largest_ball``.

    Raises:
        GraspError: for bad input, or when the hull outgrows its limits.
    """
    return largest_ball(wrenches, bound, unloading, tol, subspace=subspace).value


def is_force_closure(wrenches: Any, *, subspace: str = "all") -> bool:
    """Return whether the contacts can exert every wrench, given enough normal force.

    True when the origin is strictly inside the wrench space with unloading; both bounds agree.
    ``subspace`` is as in ``largest_ball``: "planar" asks for every wrench (fx, fy, mz) alone.
    """
    from graspq._engines.ball_engine import inside_of

    as_choice("subspace", subspace, SUBSPACES)
    packed = pack(wrenches, "l1", True)
    if subspace == "all":
        inside, outside = inside_of(packed.body)
        if inside[0] or outside[0]:
            return bool(inside[0])
    return _largest_ball(packed, 1e-5, subspace).value > 0


def _largest_ball(packed: Packed, tol: float, subspace: str) -> LargestBall:
    """``largest_ball`` of a checked grasp."""
    from graspq._engines.ball_engine import IS_FLAT, balls_of
    from graspq._engines.bodies import project, span_of

    axes = np.eye(6)
    if subspace == "span":
        axes = span_of(packed.body).axes
    elif subspace == "planar":
        axes = axes[:, PLANAR]
    names = _names(axes)
    if axes.shape[1] < 6:
        if not axes.shape[1]:
            flat = TOO_FLAT.format(rank=0, dimension=6, names=names)
            return LargestBall(0.0, 0.0, 0.0, axes, names, flat)
        inner = span_of(packed.body).inner
        off = inner - axes @ (axes.T @ inner)
        if subspace == "span" and np.abs(off).max() > 1e-9 * np.abs(packed.body.points).max(
            initial=np.abs(packed.body.centres).max(initial=0.0)
        ):
            return LargestBall(0.0, 0.0, 0.0, axes, names, OFF_ORIGIN)
        packed = project(packed, axes)
    if packed.smooth:
        packed = _without_rotations(packed)
    stop = tol if packed.smooth else 0.0
    facets, vertices = FIRST_FACETS, FIRST_VERTICES
    status, lower, value = _first(balls_of(packed.body, stop, facets, vertices))
    while status not in (0, IS_FLAT):
        _refuse(status, lower, value, facets)
        facets, vertices = min(8 * facets, MOST_FACETS), min(8 * vertices, MOST_VERTICES)
        status, lower, value = _first(balls_of(packed.body, stop, facets, vertices))
    if status == IS_FLAT:
        own = span_of(packed.body).axes
        own = own[:, np.linalg.norm(axes.T @ own, axis=0) > 0.5] if axes.shape[1] < 6 else own
        rank = own.shape[1]
        reason = TOO_FLAT.format(rank=rank, dimension=axes.shape[1], names=_names(own))
        return LargestBall(0.0, 0.0, 0.0, axes, names, reason)
    reason = ""
    if value == 0.0:
        inner = axes @ (axes.T @ span_of(packed.body).inner)
        reason = NOT_INSIDE.format(wrench=", ".join(f"{x:.4g}" for x in inner))
    return LargestBall(value, lower, value, axes, names, reason)


def _first(found: Any) -> tuple[int, float, float]:
    """Status and bounds of the only body."""
    return int(found.status[0]), float(found.lower[0]), float(found.upper[0])


def _refuse(status: int, lower: float, value: float, facets: int) -> None:
    """Raise unless more room for the hull may help."""
    from graspq._compiled.incremental_hull import FULL

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


def _without_rotations(packed: Packed) -> Packed:
    """Project a smooth space along what its rotations turn, which leaves ε as it is."""
    from graspq._engines.bodies import project, span_of
    from graspq._engines.symmetry import turned_direction

    if span_of(packed.body).rank < 6:
        # What a flat space lacks may turn as it likes, and must not be filled.
        return packed
    direction = turned_direction(packed.body)
    while direction is not None:
        rest = np.linalg.svd(direction[:, None])[0][:, 1:]
        packed = project(packed, rest)
        direction = turned_direction(packed.body)
    return packed


def _names(axes: np.ndarray) -> str:
    """A subspace in words."""
    if not axes.shape[1]:
        return "none"
    if axes.shape[1] == 6:
        return ", ".join(AXES)
    share = np.linalg.norm(axes, axis=1)
    along = [name for name, s in zip(AXES, share, strict=True) if s > 1.0 - 1e-9]
    if len(along) == axes.shape[1]:
        return ", ".join(along)
    return f"{axes.shape[1]} dimensions across the axes"
