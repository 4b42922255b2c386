"""Checks for the arguments that every metric shares, and a grasp packed for compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from graspq._compiled.body import Bodies
from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError, as_array, as_choice

BOUNDS = ("linf", "l1")


NO_CENTRES, NO_AXES = np.zeros((6, 0)), np.zeros((0, 6, 3))
NO_OWNERS = np.zeros(0, dtype=np.int64)


class Packed(NamedTuple):
    """One grasp as arrays.

    Attributes:
        body: the grasp's wrench space.
        owners, ellipsoid_owners: contact of every point and ellipsoid.
        contacts: number of contacts.
        fillers: number of contacts that were added to fill a flat space's missing directions.
    """

    body: Bodies
    owners: np.ndarray
    ellipsoid_owners: np.ndarray
    contacts: int
    fillers: int = 0

    @property
    def smooth(self) -> bool:
        """Whether the set has ellipsoids."""
        return self.body.centres.shape[1] > 0


def as_grasp(wrenches: Any) -> list[np.ndarray | EllipsoidSet]:
    """Return the contacts' wrench sets: float arrays of shape (6, l_i), or ellipsoid sets."""
    if isinstance(wrenches, EllipsoidSet) or (
        isinstance(wrenches, np.ndarray) and wrenches.ndim == 2
    ):
        raise GraspError(
            "wrenches: expected a list of (6, l) arrays, one per contact, got one"
            " contact's set; wrap it in a list"
        )
    if not isinstance(wrenches, Sequence | np.ndarray) or isinstance(wrenches, str):
        raise GraspError(
            "wrenches: expected a list of (6, l) arrays, one per contact, got"
            f" {type(wrenches).__name__}"
        )
    if len(wrenches) == 0:
        raise GraspError("wrenches: the grasp is empty; give at least one contact's wrenches")
    grasp: list[np.ndarray | EllipsoidSet] = []
    for i, w in enumerate(wrenches):
        if not isinstance(w, EllipsoidSet):
            if not (
                isinstance(w, np.ndarray)
                and w.dtype == np.float64
                and w.ndim == 2
                and w.shape[0] == 6
            ):
                w = as_array(f"wrenches[{i}]", w, (6, None))
            if w.shape[1] == 0:
                raise GraspError(f"wrenches[{i}]: got no column; leave the contact out instead")
        elif w.size == 0:
            raise GraspError(f"wrenches[{i}]: got an empty set; leave the contact out instead")
        grasp.append(w)
    return grasp


def as_polytopes(wrenches: Any, what: str) -> list[np.ndarray]:
    """Return the contacts' vertices; ``what`` cannot take ellipsoids."""
    arrays = []
    for i, w in enumerate(as_grasp(wrenches)):
        if isinstance(w, EllipsoidSet):
            raise GraspError(
                f"wrenches[{i}]: {what} needs vertices, got an EllipsoidSet; give"
                " contact_wrenches a number of edges"
            )
        arrays.append(w)
    return arrays


def pack(wrenches: Any, bound: str, unloading: bool) -> Packed:
    """Check a grasp and return it packed; the L1 space is one body, the hull of all."""
    grasp = as_grasp(wrenches)
    points = [w.points if isinstance(w, EllipsoidSet) else w for w in grasp]
    counts = [p.shape[1] for p in points]
    columns = np.concatenate(points, axis=1)
    if not np.isfinite(columns).all():
        for i, w in enumerate(points):
            as_array(f"wrenches[{i}]", w, (6, None))
    numbers = np.arange(len(grasp))
    owners = np.repeat(numbers, counts)
    smooth = [w for w in grasp if isinstance(w, EllipsoidSet)]
    if smooth:
        balls = [w.centres.shape[1] if isinstance(w, EllipsoidSet) else 0 for w in grasp]
        centres = np.concatenate([w.centres for w in smooth], axis=1)
        axes = np.concatenate([w.axes for w in smooth])
    else:
        balls = [0] * len(grasp)
        centres, axes = NO_CENTRES, NO_AXES
    ellipsoid_owners = np.repeat(numbers, balls)
    if bound == "l1":
        counts, balls = [sum(counts)], [sum(balls)]
    starts = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(counts, out=starts[1:])
    ends = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(balls, out=ends[1:])
    body = Bodies(
        np.ascontiguousarray(columns),
        starts,
        np.ascontiguousarray(centres),
        axes,
        ends,
        np.array([0, len(counts)]),
        bool(unloading),
    )
    return Packed(body, owners, ellipsoid_owners, len(grasp))


def as_bound(bound: Any) -> str:
    """Return ``bound`` when it is "linf" or "l1"."""
    return as_choice("bound", bound, BOUNDS)


def as_tasks(tasks: Any) -> np.ndarray:
    """Return task wrenches as a fresh array of shape (6, m), m >= 1, none of them zero."""
    if np.ndim(tasks) == 1:
        tasks = np.asarray(tasks)[:, None]
    array = np.ascontiguousarray(as_array("tasks", tasks, (6, None), "one task per column"))
    if array.shape[1] == 0:
        raise GraspError("tasks: got no column; give at least one task wrench")
    empty = ~array.any(axis=0)
    if empty.any():
        raise GraspError(
            f"tasks: column {int(np.argmax(empty))} is zero; a zero wrench can be"
            " scaled without end, leave it out"
        )
    return array
