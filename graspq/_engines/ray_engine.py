"""q* by ray shooting: plain grasps at once, flat spaces and doubtful ones with care."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from graspq._compiled.ray_batch import RESULTS, STATUS, TASK, UPPER, VALUE, shoot_bodies
from graspq._compiled.ray_shooting import CAPPED, SOLVED, ZERO
from graspq._engines.bodies import ROW_ROUND_OFF, Span, atoms, filled, holds_zero, shares, span_of
from graspq._engines.shooting import FIRST_TASK, NO_RAYS, NO_SHIFT, reach, scratch
from graspq.inputs import NO_AXES, NO_CENTRES, NO_OWNERS, Packed
from graspq.scaling_result import FLAT, INFEASIBLE, UNREACHABLE, TaskScaling, infeasible, nothing

FLOAT = np.dtype(np.float64)
IN_SPAN = 1e-9
LOOSEST = 1e-5


def scale_at_once(wrenches: Any, tasks: Any, bound: str, tol: float) -> TaskScaling | None:
    """Return q* of plain arrays in one compiled call; None leaves it to the careful way."""
    if type(tasks) is not np.ndarray or tasks.ndim != 2 or tasks.dtype != FLOAT:
        return None
    if tasks.shape[0] != 6 or not tasks.shape[1]:
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
    first_point, first_ellipsoid, first_set, owners, last_task = _layout(
        tuple(counts), bound, wanted.shape[1]
    )
    results, forces = np.zeros((1, RESULTS)), np.zeros((len(counts), 6))
    shoot_bodies(
        columns,
        first_point,
        NO_CENTRES,
        NO_AXES,
        first_ellipsoid,
        first_set,
        True,
        NO_SHIFT,
        wanted,
        FIRST_TASK,
        last_task,
        0.1 * tol if tol > 1e-9 else 1e-12,
        owners,
        NO_OWNERS,
        results,
        forces,
        NO_RAYS,
        scratch(),
    )
    status, value, lower, upper, j, sound = results[0].tolist()
    if status == SOLVED and sound:
        return TaskScaling(value, lower, upper, int(j), forces)
    return None


@functools.lru_cache(maxsize=256)
def _layout(counts: tuple[int, ...], bound: str, tasks: int) -> tuple[np.ndarray, ...]:
    """How columns are laid out; kept, as most grasps have the same. Nobody writes to it."""
    sets = [sum(counts)] if bound == "l1" else counts
    first_point = np.zeros(len(sets) + 1, dtype=np.int64)
    np.cumsum(sets, out=first_point[1:])
    return (
        first_point,
        np.zeros(len(sets) + 1, dtype=np.int64),
        np.array([0, len(sets)]),
        np.repeat(np.arange(len(counts)), counts),
        np.array([tasks]),
    )


def scale_by_ray(packed: Packed, tasks: np.ndarray, tol: float) -> TaskScaling:
    """Return q* of a checked grasp and task set."""
    stop = 0.1 * tol if packed.smooth or tol > 1e-9 else 1e-12
    given = packed, tasks
    if not packed.body.holds_origin and holds_zero(packed.body):
        packed = packed._replace(body=packed.body._replace(holds_origin=True))
    span = span_of(packed.body)
    if span.rank < 6:
        settled = _into_span(packed, tasks, span, stop)
        if settled is None:
            return _otherwise(*given, tol)
        if isinstance(settled, TaskScaling):
            return settled
        packed, tasks = filled(packed, span), settled
    if packed.body.holds_origin:
        results, forces = reach(packed, tasks, stop)
        status, value, upper, j = (results[k] for k in (STATUS, VALUE, UPPER, TASK))
        if status == SOLVED:
            return TaskScaling(float(value), float(value), float(upper), int(j), forces)
        if status == ZERO:
            j = int(j)
            return nothing(packed.contacts, j, UNREACHABLE.format(j=j), float(upper))
    else:
        from graspq._engines.interval_engine import scale_in_interval

        found = scale_in_interval(packed, tasks, span, stop)
        if found is not None:
            return found
    return _otherwise(*given, tol)


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

    body = packed.body
    bound = "linf" if len(body.first_point) == packed.contacts + 1 else "l1"
    grasp = [body.points[:, packed.owners == i] for i in range(packed.contacts)]
    return scale_all_by_lp(grasp, tasks, bound, body.holds_origin)


def _into_span(
    packed: Packed, tasks: np.ndarray, span: Span, stop: float
) -> np.ndarray | TaskScaling | None:
    """Drop the tasks' round-off outside a flat space, or say that they are outside."""
    normals, unit, inner = span.normals, span.size, span.inner
    scaled = tasks / unit[:, None]
    outside = normals @ scaled
    length = np.linalg.norm(scaled, axis=0)
    off = np.linalg.norm(outside, axis=0) > IN_SPAN * length
    if not packed.body.holds_origin:
        lift = normals @ (inner / unit)
        # An inner point within round-off of the origin must not look lifted off it.
        lifted = np.linalg.norm(lift) > IN_SPAN * max(np.linalg.norm(inner / unit), 0.1)
        if not lifted:
            lift = np.zeros_like(lift)
        if lifted or off.any():
            return _single_scale(packed, tasks, span, outside, lift, stop)
    elif off.any():
        j = int(np.argmax(off))
        return nothing(packed.contacts, j, FLAT.format(j=j, rank=span.rank))
    return unit[:, None] * (scaled - normals.T @ outside)


def _single_scale(
    packed: Packed,
    tasks: np.ndarray,
    span: Span,
    outside: np.ndarray,
    lift: np.ndarray,
    stop: float,
) -> TaskScaling | None:
    """A flat set off the origin meets each task's ray in at most one point: test those.

    None when round-off keeps a test from ending.
    """
    count, unit, normals, inner = packed.contacts, span.size, span.normals, span.inner
    low, high, critical = 0.0, np.inf, 0
    whole = filled(packed, span)
    centre = shares(packed)
    best = centre
    scale = np.abs(atoms(packed.body)).max(initial=0.0) + np.abs(inner).max()
    for j, (task, out) in enumerate(zip(tasks.T, outside.T, strict=True)):
        square = float(out @ out)
        q = float(out @ lift) / square if square > 0 else np.inf
        if not np.isfinite(q) or np.linalg.norm(q * out - lift) > (
            IN_SPAN * np.linalg.norm(lift) + 2 * ROW_ROUND_OFF * np.linalg.norm(inner / unit)
        ):
            return infeasible(count, j, INFEASIBLE.format(j=j))
        if abs(q) * np.abs(task / unit).max() < 10 * stop:
            q = 0.0  # the set holds the origin, up to round-off
        ray = (q * task - inner) / unit
        ray = unit * (ray - normals.T @ (normals @ ray))
        forces = centre
        if np.abs(ray).max() > 1e-12 * scale:
            results, forces = reach(whole, np.ascontiguousarray(ray[:, None]), stop, inner)
            status, reached = results[STATUS], results[VALUE]
            slip = 1e-9 + 10 * stop + ROW_ROUND_OFF * scale / np.abs(ray).max()
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
