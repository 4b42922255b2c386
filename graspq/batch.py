"""Metrics of many grasps at once, in parallel over the processor's cores."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from graspq._compiled.body import Bodies
from graspq.ball import FIRST_FACETS, FIRST_VERTICES, epsilon
from graspq.errors import GraspError, as_number
from graspq.inputs import NO_AXES, NO_CENTRES, as_bound, as_tasks
from graspq.scaling import task_scaling

CHUNKS = 8
PACKED = 20_000


class ScalingBatch(NamedTuple):
    """q* of many grasps; every field has shape (N,), see ``TaskScaling``."""

    value: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    critical_task: np.ndarray


def task_scaling_batch(
    grasps: Sequence[Any] | np.ndarray,
    tasks: Any,
    bound: str = "linf",
    unloading: bool = True,
    *,
    tol: float = 1e-9,
    workers: int | None = None,
) -> ScalingBatch:
    """Return q* of every grasp.

    Args:
        grasps: N grasps, each a list of (6, l_i) arrays or ``EllipsoidSet``; or, where all have
            as many contacts and columns, one array (N, n, 6, l), which spares packing them.
        tasks: one task set (6, m) for all, or N of them, one per grasp: a list or (N, 6, m).
        bound: as in ``task_scaling``.
        unloading: as in ``task_scaling``.
        tol: as in ``task_scaling``.
        workers: number of threads; None takes every core.

    Raises:
        GraspError: for bad input, naming the grasp.
    """
    as_bound(bound)
    as_number("tol", tol, positive=True)
    count = _count(grasps)
    shared = isinstance(tasks, np.ndarray) and tasks.ndim == 2
    if not shared and len(tasks) != count:
        raise GraspError(
            f"tasks: expected one array (6, m) or a list of {count} of them, one"
            f" per grasp, got {len(tasks)}"
        )
    common = as_tasks(tasks) if shared else None
    out = np.zeros((count, 5))
    out[:, 0] = 1.0

    def stretch(low: int, high: int) -> None:
        # Packed here and not before, so that one thread packs while another computes.
        sets = (common, None) if common is not None else _task_sets(tasks[low:high], low)
        bodies = _side_by_side(grasps[low:high], bound)
        if bodies is None:
            return
        from graspq._engines.shooting import reach_many

        wanted, ends = sets
        if ends is None:
            begins = np.zeros(high - low, dtype=np.int64)
            ends = np.full(high - low, wanted.shape[1], dtype=np.int64)
        else:
            begins, ends = ends[:-1], ends[1:]
        out[low:high] = reach_many(bodies, wanted, begins, ends, tol)

    def one(g: int) -> None:
        own = common if common is not None else tasks[g]
        s = task_scaling(_contacts(grasps[g]), own, bound, unloading, tol=tol)
        out[g] = 0, s.value, s.lower, s.upper, s.critical_task

    if unloading:
        _spread(count, workers, stretch, _most(grasps))
    elif common is None:
        _task_sets(tasks, 0)
    left = np.flatnonzero(out[:, 0])
    _each(left, workers, one)
    return ScalingBatch(out[:, 1], out[:, 2], out[:, 3], out[:, 4].astype(np.int64))


def epsilon_batch(
    grasps: Sequence[Any] | np.ndarray,
    bound: str = "linf",
    unloading: bool = True,
    *,
    tol: float = 1e-5,
    workers: int | None = None,
) -> np.ndarray:
    """Return ε of every grasp, shape (N,); arguments as in ``epsilon``."""
    as_bound(bound)
    as_number("tol", tol, positive=True)
    count = _count(grasps)
    out = np.zeros((count, 2))
    out[:, 0] = 1.0

    def stretch(low: int, high: int) -> None:
        bodies = _side_by_side(grasps[low:high], bound)
        if bodies is None:
            return
        from graspq._engines.ball_engine import balls_of

        found = balls_of(
            bodies._replace(holds_origin=bool(unloading)), 0.0, FIRST_FACETS, FIRST_VERTICES
        )
        out[low:high, 0], out[low:high, 1] = found.status, found.upper

    def one(g: int) -> None:
        out[g] = 0, epsilon(_contacts(grasps[g]), bound, unloading, tol)

    _spread(count, workers, stretch, _most(grasps))
    left = np.flatnonzero(out[:, 0])
    _each(left, workers, one)
    return out[:, 1]


def volume_batch(
    grasps: Sequence[Any] | np.ndarray,
    bound: str = "linf",
    unloading: bool = True,
    *,
    workers: int | None = None,
) -> np.ndarray:
    """Return V_GWS of every grasp, shape (N,); arguments as in ``volume``."""
    from graspq.volume import volume

    as_bound(bound)
    out = np.zeros(_count(grasps))

    def one(g: int) -> None:
        out[g] = volume(_contacts(grasps[g]), bound, unloading)

    _each(range(len(out)), workers, one)
    return out


def _count(grasps: Any) -> int:
    if not isinstance(grasps, Sequence | np.ndarray) or len(grasps) == 0:
        raise GraspError(
            "grasps: expected a list of grasps, each a list of (6, l) arrays, got"
            f" {'none' if isinstance(grasps, Sequence) else type(grasps).__name__}"
        )
    return len(grasps)


def _contacts(grasp: Any) -> Any:
    """A grasp as the single functions take it: an array (n, 6, l) as a list."""
    return list(grasp) if isinstance(grasp, np.ndarray) and grasp.ndim == 3 else grasp


def _side_by_side(grasps: Sequence[Any] | np.ndarray, bound: str) -> Bodies | None:
    """All grasps as one ``Bodies``, or None when a grasp needs the single functions' care."""
    if isinstance(grasps, np.ndarray) and grasps.dtype.kind in "fiu":
        if grasps.ndim != 4 or grasps.shape[2] != 6 or 0 in grasps.shape:
            return None
        count, contacts, _, width = grasps.shape
        # Read in order of memory first, which brings it near, and then turned.
        if not _finite(grasps):
            return None
        columns = grasps.transpose(2, 0, 1, 3).reshape(6, -1)
        widths, sizes = np.full(count * contacts, width), np.full(count, contacts)
    else:
        try:
            sizes = np.array([len(grasp) for grasp in grasps], dtype=np.int64)
            sets = [w for grasp in grasps for w in grasp]
            columns = np.concatenate(sets, axis=1)
            widths = np.array([w.shape[1] for w in sets], dtype=np.int64)
        except (TypeError, ValueError, AttributeError, IndexError):
            return None
        if columns.ndim != 2 or columns.shape[0] != 6 or columns.dtype.kind not in "fiu":
            return None
        if min(sizes) == 0 or widths.min() == 0 or not _finite(columns):
            return None
    columns = np.ascontiguousarray(columns, dtype=float)
    first_point, first_set = _ends(widths), _ends(sizes)
    if bound == "l1":
        # The hull of all contacts is one set.
        first_point, first_set = first_point[first_set], np.arange(len(first_set))
    first_ellipsoid = np.zeros(len(first_point), dtype=np.int64)
    return Bodies(columns, first_point, NO_CENTRES, NO_AXES, first_ellipsoid, first_set, True)


