"""Task wrench set scaling q* (equations 9 and 10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from graspq.errors import as_choice
from graspq.sets import as_bound, as_grasp, as_tasks

ENGINES = ("highs",)
UNREACHABLE = "task {j} lies outside the cone of wrenches that the contacts can exert"
INFEASIBLE = "no scale q >= 0 puts every task inside the wrench space"


@dataclass(frozen=True, eq=False)
class TaskScaling:
    """The largest factor by which every task wrench stays inside the wrench space.

    Attributes:
        value: q*; 0.0 when a task cannot be exerted at all, -inf when the contacts cannot
            unload and no scale is feasible.
        lower: certified lower bound on q*.
        upper: certified upper bound on q*.
        critical_task: column of the task set that limits q*.
        forces: wrench of every contact at the optimum, (force [N], moment [N m]), shape
            (n, 6); they add up to ``value`` times the critical task. Zero when ``value`` is 0,
            NaN when it is -inf.
        reason: why ``value`` is 0 or -inf; empty otherwise.
    """

    value: float
    lower: float
    upper: float
    critical_task: int
    forces: np.ndarray
    reason: str = ""


def task_scaling(
    wrenches: Any,
    tasks: Any,
    bound: str = "linf",
    unloading: bool = True,
    engine: str = "highs",
) -> TaskScaling:
    """Return q*: how far the task wrenches can be scaled inside the grasp wrench space.

    Args:
        wrenches: one (6, l_i) array per contact, from ``contact_wrenches``.
        tasks: task wrenches, shape (6, m), in the same frame, origin and torque scale.
        bound: "linf" bounds every contact by itself (equation 9), "l1" the sum (equation 10).
        unloading: contacts may press with less than their limit (Σ λ <= 1). False takes the
            equations to the letter (Σ λ = 1).
        engine: "highs", a linear program per task.

    Raises:
        GraspError: for bad input.
    """
    grasp = as_grasp(wrenches)
    bound = as_bound(bound)
    columns = as_tasks(tasks)
    as_choice("engine", engine, ENGINES)
    return _by_highs(grasp, columns, bound, unloading)


def _by_highs(
    grasp: list[np.ndarray], tasks: np.ndarray, bound: str, unloading: bool
) -> TaskScaling:
    from graspq.lp import scale_by_lp

    highest, lowest = [], []
    for task in tasks.T:
        solution = scale_by_lp(grasp, task, bound, unloading)
        highest.append(solution)
        lowest.append(0.0 if unloading else scale_by_lp(
            grasp, task, bound, unloading, smallest=True).value)
    values = np.array([s.value for s in highest])
    j = int(np.argmin(values))
    best = highest[j]
    count = len(grasp)
    if not np.isfinite(values[j]) or max(lowest) > values[j] * (1 + 1e-9) + 1e-12:
        return TaskScaling(-np.inf, -np.inf, -np.inf, j, np.full((count, 6), np.nan), INFEASIBLE)
    if best.value == 0.0:
        reason = UNREACHABLE.format(j=j)
        return TaskScaling(0.0, 0.0, 0.0, j, np.zeros((count, 6)), reason)
    return TaskScaling(best.value, best.value, best.value, j, best.forces)
