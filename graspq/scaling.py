"""Task wrench set scaling q* (equations 9 and 10)."""

from __future__ import annotations

from typing import Any

from graspq.errors import as_choice, as_number
from graspq.inputs import as_bound, as_polytopes, as_tasks, pack
from graspq.scaling_result import TaskScaling

_ray: Any = None
ENGINES = ("ray", "highs")


def task_scaling(
    wrenches: Any,
    tasks: Any,
    bound: str = "linf",
    unloading: bool = True,
    engine: str = "ray",
    tol: float = 1e-9,
) -> TaskScaling:
    """Return q*: how far the task wrenches can be scaled inside the grasp wrench space.

    Args:
        wrenches: one (6, l_i) array or ``EllipsoidSet`` per contact, from ``contact_wrenches``.
        tasks: task wrenches, shape (6, m), in the same frame, origin and torque scale.
        bound: "linf" bounds every contact by itself (equation 9), "l1" the sum (equation 10).
        unloading: contacts may press with less than their limit (Σ λ <= 1). False takes the
            equations to the letter (Σ λ = 1).
        engine: "ray", compiled ray shooting, or "highs", a linear program per task: slower
            and independent.
        tol: relative gap between ``lower`` and ``upper`` at which ellipsoids are accurate
            enough (up to 1e-5 where round-off keeps it open: the bounds say so); polytopes
            are solved to round-off unless it is above 1e-9.

    Raises:
        GraspError: for bad input, ellipsoids with engine "highs", or a gap that does not
            close within the iteration cap.
    """
    as_choice("engine", engine, ENGINES)
    bound = as_bound(bound)
    if engine == "highs":
        from graspq._engines.highs_engine import scale_all_by_lp

        return scale_all_by_lp(
            as_polytopes(wrenches, "engine 'highs'"), as_tasks(tasks), bound, unloading
        )
    global _ray
    if _ray is None:
        # Numba is slow to import, and an import statement slow to pass on every call.
        from graspq._engines import ray_engine as ray

        _ray = ray
    gap = as_number("tol", tol, positive=True)
    if unloading:
        found = _ray.scale_at_once(wrenches, tasks, bound, gap)
        if found is not None:
            return found
    return _ray.scale_by_ray(pack(wrenches, bound, unloading), as_tasks(tasks), gap)


def discretisation_error(
    contacts: Any,
    tasks: Any,
    edges: int = 12,
    augment: str = "none",
    bound: str = "linf",
    *,
    torque_scale: float = 1.0,
    origin: Any = (0.0, 0.0, 0.0),
) -> float:
    """Return the share of q* that sampling the friction ellipsoids with ``edges`` loses.

    ``1 - q*(edges) / q*(exact)``, between 0 and 1; NaN when the exact q* is 0.
    """
    from graspq.contact import contact_wrenches

    more = {"augment": augment, "torque_scale": torque_scale, "origin": origin}
    sampled, exact = (
        task_scaling([contact_wrenches(c, e, **more) for c in contacts], tasks, bound).value
        for e in (edges, None)
    )
    return max(0.0, 1.0 - sampled / exact) if exact > 0 else float("nan")
