"""Task scaling within what motors allow that contacts share."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graspq.errors import GraspError, as_array, as_number
from graspq.hand_bound import HandBound
from graspq.inputs import as_tasks
from graspq.scaling_result import HandScaling


def hand_task_scaling(
    hand: HandBound,
    tasks: ArrayLike,
    edges: int | None = 12,
    *,
    torque_scale: float = 1.0,
    origin: ArrayLike = (0.0, 0.0, 0.0),
) -> HandScaling:
    """Return how far the task wrenches can be scaled by what the hand's motors allow.

    The largest q with Σ G_i f_i = q t for every task t, every f_i in its friction cone and
    ``hand.lower`` <= Σ J_iᵀ f_i <= ``hand.upper``; each task may use forces of its own.

    Args:
        hand: contacts and motors.
        tasks: task wrenches, shape (6, m).
        edges: edges of every friction cone (its apices ``±τ*/g*`` when it is soft), None for
            the cone itself.
        torque_scale: as used for ``tasks``.
        origin: as used for ``tasks``, shape (3,) [m].

    Returns:
        The scaling; ``value`` is -inf with the reason when no equilibrium exists, inf when
        the motors do not limit it at all.
    """
    from graspq._engines.hand_engine import solve

    if not isinstance(hand, HandBound):
        raise GraspError(f"hand: expected a HandBound, got {type(hand).__name__}")
    if edges is not None and (
        isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3
    ):
        raise GraspError(f"edges: expected an integer >= 3 or None, got {edges!r}")
    about = as_array("origin", origin, (3,))
    scale = as_number("torque_scale", torque_scale, positive=True)
    return solve(hand, as_tasks(tasks), edges, about, scale)
