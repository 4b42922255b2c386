"""Everything that the metrics call, compiled or read from disk before it is needed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from graspq.ball import epsilon
from graspq.contact import Contact, contact_wrenches
from graspq.hand_bound import HandBound
from graspq.hand_scaling import hand_task_scaling
from graspq.scaling import task_scaling
from graspq.tasks import gravity_tasks
from graspq.volume import volume

_SPOTS = ((0.03, 0.0, 0.0), (-0.02, 0.02, 0.0), (-0.02, -0.02, 0.01))


def warm_up() -> float:
    """Compile what is not on this machine's disk, load the rest; the time it took [s].

    It takes half a minute of computing once per machine, and less than a second afterwards. Several
    processes that call this at the same time share the work.
    """
    begin = time.perf_counter()
    # Numba is slow to import; who imports this file need not call the function.
    from graspq._compiled.ball_batch import balls_in_bodies
    from graspq._compiled.minkowski_volume import add_facets
    from graspq._compiled.ray_batch import shoot_bodies
    from graspq._compiled.shared_motor_reach import reach
    from graspq._compiled.whitening import whiten_bodies

    grip = [Contact(p, -np.array(p) / np.linalg.norm(p), 0.6, 10.0, 0.01) for p in _SPOTS]
    sets = [contact_wrenches(contact) for contact in grip]
    tasks = gravity_tasks(0.5, np.zeros(3), [0, 0, -9.81])
    jacobians = [np.random.default_rng(k).normal(size=(6, 7)) * 0.05 for k in range(3)]
    hand = HandBound(grip, jacobians, np.ones(7), np.full(7, 0.5))
    # Entries, each with a call that needs it; what takes longest comes first.
    left: list[tuple[tuple[Any, ...], Callable[[], object]]] = [
        ((reach,), lambda: hand_task_scaling(hand, tasks)),
        ((shoot_bodies,), lambda: task_scaling(sets, tasks)),
        ((add_facets,), lambda: volume(sets)),
        ((whiten_bodies, balls_in_bodies), lambda: epsilon(sets)),
    ]
    while left:
        free = [pair for pair in left if not any(entry.busy for entry in pair[0])]
        pair = (free or left)[0]
        left.remove(pair)
        pair[1]()
    return time.perf_counter() - begin
