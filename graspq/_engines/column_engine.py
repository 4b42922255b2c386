"""q* of ellipsoids by linear programs over a growing choice of their points.

Slow and sturdy: the way out for sets that touch the task's ray or the origin only just.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from graspq._engines.bodies import span_of, support_values, tip
from graspq.errors import GraspError
from graspq.inputs import Packed
from graspq.scaling_result import INFEASIBLE, UNREACHABLE, TaskScaling, infeasible, nothing

ROUNDS = 120
CLOSED, ENOUGH, NOWHERE = 1e-9, 1e-5, 1e-9


class _Ray(NamedTuple):
    """Bounds on the scale of one task and the contacts' wrenches, (n, 6)."""

    lower: float
    upper: float
    forces: np.ndarray


class _Pool:
    """Points of every body, in units of the set's extent."""

    def __init__(self, packed: Packed) -> None:
        self.packed = packed
        self.size = span_of(packed.body).size
        points, starts, centres, axes, first, _, zero = packed.body
        self.sets = len(starts) - 1
        self.columns: list[np.ndarray] = []
        self.set: list[int] = []
        self.owner: list[int] = []
        for i in range(self.sets):
            for k in range(starts[i], starts[i + 1]):
                self._add(points[:, k], i, packed.owners[k])
            for k in range(first[i], first[i + 1]):
                for side in (*axes[k].T, *-axes[k].T):
                    self._add(centres[:, k] + side, i, packed.ellipsoid_owners[k])
            if zero:
                self._add(np.zeros(6), i, 0)

    def _add(self, wrench: np.ndarray, part: int, owner: int) -> None:
        self.columns.append(wrench / self.size)
        self.set.append(part)
        self.owner.append(int(owner))

    def ask(self, u: np.ndarray) -> float:
        """Add every set's furthest ellipsoid's support point; return the support value."""
        body, direction = self.packed.body, u / self.size
        turned = np.einsum("krc,r->kc", body.axes, direction)
        reach = direction @ body.centres + np.linalg.norm(turned, axis=1)
        for i in range(self.sets):
            first, end = body.first_ellipsoid[i], body.first_ellipsoid[i + 1]
            if end > first:
                k = int(first + np.argmax(reach[first:end]))
                wrench = body.centres[:, k] + tip(body.axes[k], direction)
                self._add(wrench, i, self.packed.ellipsoid_owners[k])
        return float(support_values(body, direction[:, None])[0])

    def solve(self, task: np.ndarray, goal: int, slack: float) -> Any:
        """LP over the pool: goal 0 closes the gap to the ray, ±1 moves q up or down."""
        from scipy.optimize import linprog

        count = len(self.columns)
        balance = np.column_stack([np.array(self.columns).T, -task, np.eye(6), -np.eye(6)])
        sums = np.zeros((self.sets, count + 13))
        sums[self.set, np.arange(count)] = 1.0
        cost = np.zeros(count + 13)
        cost[count] = -goal
        cost[count + 1 :] = 1.0 if goal == 0 else 0.0
        bounds = [(0, None)] * (count + 1) + [(0, None if goal == 0 else slack)] * 12
        return linprog(
            cost,
            A_eq=np.vstack([balance, sums]),
            bounds=bounds,
            method="highs",
            b_eq=np.concatenate([np.zeros(6), np.ones(self.sets)]),
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )

    def forces(self, x: np.ndarray) -> np.ndarray:
        """The contacts' wrenches at weights ``x`` of the first columns."""
        total = np.zeros((self.packed.contacts, 6))
        count = len(x)
        np.add.at(total, self.owner[:count], np.array(self.columns[:count]) * x[:, None])
        return total * self.size


def _touch(pool: _Pool, task: np.ndarray) -> float | None:
    """Grow the pool until it meets the ray; return the gap left, None when the set misses it."""
    gap = np.inf
    for _ in range(ROUNDS):
        result = pool.solve(task, 0, 0.0)
        if result.status != 0:
            break
        gap = float(result.fun)
        if gap <= 0.1 * NOWHERE:
            return gap
        # For every such u no point of the ray is nearer to the set than -h(u).
        away = -pool.ask(np.asarray(result.eqlin.marginals)[:6])
        if away > NOWHERE:
            return None
        if gap - away < 0.1 * NOWHERE:
            return gap
    raise GraspError(
        "task_scaling: could not tell whether the task meets the wrench space (the"
        " grasp is close to degenerate); take a number of edges"
    )


def _end(pool: _Pool, task: np.ndarray, goal: int, slack: float) -> _Ray:
    """Largest (goal 1) or smallest (goal -1) scale q."""
    lower, upper, x = 0.0, np.inf, np.zeros(0)
    count = 0
    for _ in range(ROUNDS):
        result = pool.solve(task, goal, slack)
        if result.status != 0:
            break
        count = len(pool.columns)
        x, value = result.x, float(result.x[count])
        u = np.asarray(result.eqlin.marginals)[:6]
        along = goal * float(u @ task)
        h = pool.ask(u)
        bound = goal * h / along if along > 0 else goal * np.inf
        lower, upper = (
            (value, min(upper, bound)) if goal > 0 else (max(lower, bound), min(upper, value))
        )
        if upper - lower <= CLOSED * max(upper, 1e-3):
            break
    if not len(x) or upper - lower > ENOUGH * max(upper, 1e-3):
        raise GraspError(
            "task_scaling: the bounds did not close (the grasp is close to"
            " degenerate); take a number of edges"
        )
    return _Ray(lower, upper, pool.forces(x[:count]))


def scale_by_columns(packed: Packed, tasks: np.ndarray) -> TaskScaling:
    """Return q* of a checked grasp and task set."""
    pool = _Pool(packed)
    zero = packed.body.holds_origin
    value, upper, critical, forces = np.inf, np.inf, 0, np.zeros((packed.contacts, 6))
    least, last = 0.0, 0
    for j, task in enumerate(tasks.T):
        scaled = task / pool.size
        length = float(np.linalg.norm(scaled))
        gap = _touch(pool, scaled / length)
        if gap is None:
            return infeasible(packed.contacts, j, INFEASIBLE.format(j=j))
        high = _end(pool, scaled / length, 1, gap)
        if high.lower / length < value:
            value, critical, forces = high.lower / length, j, high.forces
        upper = min(upper, high.upper / length)
        if not zero:
            low = _end(pool, scaled / length, -1, gap).lower / length
            if low > least:
                least, last = low, j
    top = np.abs(tasks / pool.size[:, None]).max()
    if least > upper * (1 + 1e-9) + NOWHERE / top:
        return infeasible(packed.contacts, last, INFEASIBLE.format(j=last))
    if value * top < NOWHERE:
        if zero:
            return nothing(packed.contacts, critical, UNREACHABLE.format(j=critical), upper)
        value = 0.0
    return TaskScaling(value, value, max(value, upper), critical, forces)
