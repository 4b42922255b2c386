"""q* of one task as a linear program, by SciPy's HiGHS: the independent check."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq.errors import GraspError
from graspq.scaling import INFEASIBLE, UNREACHABLE, TaskScaling, infeasible, nothing


class LpScaling(NamedTuple):
    """Scale of one task (-inf when infeasible) and the contacts' wrenches there, (n, 6)."""

    value: float
    forces: np.ndarray


def scale_by_lp(
    grasp: list[np.ndarray],
    task: np.ndarray,
    bound: str,
    unloading: bool,
    smallest: bool = False,
) -> LpScaling:
    """Maximise (or minimise) q >= 0 subject to Σ W_i λ_i = q t with the λ bounded as asked."""
    from scipy.optimize import linprog

    columns = np.hstack(grasp)
    owner = np.repeat(np.arange(len(grasp)), [w.shape[1] for w in grasp])
    # Rows and the task are brought to length one, so that HiGHS's absolute tolerances bite
    # at the same relative size in every grasp.
    size = np.maximum(np.abs(columns).max(axis=1), 1e-6 * max(np.abs(columns).max(), 1e-300))
    unit = columns / size[:, None]
    target = task / size
    length = float(np.linalg.norm(target))
    balance = np.column_stack([unit, -target / length])
    if bound == "linf":
        sums = (owner[None, :] == np.arange(len(grasp))[:, None]).astype(float)
    else:
        sums = np.ones((1, columns.shape[1]))
    sums = np.column_stack([sums, np.zeros(len(sums))])
    cost = np.zeros(balance.shape[1])
    cost[-1] = 1.0 if smallest else -1.0
    limits: dict[str, np.ndarray]
    if unloading:
        limits = {"A_eq": balance, "b_eq": np.zeros(6), "A_ub": sums, "b_ub": np.ones(len(sums))}
    else:
        limits = {"A_eq": np.vstack([balance, sums]),
                  "b_eq": np.concatenate([np.zeros(6), np.ones(len(sums))])}
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    result = linprog(cost, **limits, method="highs", options=tight)
    if result.status == 2:
        return LpScaling(-np.inf, np.full((len(grasp), 6), np.nan))
    if result.status != 0:
        raise GraspError(f"engine 'highs': {result.message}")
    weights = result.x[:-1]
    forces = np.stack([w @ weights[owner == i] for i, w in enumerate(grasp)])
    value = float(result.x[-1]) / length
    # A scale this far below the wrench set's own size is the solver's tolerance, not a wrench.
    return LpScaling(0.0 if result.x[-1] < 1e-9 else value, forces)


def scale_all_by_lp(
    grasp: list[np.ndarray], tasks: np.ndarray, bound: str, unloading: bool
) -> TaskScaling:
    """Return q* of a task set, one linear program (two without unloading) per task."""
    best = [scale_by_lp(grasp, task, bound, unloading) for task in tasks.T]
    values = np.array([s.value for s in best])
    least = np.zeros(len(values))
    if not unloading and np.isfinite(values).all():
        least = np.array([scale_by_lp(grasp, task, bound, unloading, smallest=True).value
                          for task in tasks.T])
    j, count = int(np.argmin(values)), len(grasp)
    value = float(values[j])
    if not np.isfinite(value):
        return infeasible(count, j, INFEASIBLE.format(j=j))
    if least.max() > value * (1 + 1e-9) + 1e-12:
        worst = int(np.argmax(least))
        return infeasible(count, worst, INFEASIBLE.format(j=worst))
    if value == 0.0 and unloading:
        return nothing(count, j, UNREACHABLE.format(j=j))
    return TaskScaling(value, value, value, j, best[j].forces)
