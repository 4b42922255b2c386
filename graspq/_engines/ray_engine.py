"""q* by ray shooting: flat spaces, sets that miss the origin, and the result's words."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from graspq._compiled.ray_batch import reach_one
from graspq._compiled.ray_shooting import CAPPED, SOLVED, ZERO, reach
from graspq._compiled.scale_interval import EMPTY, between
from graspq._compiled.span_and_whitening import spread
from graspq.inputs import Packed
from graspq.scaling_result import FLAT, INFEASIBLE, UNREACHABLE, TaskScaling, infeasible, nothing

FLOAT = np.dtype(np.float64)
NO_PADS = np.zeros((0, 6))
RANK = 1e-10
IN_SPAN = 1e-9
LOOSEST = 1e-5
# What rows in units of their extent may be off by: an extent counts as at least 1e-6 of the
# largest.
ROUND_OFF = 1e-10


def scale_at_once(wrenches: Any, tasks: Any, bound: str, tol: float) -> TaskScaling | None:
    """Return q* of plain arrays in one compiled call; None leaves it to the careful way."""
    if type(tasks) is not np.ndarray or tasks.ndim != 2 or tasks.dtype != FLOAT:
        return None
    if not isinstance(wrenches, list | tuple) or not wrenches:
        return None
    counts = []
    for w in wrenches:
        if type(w) is not np.ndarray or w.dtype != FLOAT:
            return None
        shape = w.shape
        if len(shape) != 2 or shape[0] != 6 or not shape[1]:
            return None
        counts.append(shape[1])
    columns = np.concatenate(wrenches, axis=1)
    if not columns.flags.c_contiguous:
        columns = np.ascontiguousarray(columns)
    # The compiled code sees one kind of array: writable, aligned and contiguous.
    wanted = tasks if tasks.flags.carray else np.array(tasks, order="C")
    forces = np.zeros((len(wrenches), 6))
    stop = 0.1 * tol if tol > 1e-9 else 1e-12
    status, value, lower, upper, j = reach_one(
        columns, _widths(tuple(counts)), bound == "l1", True, wanted, stop, forces
    )
    if status == SOLVED:
        return TaskScaling(value, lower, upper, j, forces)
    if status == ZERO:
        return nothing(len(wrenches), j, UNREACHABLE.format(j=j), upper)
    return None


@functools.lru_cache(maxsize=256)
def _widths(counts: tuple[int, ...]) -> np.ndarray:
    """The counts as an array, which nobody writes to; kept, as most grasps have the same."""
    return np.array(counts, dtype=np.int64)


def scale_by_ray(packed: Packed, tasks: np.ndarray, tol: float) -> TaskScaling:
    """Return q* of a checked grasp and task set."""
    stop = 0.1 * tol if packed.smooth or tol > 1e-9 else 1e-12
    inner, size = np.empty(6), np.empty(6)
    if not packed.body[5] and holds_zero(packed):
        packed = packed._replace(body=(*packed.body[:5], True, packed.body[6]))
    body = packed.body
    pads, given = NO_PADS, tasks
    if spread(body, inner, size, np.empty((6, 6))) == 0.0:
        pads = missing_directions(packed, size)
        if pads.shape[0]:
            settled = _into_span(packed, tasks, inner, size, pads, stop)
            if settled is None:
                return _otherwise(packed, given, tol)
            if isinstance(settled, TaskScaling):
                return settled
            tasks = settled
    forces = np.zeros((packed.contacts, 6))
    if body[5]:
        status, value, lower, upper, j, _ = reach(
            tasks, body, pads, stop, packed.owners, packed.ball_owners, forces
        )
    else:
        status, value, lower, upper, j = between(
            tasks, inner, size, body, pads, stop, packed.owners, packed.ball_owners, forces
        )
        far = np.abs(forces.sum(axis=0) - value * tasks[:, j]) / np.where(size > 0, size, 1.0)
        small = ROUND_OFF / np.abs(tasks[:, j] / np.where(size > 0, size, 1.0)).max()
        if status == SOLVED and (
            upper - lower > (1e-9 + 10 * stop) * value + small or far.max() > 10 * stop + ROUND_OFF
        ):
            status = CAPPED
    if status == SOLVED:
        return TaskScaling(value, lower, upper, int(j), forces)
    if status == ZERO:
        return nothing(packed.contacts, int(j), UNREACHABLE.format(j=j), upper)
    if status == EMPTY:
        return infeasible(packed.contacts, int(j), INFEASIBLE.format(j=j))
    return _otherwise(packed, given, tol)


def _otherwise(packed: Packed, tasks: np.ndarray, tol: float) -> TaskScaling:
    """The ways out for the rare grasp too close to degenerate for the compiled pivots."""
    if not packed.smooth:
        return _by_lp(packed, tasks)
    if tol < LOOSEST:
        # Close to degenerate, round-off keeps the gap open; the bounds then say how far.
        return scale_by_ray(packed, tasks, min(10.0 * tol, LOOSEST))
    from graspq._engines.column_engine import scale_by_columns

    return scale_by_columns(packed, tasks)


def _by_lp(packed: Packed, tasks: np.ndarray) -> TaskScaling:
    """q* of a packed polytope by linear programs."""
    from graspq._engines.highs_engine import scale_all_by_lp

    points, starts = packed.body[:2]
    bound = "linf" if len(starts) == packed.contacts + 1 else "l1"
    grasp = [points[:, packed.owners == i] for i in range(packed.contacts)]
    return scale_all_by_lp(grasp, tasks, bound, packed.body[5])


def holds_zero(packed: Packed) -> bool:
    """Whether every body has the zero wrench among its atoms, as one that may unload does."""
    points, starts, centres, axes, balls, _, _ = packed.body
    nought = np.flatnonzero(~points.any(axis=0))
    none = np.flatnonzero(~centres.any(axis=0) & ~axes.any(axis=(1, 2)))
    return all(
        ((nought >= starts[i]) & (nought < starts[i + 1])).any()
        or ((none >= balls[i]) & (none < balls[i + 1])).any()
        for i in range(len(starts) - 1)
    )


def atoms(packed: Packed) -> np.ndarray:
    """Vectors that span the directions of the set, shape (6, N)."""
    points, starts, centres, axes, balls, zero, _ = packed.body
    blocks = [axes.transpose(1, 0, 2).reshape(6, -1)]
    for i in range(len(starts) - 1):
        block = np.hstack(
            [points[:, starts[i] : starts[i + 1]], centres[:, balls[i] : balls[i + 1]]]
        )
        blocks.append(block if zero else block - block.mean(axis=1, keepdims=True))
    return np.hstack(blocks)


def rounded(packed: Packed) -> tuple[np.ndarray, np.ndarray] | None:
    """A map (6, 6) that makes the set about round and its inner point; None when it is flat."""
    inner, size = np.empty(6), np.empty(6)
    spread(packed.body, inner, size, np.empty((6, 6)))
    if missing_directions(packed, size).shape[0]:
        return None
    left, values, _ = np.linalg.svd(atoms(packed) / size[:, None], full_matrices=False)
    return np.ascontiguousarray((left / values).T / size), inner


def missing_directions(packed: Packed, size: np.ndarray) -> np.ndarray:
    """Orthogonal complement of the set's span, in units of ``size``, shape (k, 6)."""
    size = np.where(size > 0, size, 1.0)
    vectors = atoms(packed) / size[:, None]
    left, values, _ = np.linalg.svd(vectors, full_matrices=True)
    scale = max(float(values[0]), 1e-300) if len(values) else 1.0
    # Differences of coordinates of size one carry round-off of that size.
    rank = int((values > max(RANK * scale, 1e-14)).sum())
    return left[:, rank:].T * size


