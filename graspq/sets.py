"""Checks for the arguments that every metric shares: a grasp, a bound, a task set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from graspq.errors import GraspError, as_array, as_choice

BOUNDS = ("linf", "l1")


def as_grasp(wrenches: Any) -> list[np.ndarray]:
    """Return the contacts' wrench sets as float arrays of shape (6, l_i)."""
    if isinstance(wrenches, np.ndarray) and wrenches.ndim == 2:
        raise GraspError("wrenches: expected a list of (6, l) arrays, one per contact, got one"
                         f" array of shape {wrenches.shape}; wrap it in a list")
    if not isinstance(wrenches, Sequence | np.ndarray):
        raise GraspError("wrenches: expected a list of (6, l) arrays, one per contact, got"
                         f" {type(wrenches).__name__}")
    if len(wrenches) == 0:
        raise GraspError("wrenches: the grasp is empty; give at least one contact's wrenches")
    grasp = [as_array(f"wrenches[{i}]", w, (6, None)) for i, w in enumerate(wrenches)]
    for i, w in enumerate(grasp):
        if w.shape[1] == 0:
            raise GraspError(f"wrenches[{i}]: got no column; leave the contact out instead")
    return grasp


def as_bound(bound: Any) -> str:
    """Return ``bound`` when it is "linf" or "l1"."""
    return as_choice("bound", bound, BOUNDS)


def as_tasks(tasks: Any) -> np.ndarray:
    """Return task wrenches of shape (6, m), m >= 1, none of them zero."""
    array = np.asarray(tasks, dtype=float) if not isinstance(tasks, np.ndarray) else tasks
    if array.ndim == 1:
        array = array[:, None]
    array = as_array("tasks", array, (6, None), "one task wrench per column")
    if array.shape[1] == 0:
        raise GraspError("tasks: got no column; give at least one task wrench")
    empty = ~array.any(axis=0)
    if empty.any():
        raise GraspError(f"tasks: column {int(np.argmax(empty))} is zero; a zero wrench can be"
                         " scaled without end, leave it out")
    return array
