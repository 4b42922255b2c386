"""q* of one task as a linear program, by SciPy's HiGHS: the independent check.

A scale is returned with wrenches that balance the task, "infeasible" with a plane that proves it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from graspq.errors import GraspError
from graspq.scaling_result import INFEASIBLE, UNREACHABLE, TaskScaling, infeasible, nothing

WIDEST = 1e-5
# In units of the rows' sizes: what balanced wrenches may be off by, and a missed task must exceed.
BALANCED = 1e-9
TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
CLOSE = (
    "the grasp is too close to degenerate: drop contacts that all but repeat or cancel"
    " another, or bring forces and moments to like sizes (torque_scale)"
)


class LpScaling(NamedTuple):
    """Scale of one task (-inf when infeasible), a dual bound, and the wrenches there, (n, 6)."""

    value: float
    upper: float
    forces: np.ndarray


def scale_by_lp(
    grasp: list[np.ndarray],
    task: np.ndarray,
    bound: str,
    unloading: bool,
    smallest: bool = False,
) -> LpScaling:
    """Maximise (or minimise) q >= 0 subject to Σ W_i λ_i = q t with the λ bounded as asked."""
    columns = np.hstack(grasp)
    owner = np.repeat(np.arange(len(grasp)), [w.shape[1] for w in grasp])
    # Rows and the task are brought to length one, so that HiGHS's absolute tolerances bite
    # at the same relative size in every grasp.
    largest = float(np.abs(columns).max()) or 1.0
    size = np.maximum(np.abs(columns).max(axis=1), 1e-6 * largest)
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
        limits = {
            "A_eq": np.vstack([balance, sums]),
            "b_eq": np.concatenate([np.zeros(6), np.ones(len(sums))]),
        }
    result = _solve(cost, limits, TIGHT)
    if result.status != 0 and not unloading and _misses(limits, size, grasp, task, bound):
        return LpScaling(-np.inf, -np.inf, np.full((len(grasp), 6), np.nan))
    for options in ({**TIGHT, "presolve": False}, {}, {"presolve": False}):
        if result.status != 0:
            result = _solve(cost, limits, options)
    if result.status != 0:
        raise GraspError(f"task_scaling: HiGHS could not decide (status {result.status}); {CLOSE}")
    x = _polish(result.x, np.vstack([balance, sums]), unloading)
    weights = x[:-1]
    forces = np.stack([w @ weights[owner == i] for i, w in enumerate(grasp)])
    # A scale this far below the wrench set's own size is the solver's tolerance, not a wrench.
    value = 0.0 if x[-1] < 1e-9 else float(x[-1]) / length
    dual = np.asarray(result.eqlin.marginals)[:6] / size
    dual = -dual if dual @ task < 0 else dual
    support = _support(dual, grasp, bound, unloading)
    upper = support / float(dual @ task) if dual @ task > 0 else np.inf
    return LpScaling(value, max(value, upper), forces)


def _solve(cost: np.ndarray, limits: dict[str, np.ndarray], options: dict[str, Any]) -> Any:
    from scipy.optimize import linprog

    return linprog(cost, **limits, method="highs", options=options)


def _support(dual: np.ndarray, grasp: list[np.ndarray], bound: str, unloading: bool) -> float:
    """The largest product of ``dual`` with a wrench that the contacts can exert together."""
    tops = [float((dual @ w).max()) for w in grasp]
    tops = tops if bound == "linf" else [max(tops)]
    return sum(max(top, 0.0) if unloading else top for top in tops)


def _misses(
    limits: dict[str, np.ndarray],
    size: np.ndarray,
    grasp: list[np.ndarray],
    task: np.ndarray,
    bound: str,
) -> bool:
    """Whether a plane proves that no q >= 0 puts q t in the set, all limits being equations.

    HiGHS calls some such problems neither feasible nor infeasible. How far the wrenches stay
    from balance always has a least value, and its dual y is the plane: y·w < 0 for every w in
    the set but y·t > 0. Only these signs count, whatever HiGHS's tolerance made of y.
    """
    rows, bounds = limits["A_eq"], limits["b_eq"]
    off = np.vstack([np.eye(6), np.zeros((len(rows) - 6, 6))])
    cost = np.concatenate([np.zeros(rows.shape[1]), np.ones(12)])
    result = _solve(cost, {"A_eq": np.hstack([rows, off, -off]), "b_eq": bounds}, TIGHT)
    if result.status != 0:
        return False
    y = np.asarray(result.eqlin.marginals)[:6]
    unit = -rows[:6, -1]
    # Often the task's ray is parallel to the plane up to round-off: tilt it to lead away.
    y = y + max(0.0, 1e-12 - float(y @ unit)) * unit
    # Each product is off by at most 1e-15 of the sum of its terms' absolute values.
    along = float(y / size @ task) - 1e-15 * float(np.abs(y / size) @ np.abs(task))
    gap = -_support(y / size, grasp, bound, unloading=False)
    return along > 0 and gap > BALANCED * float(np.abs(y).sum())


def _polish(x: np.ndarray, rows: np.ndarray, unloading: bool) -> np.ndarray:
    """Take HiGHS's vertex from its tolerance to round-off, where its basis allows."""
    used = np.flatnonzero(x > 1e-9)
    if not len(used):
        return x
    full = rows[6:] @ x > 1.0 - 1e-9
    full = full if unloading else np.ones(len(full), dtype=bool)
    a = np.vstack([rows[:6], rows[6:][full]])[:, used]
    b = np.concatenate([np.zeros(6), np.ones(int(full.sum()))])
    better = x.copy()
    better[used] = np.linalg.lstsq(a, b, rcond=1e-14)[0]
    if (
        (better >= -1e-12).all()
        and np.abs(a @ better[used] - b).max() < 1e-13
        and (np.abs(better - x).max() < 1e-6 * max(1.0, x.max()))
    ):
        return np.maximum(better, 0.0)
    if np.abs(rows[:6] @ x).max() > BALANCED:
        raise GraspError(f"task_scaling: HiGHS balances the wrenches only roughly; {CLOSE}")
    return x


def scale_all_by_lp(
    grasp: list[np.ndarray], tasks: np.ndarray, bound: str, unloading: bool
) -> TaskScaling:
    """Return q* of a task set, one linear program (two without unloading) per task."""
    best = [scale_by_lp(grasp, task, bound, unloading) for task in tasks.T]
    values = np.array([s.value for s in best])
    least = np.zeros(len(values))
    if not unloading and np.isfinite(values).all():
        least = np.array(
            [scale_by_lp(grasp, task, bound, unloading, smallest=True).value for task in tasks.T]
        )
    j, count = int(np.argmin(values)), len(grasp)
    value = float(values[j])
    if not np.isfinite(value):
        return infeasible(count, j, INFEASIBLE.format(j=j))
    if least.max() > value * (1 + 1e-9) + 1e-12:
        worst = int(np.argmax(least))
        return infeasible(count, worst, INFEASIBLE.format(j=worst))
    if value == 0.0 and unloading:
        return nothing(count, j, UNREACHABLE.format(j=j), max(0.0, best[j].upper))
    upper = max(value, min(s.upper for s in best))
    if value > 0 and upper > value * (1 + WIDEST):
        raise GraspError(f"task_scaling: the bounds stay {value:.9g} to {upper:.9g} apart; {CLOSE}")
    return TaskScaling(value, value, upper, j, best[j].forces)
