"""Calls of the compiled ray shooting: one task set, every ray by itself, or many grasps."""

from __future__ import annotations

import threading

import numpy as np

from graspq._compiled.body import Bodies
from graspq._compiled.ray_batch import (
    RAY_RESULTS,
    RESULTS,
    SOUND,
    STATUS,
    TASK,
    shoot_bodies,
)
from graspq._compiled.ray_shooting import CAPPED, ZERO
from graspq._compiled.workspace import STATE
from graspq._engines.bodies import some
from graspq._engines.whitening import whiten_polytopes
from graspq.inputs import NO_OWNERS, Packed

NO_FORCES, NO_RAYS, NO_SHIFT = np.zeros((0, 6)), np.zeros((0, RAY_RESULTS)), np.zeros((1, 6))
FIRST_TASK = np.zeros(1, dtype=np.int64)
_scratch = threading.local()


def scratch() -> np.ndarray:
    """The thread's own record of ``STATE``."""
    try:
        return _scratch.state
    except AttributeError:
        _scratch.state = np.empty(1, STATE)
        return _scratch.state


def reach(
    packed: Packed, tasks: np.ndarray, stop: float, shift: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Shoot along a task set; return the entry's results, (6,), and the contacts' wrenches."""
    contacts = packed.contacts + packed.fillers
    results, forces = np.zeros((1, RESULTS)), np.zeros((contacts, 6))
    shoot_bodies(
        *packed.body,
        NO_SHIFT if shift is None else shift[None],
        tasks,
        FIRST_TASK,
        np.array([tasks.shape[1]]),
        stop,
        packed.owners,
        packed.ellipsoid_owners,
        results,
        forces,
        NO_RAYS,
        scratch(),
    )
    return results[0], forces[: packed.contacts]


def reaches(
    body: Bodies, rays: np.ndarray, stop: float, shift: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shoot along every ray (6, m); return status (m,), reach (m,) and plane u (6, m).

    The plane u·x <= 1 stops the ray and holds the body, up to ``stop``.
    """
    # What is refused is as good as not solved.
    found = np.full((rays.shape[1], RAY_RESULTS), float(CAPPED))
    shoot_bodies(
        *body,
        NO_SHIFT if shift is None else shift[None],
        np.ascontiguousarray(rays),
        FIRST_TASK,
        np.array([rays.shape[1]]),
        stop,
        NO_OWNERS,
        NO_OWNERS,
        np.zeros((1, RESULTS)),
        NO_FORCES,
        found,
        scratch(),
    )
    return found[:, 0], found[:, 1], found[:, 2:].T


def reach_many(
    bodies: Bodies, tasks: np.ndarray, first_task: np.ndarray, last_task: np.ndarray, tol: float
) -> np.ndarray:
    """Shoot along the task sets of many polytopes that hold the origin.

    Returns per body 0, value, lower, upper and critical task, or 1 first where the body may be
    flat or round-off decides, shape (N, 5).
    """
    count = len(bodies.first_set) - 1
    results = np.zeros((count, RESULTS))
    shoot_bodies(
        *bodies,
        np.zeros((count, 6)),
        tasks,
        first_task,
        last_task,
        0.1 * tol if tol > 1e-9 else 1e-12,
        NO_OWNERS,
        NO_OWNERS,
        results,
        NO_FORCES,
        NO_RAYS,
        scratch(),
    )
    doubtful = results[:, STATUS] > ZERO
    unsure = np.flatnonzero(~doubtful & (results[:, SOUND] == 0.0))
    if len(unsure):
        doubtful[unsure] = whiten_polytopes(some(bodies, unsure)).flat
    results[:, STATUS] = doubtful
    return results[:, : TASK + 1]
