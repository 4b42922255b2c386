"""Task scaling of one hand: its linear program in units of one, and the answer read back.

    max q   subject to   Σ G f_e x_e - q t = 0,   Σ Jᵀ f_e x_e + K z - s = 0,
                         x >= 0,   z free,   lower <= s <= upper,

with one slack s per motor (bounded by its torque) and per passive motion (0), f_e the edges of the
friction cones and K the preloads (z as the difference of two variables >= 0). docs/hand_bound.md
has the statics. Solved by ``_compiled.shared_motor_reach``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq.errors import GraspError
from graspq.hand_bound import HandBound, cones_of, intervals_of, points_of
from graspq.scaling_result import HandScaling

NO_EQUILIBRIUM = (
    "no equilibrium exists for task {j}: the friction cones cannot balance what"
    " the motors at their limit ({motors}) push with"
)
UNLOADED = (
    "no equilibrium exists: motor {k} pushes with {torque:.4g} N m at its limit, but no"
    " contact loads it"
)
UNREACHABLE = "task {j} cannot be exerted: the friction cones and motors allow only a scale of 0"
UNLIMITED = "the motors do not limit the tasks: the structure carries them"

# Columns kept for the edges that exact cones ask for; hands with patches take some hundreds.
SPARE_COLUMNS = 1500
# Exact cones have edges enough when the next one would gain less than this share of a unit.
EDGE_GAIN = 1e-11
# Edges that exact cones start from.
FIRST_EDGES = 8
# Rows of the wrench below this share of the largest are scaled no further, nor are loads of a
# motor below that share taken for more than round-off.
SMALL_WRENCH, SMALL_LOAD = 1e-6, 1e-12
# Scales below this, in units of one, are 0.
SMALL_SCALE = 1e-9


class Program(NamedTuple):
    """The linear program in units of one; columns: slacks, q, preload share, cones' edges.

    Attributes:
        table: all columns, (m, N): m slacks, the column of q, one that the kernel uses, the edges
            and preloads, spare columns.
        used: how many columns are filled.
        lower, upper: bounds of every column, (N,).
        exact: exact cones per unit normal force, (K, m, 4); K = 0 with a number of edges.
        tasks: unit task wrenches, (6, j).
        lengths: their lengths over the longest, (j,), which is ``longest``.
        unit: torque of one unit of a slack.
    """

    table: np.ndarray
    used: int
    lower: np.ndarray
    upper: np.ndarray
    exact: np.ndarray
    tasks: np.ndarray
    lengths: np.ndarray
    longest: float
    unit: float


def solve(
    hand: HandBound, tasks: np.ndarray, edges: int | None, origin: np.ndarray, scale: float
) -> HandScaling:
    """Solve a checked problem; see ``hand_task_scaling``."""
    from graspq._compiled import bounded_simplex as simplex
    from graspq._compiled.shared_motor_reach import reach

    cones, owners = cones_of(hand, origin, scale)
    directions = edge_directions(cones, FIRST_EDGES if edges is None else edges)
    columns = np.einsum("krc,ce->rke", cones[:, :, 1:], directions)
    columns += cones[:, :, 0].T[:, :, None]
    columns = np.hstack([columns.reshape(cones.shape[1], -1), _preload_columns(hand)])
    size = np.abs(columns).max(axis=1)
    size[:6] = np.maximum(size[:6], SMALL_WRENCH * size[:6].max())
    loaded = size[6:] > SMALL_LOAD * max(float(size[6:].max(initial=0.0)), 1e-9)
    low, high = intervals_of(hand)
    for k in np.flatnonzero(~loaded):
        if not low[k] <= 0.0 <= high[k]:
            torque = float(hand.motor_torque[k]) if hand.motor_torque is not None else 0.0
            return _none(hand, UNLOADED.format(k=k, torque=torque), 0)
    program = _program(hand, columns, cones, tasks, size, loaded, edges is None)
    m = len(program.table)
    weights, basic = np.zeros(m), np.zeros(m, np.int64)
    made = np.zeros(program.table.shape[1], np.int64)
    status, value, upper, j, least, _ = reach(
        program.table,
        program.used,
        program.tasks,
        program.lengths,
        program.lower,
        program.upper,
        program.exact,
        EDGE_GAIN,
        hand.held,
        weights,
        basic,
        np.zeros(m - 6),
        made,
    )
    if status == simplex.INFEASIBLE:
        names = ", ".join(str(k) for k in np.flatnonzero(hand.at_limit)) or "none"
        return _none(hand, NO_EQUILIBRIUM.format(j=j, motors=names), int(j))
    if status != simplex.OPTIMAL:
        raise GraspError(
            "hand_task_scaling: did not converge (the contacts are close to"
            " degenerate); try another number of edges"
        )
    if value == np.inf:
        forces = np.full((len(hand.contacts), 6), np.nan)
        load = np.full(len(hand.torque_limit), np.nan)
        return HandScaling(np.inf, np.inf, np.inf, int(j), forces, UNLIMITED, load)
    forces, wrenches, load = _forces(hand, program, cones, owners, directions, weights, basic, made)
    # Wrenches were scaled by ``torque_scale`` with the cones, as the tasks are.
    factor = program.unit / program.longest
    counts = [len(points_of(c)) for c in hand.contacts]
    split = tuple(np.split(forces, np.cumsum(counts)[:-1]))
    value = max(value, 0.0)
    top, reason = max(upper, value), ""
    if value < SMALL_SCALE:
        value, top, reason = 0.0, max(upper, 0.0), UNREACHABLE.format(j=j)
    q, top = value * factor, top * factor
    return HandScaling(q, q, top, int(j), wrenches, reason, load, split, least * factor)


def edge_directions(cones: np.ndarray, edges: int) -> np.ndarray:
    """Where edges of a cone lie in its ellipsoid: (3, edges), and its apices when it is soft."""
    angle = 2.0 * np.pi * np.arange(edges) / edges
    circle = np.zeros((3, edges))
    circle[0], circle[1] = np.cos(angle), np.sin(angle)
    if cones[:, :, 3].any():
        circle = np.column_stack([circle, [0, 0, 1.0], [0, 0, -1.0]])
    return circle


def _preload_columns(hand: HandBound) -> np.ndarray:
    """Columns of z >= 0 and -z >= 0 for the motor torques that load no joint: (6 + k + u, 2 r)."""
    motors, count = hand.preloads.shape
    block = np.zeros((6 + motors + hand.passive_jacobians[0].shape[2], 2 * count))
    block[6 : 6 + motors] = np.hstack([hand.preloads, -hand.preloads])
    return block


def _program(
    hand: HandBound,
    columns: np.ndarray,
    cones: np.ndarray,
    tasks: np.ndarray,
    size: np.ndarray,
    loaded: np.ndarray,
    exact: bool,
) -> Program:
    """Divide rows by their ``size``, torques by a typical limit; leave unloaded motors out."""
    rows = np.concatenate([np.ones(6, dtype=bool), loaded])
    m, width = int(rows.sum()), columns.shape[1]
    size = size[rows]
    bounds = np.stack([x[loaded] for x in intervals_of(hand)]) / size[6:]
    motors = int(loaded[: len(hand.torque_limit)].sum())
    unit = float(np.median(np.abs(bounds[:, :motors]).max(axis=0))) if motors else 1.0
    unit = unit if unit > 0 else 1.0
    wrench = tasks / size[:6, None]
    length = np.linalg.norm(wrench, axis=0)
    table = np.zeros((m, m + 2 + width + (SPARE_COLUMNS if exact else 0)))
    table[np.arange(m), np.arange(m)] = np.where(np.arange(m) < 6, 1.0, -1.0)
    table[:, m + 2 : m + 2 + width] = columns[rows] / size[:, None]
    lower, upper = np.zeros(table.shape[1]), np.full(table.shape[1], np.inf)
    upper[:6] = 0.0
    lower[6:m], upper[6:m] = bounds / unit
    upper[m + 1] = 0.0
    bare = np.ascontiguousarray(cones[:, rows] / size[None, :, None]) if exact else None
    return Program(
        table,
        m + 2 + width,
        lower,
        upper,
        np.zeros((0, m, 4)) if bare is None else bare,
        wrench / length,
        length / length.max(),
        float(length.max()),
        unit,
    )


def _forces(
    hand: HandBound,
    program: Program,
    cones: np.ndarray,
    owners: np.ndarray,
    directions: np.ndarray,
    weights: np.ndarray,
    basic: np.ndarray,
    made: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces at every point (K, 3), wrenches of the contacts (n, 6) and motor torques (k,)."""
    first = len(program.table) + 2
    edges, motors = len(cones) * directions.shape[1], len(hand.torque_limit)
    preloads = hand.preloads.shape[1]
    forces, wrenches = np.zeros((len(cones), 3)), np.zeros((len(hand.contacts), 6))
    load = np.zeros(motors)
    for weight, column in zip(weights, basic, strict=True):
        index = int(column) - first
        if index < 0:
            continue
        if edges <= index < edges + 2 * preloads:
            sign = 1.0 if index < edges + preloads else -1.0
            load += sign * hand.preloads[:, (index - edges) % preloads] * (weight * program.unit)
            continue
        if index < edges:
            cone, k = divmod(index, directions.shape[1])
            direction = directions[:, k]
        else:
            cone = int(made[column])
            bare = program.exact[cone]
            direction = np.linalg.lstsq(
                bare[:, 1:], program.table[:, column] - bare[:, 0], rcond=None
            )[0]
        full = cones[cone] @ np.concatenate([[1.0], direction]) * (weight * program.unit)
        forces[cone] += full[:3]
        wrenches[owners[cone]] += full[:6]
        load += full[6 : 6 + motors]
    return forces, wrenches, load


def _none(hand: HandBound, reason: str, critical: int) -> HandScaling:
    empty = np.full((len(hand.contacts), 6), np.nan)
    load = np.full(len(hand.torque_limit), np.nan)
    return HandScaling(-np.inf, -np.inf, -np.inf, critical, empty, reason, load)
