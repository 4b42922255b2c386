"""Grasp metrics of a perceived grasp: the columns that outcomes are compared with."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Callable, Iterable

import numpy as np

import graspq as gq
from sdh_sim.sensing import PerceivedGrasp

EDGES = 12
AUGMENT = "hf"
HELD_SLACK = 0.05  # a motor whose torque is within 5 % of its limit counts as saturated
# The sum of four contacts' wrench sets has 10^4 facets and takes half a second: not for every
# trial of a long run.
MAX_VOLUME_CONTACTS = 3

WHOLE = "q_whole_hand"

Metric = Callable[[PerceivedGrasp], float]


def wrench_sets(
    grasp: PerceivedGrasp, edges: int | None = EDGES, augment: str = AUGMENT
) -> list[np.ndarray]:
    """Wrench set of every contact about the centre of mass, equations (1) to (3).

    Args:
        grasp: the grasp.
        edges: of the friction cones; None: round cones.
        augment: what moments soft contacts can exert (``graspq.contact_wrenches``).

    Returns:
        for each contact (6, l) [N, N m], object axes.

    Raises:
        graspq.GraspError: edges or augment that do not exist.
    """
    return [gq.contact_wrenches(p.contact, edges=edges, augment=augment) for p in grasp.contacts]


def task_scaling(grasp: PerceivedGrasp, bound: str) -> gq.TaskScaling:
    """q*, equation (9) for ``linf`` or (10) for ``l1``, with certificate and contact forces."""
    return gq.task_scaling(wrench_sets(grasp), grasp.task, bound=bound)


def hand_bound(grasp: PerceivedGrasp, held: bool, whole: bool = False) -> gq.HandBound:
    """The contacts behind their shared motors.

    Args:
        grasp: the grasp, with at least one contact.
        held: saturated motors keep their torque.
        whole: with all contacts of the hand, not those of the chosen pads alone.
    """
    contacts = (*grasp.contacts, *grasp.others) if whole else grasp.contacts
    return gq.HandBound(
        [p.contact for p in contacts],
        [p.jacobian for p in contacts],
        grasp.torque_limits,
        motor_torque=grasp.snapshot.motor_torques if held else None,
        slack=HELD_SLACK,
        transmission=grasp.transmission,
    )


def _hand_scaling(grasp: PerceivedGrasp, held: bool = False, whole: bool = False) -> float:
    """q* of the contacts behind their shared motors; arguments as ``hand_bound``."""
    return gq.hand_task_scaling(hand_bound(grasp, held, whole), grasp.task, edges=EDGES).value


def _volume(grasp: PerceivedGrasp, bound: str) -> float:
    """Volume of the wrench space [N^3 (N m)^3]; NaN with more contacts than are computed.

    Of soft contacts at their centres: forces and torsion there, nothing at the other taxels.
    """
    if len(grasp.contacts) > MAX_VOLUME_CONTACTS:
        return math.nan
    return gq.volume(wrench_sets(grasp, augment="none"), bound=bound)


METRICS: dict[str, Metric] = {
    "q_linf": lambda grasp: task_scaling(grasp, "linf").value,
    "q_l1": lambda grasp: task_scaling(grasp, "l1").value,
    "q_capability": _hand_scaling,
    "q_held": lambda grasp: _hand_scaling(grasp, held=True),
    WHOLE: lambda grasp: _hand_scaling(grasp, whole=True),
    "epsilon_linf": lambda grasp: gq.epsilon(wrench_sets(grasp), bound="linf"),
    "epsilon_l1": lambda grasp: gq.epsilon(wrench_sets(grasp), bound="l1"),
    "volume_linf": lambda grasp: _volume(grasp, "linf"),
    "volume_l1": lambda grasp: _volume(grasp, "l1"),
}
"""Metrics of every trial, by column name; each is 0 without the contacts it looks at."""


def evaluate(grasp: PerceivedGrasp, metrics: dict[str, Metric] = METRICS) -> dict[str, float]:
    """Values of metrics, by name; NaN where a metric cannot be computed for this grasp."""
    values = dict.fromkeys(metrics, math.nan if grasp.contacts else 0.0)
    for name in _compile_order(metrics):
        if not grasp.contacts and (name != WHOLE or not grasp.others):
            continue
        with contextlib.suppress(gq.GraspError):  # a space too close to flat for its volume
            values[name] = float(metrics[name](grasp))
    return values


def _compile_order(names: Iterable[str]) -> list[str]:
    """The names forward or backward, by the process.

    Two new workers then compile different metrics first, and each finds on the disk what the other
    has compiled, which halves the wait.
    """
    order = list(names)
    return order[::-1] if os.getpid() % 2 else order
