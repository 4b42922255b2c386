"""q* of sets that may miss the origin: the interval of scales q at which q t lies in the set.

Seen from an inner point p, the gauge of q t - p is convex in q and is 1 on the boundary. Newton's
method on it from outside (W. Dinkelbach, "On nonlinear fractional programming", Management
Science 13, 1967) stops after finitely many facets, each found by one shot; all tasks take their
steps together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.ray_shooting import CAPPED, SOLVED
from graspq._engines.bodies import ROW_ROUND_OFF, Span, shares, support_values
from graspq._engines.shooting import reach, reaches
from graspq.inputs import Packed
from graspq.scaling_result import INFEASIBLE, TaskScaling, infeasible

EMPTY = 3
MOST_STEPS = 200
# A line whose gauge stays this close to 1 may touch the set: round-off decides.
CLOSE = 1e-6


class _Ends(NamedTuple):
    """Where lines leave a set, every field of shape (m,).

    Attributes:
        status: ``SOLVED``, ``EMPTY`` when the line misses the set, or ``CAPPED`` when it passes so
            close that round-off decides.
        scale: the largest q, of any sign, with q t in the set.
        upper: a bound on it that a plane proves.
        gauge: that of q t, 1 up to the tolerance; 0 at the inner point.
    """

    status: np.ndarray
    scale: np.ndarray
    upper: np.ndarray
    gauge: np.ndarray


def _ends(packed: Packed, tasks: np.ndarray, span: Span, stop: float) -> _Ends:
    """Follow the line of every task (6, m) to where it leaves the set."""
    inner, count = span.inner, tasks.shape[1]
    status = np.full(count, CAPPED)
    scale, upper = np.full(count, np.inf), np.full(count, np.inf)
    gauge, closest = np.zeros(count), np.zeros(count)
    rays, active = tasks.copy(), np.arange(count)
    for _ in range(MOST_STEPS):
        found, value, u = reaches(packed.body, rays[:, active], stop, inner)
        active, value, u = active[found == SOLVED], value[found == SOLVED], u[:, found == SOLVED]
        if not len(active):
            break
        along = np.einsum("rm,rm->m", u, tasks[:, active])
        ahead = along > 0.0
        bound = np.full(len(active), np.inf)
        bound[ahead] = support_values(packed.body, u[:, ahead]) / along[ahead]
        upper[active] = np.minimum(upper[active], bound)
        started = np.isfinite(scale[active])
        there = started & (value >= 1.0 - 1e-12 - 4.0 * stop)
        closest[active] = np.where(started, np.maximum(closest[active], value), closest[active])
        away = ~there & ~ahead
        status[active[away & (closest[active] < 1.0 - CLOSE)]] = EMPTY
        below = np.full(len(active), np.inf)
        below[ahead] = (1.0 + u[:, ahead].T @ inner) / along[ahead]
        old = scale[active]
        with np.errstate(invalid="ignore"):
            there |= ~away & started & (below >= old - 1e-15 * np.abs(old))
        status[active[there]], gauge[active[there]] = SOLVED, 1.0 / value[there]
        going = ~there & ~away
        active = active[going]
        scale[active] = below[going]
        rays[:, active] = scale[active] * tasks[:, active] - inner[:, None]
        at = _same(rays[:, active], span)
        status[active[at]] = SOLVED
        active = active[~at]
        if not len(active):
            break
    return _Ends(status, scale, upper, gauge)


def _same(rays: np.ndarray, span: Span) -> np.ndarray:
    """Whether rays from the inner point end where they begin, up to round-off."""
    far = np.abs(rays / span.size[:, None]).max(axis=0, initial=0.0)
    near = np.abs(span.inner / span.size).max()
    return (far <= 1e-12 * near) | (far == 0.0)


def scale_in_interval(
    packed: Packed, tasks: np.ndarray, span: Span, stop: float
) -> TaskScaling | None:
    """Return the largest q >= 0 with every q t in the set; None when round-off decides.

    ``upper`` is proven by the plane that stops some task's ray, ``lower`` by the gauge between the
    two ends of every ray, which is convex.
    """
    count, inner = tasks.shape[1], span.inner
    top = _ends(packed, np.hstack([tasks, -tasks]), span, stop)
    odd = np.flatnonzero(top.status.reshape(2, count).T.ravel() != SOLVED)
    if len(odd):
        j = int(odd[0]) // 2
        status = top.status[j if odd[0] % 2 == 0 else count + j]
        return infeasible(packed.contacts, j, INFEASIBLE.format(j=j)) if status == EMPTY else None
    far = np.abs(tasks / span.size[:, None]).max(axis=0)
    # A boundary through the origin, up to round-off, is at 0.
    scale = np.where(np.abs(top.scale) * np.tile(far, 2) < 10.0 * stop, 0.0, top.scale)
    high, low = scale[:count], -scale[count:]
    critical, last = int(np.argmin(high)), int(np.argmax(low))
    value, least = float(high[critical]), max(0.0, float(low[last]))
    if value < 0.0 or least > value * (1.0 + 1e-9 + 10.0 * stop):
        if least <= value * (1.0 + CLOSE):
            return None
        j = critical if value < 0.0 else last
        return infeasible(packed.contacts, j, INFEASIBLE.format(j=j))
    lower = min(value, float((high - _slip(packed, tasks, top, high, low, span, stop)).min()))
    upper = max(value, float(top.upper[:count].min()))
    forces = centre = shares(packed)
    ray = value * tasks[:, critical] - inner
    if not _same(ray[:, None], span)[0]:
        results, edge = reach(packed, np.ascontiguousarray(ray[:, None]), stop, inner)
        forces = centre + (edge - centre) / results[1]
    rest = np.abs(forces.sum(axis=0) - value * tasks[:, critical]) / span.size
    small = ROW_ROUND_OFF / far[critical]
    if upper - lower > (1e-9 + 10 * stop) * value + small or rest.max() > 10 * stop + ROW_ROUND_OFF:
        return None
    return TaskScaling(value, lower, upper, critical, forces)


def _slip(
    packed: Packed,
    tasks: np.ndarray,
    top: _Ends,
    high: np.ndarray,
    low: np.ndarray,
    span: Span,
    stop: float,
) -> np.ndarray:
    """How far inside its upper end each interval certainly holds, shape (m,)."""
    gauge = top.gauge[: len(high)]
    slip = np.zeros(len(high))
    over = np.flatnonzero(gauge > 1.0)
    if len(over):
        middle = 0.5 * (high + low)[over]
        rays = middle * tasks[:, over] - span.inner[:, None]
        inside = np.zeros(len(over))
        apart = ~_same(rays, span)
        if apart.any():
            status, value, _ = reaches(packed.body, rays[:, apart], stop, span.inner)
            inside[apart] = np.where(status == SOLVED, 1.0 / np.maximum(value, 1e-300), 1.0)
        share = np.ones(len(over))
        clear = inside < 1.0
        share[clear] = np.minimum(1.0, (gauge[over] - 1.0)[clear] / (gauge[over] - inside)[clear])
        slip[over] = (high[over] - middle) * share
    return slip
