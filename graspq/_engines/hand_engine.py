"""Bring a hand's scaling problem into units of one and read the answer back."""

from __future__ import annotations

import numpy as np

from graspq.errors import GraspError
from graspq.hand_bound import NO_EQUILIBRIUM, UNLOADED, UNREACHABLE, HandBound, cones_of, points_of
from graspq.scaling_result import HandScaling

SPARE = 1500
TOL = 1e-11


def generators(cones: np.ndarray, edges: int) -> np.ndarray:
    """Edges of every cone, shape (6 + k, K·edges [+ 2 K]), as (cone, direction) pairs."""
    angle = 2.0 * np.pi * np.arange(edges) / edges
    circle = np.zeros((3, edges))
    circle[0], circle[1] = np.cos(angle), np.sin(angle)
    if cones[:, :, 3].any():
        circle = np.column_stack([circle, [0, 0, 1.0], [0, 0, -1.0]])
    return circle


def solve(
    hand: HandBound, tasks: np.ndarray, edges: int | None, origin: np.ndarray, scale: float
) -> HandScaling:
    """Solve a checked problem; see ``hand_task_scaling``."""
    from graspq._compiled import bounded_simplex as _simplex
    from graspq._compiled import shared_motor_reach as _hand

    cones, owners = cones_of(hand, origin, scale)
    motors, count = len(hand.torque_limit), len(hand.contacts)
    circle = generators(cones, 8 if edges is None else edges)
    columns = np.einsum("krc,ce->rke", cones[:, :, 1:], circle)
    columns += cones[:, :, 0].T[:, :, None]
    columns = columns.reshape(6 + motors, -1)
    size = np.abs(columns).max(axis=1)
    size[:6] = np.maximum(size[:6], 1e-6 * size[:6].max())
    loaded = size[6:] > 1e-12 * max(float(size[6:].max(initial=0.0)), 1e-9)
    for k in np.flatnonzero(~loaded):
        if not hand.lower[k] <= 0.0 <= hand.upper[k]:
            torque = float(hand.motor_torque[k]) if hand.motor_torque is not None else 0.0
            return _none(hand, UNLOADED.format(k=k, torque=torque), 0)
    rows = np.concatenate([np.ones(6, dtype=bool), loaded])
    m = int(rows.sum())
    size = size[rows]
    bounds = np.stack([hand.lower[loaded], hand.upper[loaded]]) / size[6:]
    unit = float(np.median(np.abs(bounds).max(axis=0))) if m > 6 else 1.0
    unit = unit if unit > 0 else 1.0
    wrench = tasks / size[:6, None]
    length = np.linalg.norm(wrench, axis=0)
    width = columns.shape[1]
    table = np.zeros((m, m + 2 + width + (SPARE if edges is None else 0)))
    table[np.arange(m), np.arange(m)] = np.where(np.arange(m) < 6, 1.0, -1.0)
    table[:, m + 2 : m + 2 + width] = columns[rows] / size[:, None]
    lo, hi = np.zeros(table.shape[1]), np.full(table.shape[1], np.inf)
    hi[:6] = 0.0
    lo[6:m], hi[6:m] = bounds / unit
    hi[m + 1] = 0.0
    exact = cones[:, rows] / size[None, :, None] if edges is None else np.zeros((0, m, 4))
    made = np.zeros(table.shape[1], np.int64)
    exact = np.ascontiguousarray(exact)
    weights, used, slacks = np.zeros(m), np.zeros(m, np.int64), np.zeros(m - 6)
    status, value, upper, j, least, _ = _hand.reach(
        table,
        m + 2 + width,
        wrench / length,
        length / length.max(),
        lo,
        hi,
        exact,
        TOL,
        hand.held,
        weights,
        used,
        slacks,
        made,
    )
    if status == _simplex.INFEASIBLE:
        names = ", ".join(str(k) for k in np.flatnonzero(hand.at_limit)) or "none"
        return _none(hand, NO_EQUILIBRIUM.format(j=j, motors=names), int(j))
    if status != _simplex.OPTIMAL:
        raise GraspError(
            "hand_task_scaling: did not converge (the contacts are close to"
            " degenerate); try another number of edges"
        )
    if value == np.inf:
        return HandScaling(
            np.inf,
            np.inf,
            np.inf,
            int(j),
            np.full((count, 6), np.nan),
            "the motors do not limit the tasks: the structure carries them",
            np.full(motors, np.nan),
        )
    forces = np.zeros((len(cones), 3))
    wrenches = np.zeros((count, 6))
    load = np.zeros(motors)
    for weight, column in zip(weights, used, strict=True):
        if column < m + 2:
            continue
        index = int(column) - m - 2
        if index < width:
            cone, direction = divmod(index, circle.shape[1])
            direction = circle[:, direction]
        else:
            cone = int(made[column])
            direction = np.linalg.lstsq(
                exact[cone, :, 1:], table[:, column] - exact[cone, :, 0], rcond=None
            )[0]
        full = cones[cone] @ np.concatenate([[1.0], direction]) * (weight * unit)
        forces[cone] += full[:3]
        wrenches[owners[cone]] += full[:6]
        load += full[6:]
    # Wrenches were scaled by ``torque_scale`` with the cones, as the tasks are.
    factor = unit / length.max()
    points = [len(points_of(c)) for c in hand.contacts]
    split = tuple(np.split(forces, np.cumsum(points)[:-1]))
    value = max(value, 0.0)
    if value < 1e-9:
        return HandScaling(
            0.0,
            0.0,
            max(upper, 0.0) * factor,
            int(j),
            wrenches,
            UNREACHABLE.format(j=j),
            load,
            split,
            least * factor,
        )
    top = max(upper, value)
    return HandScaling(
        value * factor,
        value * factor,
        top * factor,
        int(j),
        wrenches,
        "",
        load,
        split,
        least * factor,
    )


def _none(hand: HandBound, reason: str, critical: int) -> HandScaling:
    empty = np.full((len(hand.contacts), 6), np.nan)
    load = np.full(len(hand.torque_limit), np.nan)
    return HandScaling(-np.inf, -np.inf, -np.inf, critical, empty, reason, load)