def _into_span(
    packed: Packed,
    tasks: np.ndarray,
    inner: np.ndarray,
    size: np.ndarray,
    pads: np.ndarray,
    stop: float,
) -> np.ndarray | TaskScaling | None:
    """Drop the tasks' round-off outside a flat space, or say that they are outside."""
    unit = np.where(size > 0, size, 1.0)
    normals = pads / unit
    scaled = tasks / unit[:, None]
    outside = normals @ scaled
    length = np.linalg.norm(scaled, axis=0)
    off = np.linalg.norm(outside, axis=0) > IN_SPAN * length
    zero, count = packed.body[5], packed.contacts
    if not zero:
        lift = normals @ (inner / unit)
        # An inner point within round-off of the origin must not look lifted off it.
        lifted = np.linalg.norm(lift) > IN_SPAN * max(np.linalg.norm(inner / unit), 0.1)
        if not lifted:
            lift = np.zeros_like(lift)
        if lifted or off.any():
            return _single_scale(packed, tasks, inner, pads, unit, outside, lift, stop)
    elif off.any():
        j = int(np.argmax(off))
        return nothing(count, j, FLAT.format(j=j, rank=6 - len(pads)))
    return unit[:, None] * (scaled - normals.T @ outside)


def _single_scale(
    packed: Packed,
    tasks: np.ndarray,
    inner: np.ndarray,
    pads: np.ndarray,
    unit: np.ndarray,
    outside: np.ndarray,
    lift: np.ndarray,
    stop: float,
) -> TaskScaling | None:
    """A flat set off the origin meets each task's ray in at most one point: test those.

    None when round-off keeps a test from ending.
    """
    count, body = packed.contacts, packed.body
    low, high, critical = 0.0, np.inf, 0
    normals = pads / unit
    centre = _shares(packed)
    best = centre
    scale = np.abs(atoms(packed)).max(initial=0.0) + np.abs(inner).max()
    for j, (task, out) in enumerate(zip(tasks.T, outside.T, strict=True)):
        square = float(out @ out)
        q = float(out @ lift) / square if square > 0 else np.inf
        if not np.isfinite(q) or np.linalg.norm(q * out - lift) > (
            IN_SPAN * np.linalg.norm(lift) + 2 * ROUND_OFF * np.linalg.norm(inner / unit)
        ):
            return infeasible(count, j, INFEASIBLE.format(j=j))
        if abs(q) * np.abs(task / unit).max() < 10 * stop:
            q = 0.0  # the set holds the origin, up to round-off
        ray = (q * task - inner) / unit
        ray = unit * (ray - normals.T @ (normals @ ray))
        forces = centre
        if np.abs(ray).max() > 1e-12 * scale:
            forces = np.zeros((count, 6))
            status, reached, *_ = reach(
                np.ascontiguousarray(ray[:, None]),
                (*body[:6], inner),
                pads,
                stop,
                packed.owners,
                packed.ball_owners,
                forces,
            )
            slip = 1e-9 + 10 * stop + ROUND_OFF * scale / np.abs(ray).max()
            if status == CAPPED:
                return None
            if status != SOLVED or reached < 1 - slip:
                return infeasible(count, j, INFEASIBLE.format(j=j))
            forces = centre + (forces - centre) / reached
        low = max(low, q)
        if q < high:
            high, critical, best = q, j, forces
    if high < 0 or low > high * (1 + 1e-9 + 10 * stop):
        return infeasible(count, critical, INFEASIBLE.format(j=critical))
    return TaskScaling(high, high, high, critical, best)


def _shares(packed: Packed) -> np.ndarray:
    """The contacts' shares of the inner point, shape (n, 6)."""
    points, starts, centres, _, balls, _, _ = packed.body
    forces = np.zeros((packed.contacts, 6))
    for i in range(len(starts) - 1):
        own, round_ = slice(starts[i], starts[i + 1]), slice(balls[i], balls[i + 1])
        count = starts[i + 1] - starts[i] + balls[i + 1] - balls[i]
        np.add.at(forces, packed.owners[own], points[:, own].T / count)
        np.add.at(forces, packed.ball_owners[round_], centres[:, round_].T / count)
    return forces
