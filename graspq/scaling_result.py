"""What task scaling returns: the value, its certificate, and the reason where it is 0 or less."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

UNREACHABLE = "task {j} lies outside the cone of wrenches that the contacts can exert"


FLAT = "task {j} lies outside the {rank}-dimensional span of what the contacts can exert"


INFEASIBLE = (
    "no scale q >= 0 puts task {j} inside the wrench space: without unloading the"
    " contacts press with their limit"
)


@dataclass(frozen=True, eq=False, init=False)
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

    def __init__(
        self,
        value: float,
        lower: float,
        upper: float,
        critical_task: int,
        forces: np.ndarray,
        reason: str = "",
    ) -> None:
        # What a frozen dataclass writes sets every field by itself, which takes twice as long.
        self.__dict__.update(
            value=value,
            lower=lower,
            upper=upper,
            critical_task=critical_task,
            forces=forces,
            reason=reason,
        )


def nothing(contacts: int, critical: int, reason: str, upper: float = 0.0) -> TaskScaling:
    """The result for a task that cannot be exerted at all."""
    forces = np.zeros((contacts, 6))
    return TaskScaling(0.0, 0.0, upper, critical, forces, reason)


def infeasible(contacts: int, critical: int, reason: str) -> TaskScaling:
    """The result when no scale is feasible."""
    forces = np.full((contacts, 6), np.nan)
    return TaskScaling(-np.inf, -np.inf, -np.inf, critical, forces, reason)


@dataclass(frozen=True, eq=False)
class HandScaling(TaskScaling):
    """A ``TaskScaling`` with what the hand does at the optimum.

    Attributes:
        motor_torque: load of the motors Σ J_iᵀ f_i, shape (k,) [N m]; NaN without forces.
        point_forces: per contact the force at each of its points, shape (p_i, 3) [N].
        least: smallest scale at which every task is balanced; above 0 only when held.
    """

    motor_torque: np.ndarray = field(default_factory=lambda: np.zeros(0))
    point_forces: tuple[np.ndarray, ...] = ()
    least: float = 0.0