def _finite(array: np.ndarray) -> bool:
    """Whether every entry is finite, and their sum short of 1e308."""
    with np.errstate(invalid="ignore", over="ignore"):
        return bool(np.isfinite(array.sum(dtype=float)))


def _ends(counts: np.ndarray) -> np.ndarray:
    """Where each of several runs begins, and the end."""
    ends = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(counts, out=ends[1:])
    return ends


def _task_sets(tasks: Any, first: int) -> tuple[np.ndarray, np.ndarray | None]:
    """All task sets side by side and where each ends; looked at singly when something is odd.

    ``first`` is the number of the first, for messages.
    """
    try:
        if isinstance(tasks, np.ndarray):
            count, rows, width = tasks.shape
            every = tasks.transpose(1, 0, 2).reshape(rows, count * width)
            widths = [width] * count
        else:
            every = np.concatenate(tasks, axis=1)
            widths = [t.shape[1] for t in tasks]
    except (TypeError, ValueError, AttributeError, IndexError):
        every, widths = np.zeros((0, 0)), [0]
    if (
        every.ndim != 2
        or every.shape[0] != 6
        or every.dtype != np.float64
        or (
            min(widths) == 0
            or not (np.abs(every).sum(axis=0) > 0.0).all()
            or not np.isfinite(every).all()
        )
    ):
        sets = []
        for g, task in enumerate(tasks):
            try:
                sets.append(as_tasks(task))
            except GraspError as error:
                raise GraspError(f"tasks[{first + g}]: {error}") from error
        every, widths = np.concatenate(sets, axis=1), [t.shape[1] for t in sets]
    return np.ascontiguousarray(every), _ends(np.array(widths))


def _workers(workers: int | None) -> int:
    if workers is None:
        return os.cpu_count() or 1
    if isinstance(workers, bool) or not isinstance(workers, int | np.integer) or workers < 1:
        raise GraspError(f"workers: expected an integer >= 1 or None, got {workers!r}")
    return int(workers)


def _spread(
    count: int, workers: int | None, run: Callable[[int, int], Any], most: int | None = None
) -> None:
    """Run ``run(low, high)`` over chunks of range(count), of ``most`` at most."""
    threads = _workers(workers)
    pieces = -(-count // most) if most else 1
    if threads > 1:
        pieces = max(pieces, min(count, threads * CHUNKS))
    cuts = np.linspace(0, count, pieces + 1).astype(int).tolist()
    if threads == 1 or count < 2:
        for low, high in itertools.pairwise(cuts):
            run(low, high)
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(run, cuts[:-1], cuts[1:]))


def _most(grasps: Sequence[Any] | np.ndarray) -> int:
    """How many grasps like the first to pack at once, so that they stay in the cache."""
    try:
        columns = sum(w.shape[1] for w in grasps[0])
    except (TypeError, AttributeError, IndexError):
        columns = 1
    return max(16, PACKED // max(columns, 1))


def _each(indices: Any, workers: int | None, run: Callable[[int], None]) -> None:
    """Run ``run(g)`` for every grasp, naming the one that fails."""

    def guarded(g: int) -> None:
        try:
            run(int(g))
        except GraspError as error:
            raise GraspError(f"grasps[{g}]: {error}") from error

    def stretch(low: int, high: int) -> None:
        for g in indices[low:high]:
            guarded(g)

    _spread(len(indices), workers, stretch)
