"""ε: bring wrench spaces into a round shape, ask whether they hold the origin, grow the hulls."""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from graspq._compiled.ball_batch import RESULTS as BALL_RESULTS
from graspq._compiled.ball_batch import balls_in_bodies, new_hull
from graspq._compiled.body import Bodies
from graspq._compiled.incremental_hull import FULL, GROWN, Hull
from graspq._compiled.inscribed_ball import ARTIFICIAL_LEFT, COARSE
from graspq._compiled.ray_batch import RAY_RESULTS, RESULTS, STATUS, VALUE, shoot_bodies
from graspq._compiled.ray_shooting import CAPPED, SOLVED
from graspq._engines.bodies import scatter_of, some, span_of
from graspq._engines.shooting import scratch
from graspq.inputs import NO_OWNERS

# An inner point this close to the origin, in units of the extent, is the origin.
AT_ORIGIN = 1e-12
# How far beyond the origin the set must reach, seen from its inner point.
BEYOND = 1e-9
# First and least jog of vertices, as powers of ten. Points of a smooth set share no plane by
# chance, and their spacing must stay above the jog. After so many attempts with other random
# numbers, a smaller one.
JOG_POLYTOPE, JOG_SMOOTH, LEAST_JOG = -7, -10, -12
ATTEMPTS, SAME_JOG = 12, 3
IS_FLAT = 7
# Most facets whose room a thread keeps, of about 150 bytes each.
KEPT_FACETS = 16_384


class Balls(NamedTuple):
    """Largest balls around the origin: one status and two bounds per body, each (N,)."""

    status: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


class _Round(NamedTuple):
    """Bodies in coordinates in which each is about round.

    Attributes:
        bodies: the bodies, with extent 1 in every row.
        turns: the map that took each of them there, shape (N, 6, 6).
        inner: an inner point of each, there, shape (N, 6).
        flat: whether each is too close to flat to tell, shape (N,).
    """

    bodies: Bodies
    turns: np.ndarray
    inner: np.ndarray
    flat: np.ndarray


def _round(bodies: Bodies) -> _Round:
    """Make polytopes, or one body of any kind, about round."""
    smooth = bodies.centres.shape[1] > 0
    inner, turns, flat = _one(bodies) if smooth else scatter_of(bodies)
    if not smooth and len(flat) == 1 and flat[0]:
        # Singular values tell what is close to flat better than the scatter, their squares.
        inner, turns, flat = _one(bodies)
    points = np.empty_like(bodies.points)
    first = bodies.first_point[bodies.first_set]
    for turn, begin, end in zip(turns, first[:-1], first[1:], strict=True):
        np.matmul(turn, bodies.points[:, begin:end], out=points[:, begin:end])
    size = np.zeros((6, len(turns)))
    if points.shape[1]:
        size = np.maximum.reduceat(np.abs(points), first[:-1], axis=1)
    centres, axes = bodies.centres, bodies.axes
    if centres.shape[1]:
        centres, axes = turns[0] @ centres, turns[0] @ axes
        size[:, 0] = np.maximum(size[:, 0], np.abs(centres).max(axis=1))
        size[:, 0] = np.maximum(size[:, 0], np.abs(axes).max(axis=(0, 2)))
    size[size == 0.0] = 1.0
    if centres.shape[1]:
        centres, axes = centres / size, axes / size
    counts = np.diff(first)
    points /= np.repeat(size, counts, axis=1)
    turns = turns / size.T[:, :, None]
    inner = np.einsum("nrc,nc->nr", turns, inner)
    body = bodies._replace(points=points, centres=np.ascontiguousarray(centres), axes=axes)
    return _Round(body, np.ascontiguousarray(turns), inner, flat)


def _one(body: Bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inner point, map and flatness of one body of any kind, as ``scatter_of`` gives them."""
    span = span_of(body)
    return span.inner[None], (span.turn / span.size)[None], np.array([span.rank < 6])


def _inside(found: _Round) -> tuple[np.ndarray, np.ndarray]:
    """Whether each body holds the origin strictly inside, and whether that is certain, (N,).

    A set holds the origin inside when, seen from its inner point, it reaches past it.
    """
    bodies, inner = found.bodies, found.inner
    count = len(inner)
    results = np.zeros((count, RESULTS))
    zero = bodies.holds_origin
    tasks = np.where(np.abs(inner).max(axis=1) <= AT_ORIGIN, 0.0, -inner.T)
    away = tasks.any(axis=0)
    # A body whose inner point is the origin gets no task, and an infinite reach.
    shoot_bodies(
        *bodies,
        np.zeros((count, 6)) if zero else inner,
        np.ascontiguousarray(tasks),
        np.arange(count),
        np.arange(count) + away,
        1e-6 if bodies.centres.shape[1] else 1e-12,
        NO_OWNERS,
        NO_OWNERS,
        results,
        np.zeros((0, 6)),
        np.zeros((0, RAY_RESULTS)),
        scratch(),
    )
    status, value = results[:, STATUS], results[:, VALUE]
    return (status == SOLVED) & (zero | (value > 1.0 + BEYOND)), status != CAPPED


def inside_of(bodies: Bodies) -> tuple[np.ndarray, np.ndarray]:
    """Whether each body is known to hold the origin strictly inside, or known not to, (N,)."""
    found = _round(bodies)
    inside, certain = _inside(found)
    certain &= ~found.flat
    return inside & certain, ~inside & certain


def balls_of(bodies: Bodies, stop: float, facets: int, vertices: int) -> Balls:
    """Largest balls around the origin in polytopes, or in one body of any kind.

    Status ``IS_FLAT`` leaves a body that may be flat to others; ``FULL`` asks for more room.
    """
    found = _round(bodies)
    inside, certain = _inside(found)
    smooth = bodies.centres.shape[1] > 0
    count = len(found.inner)
    status, lower, upper = np.full(count, GROWN), np.zeros(count), np.zeros(count)
    status[found.flat] = IS_FLAT
    left = np.flatnonzero((inside | ~certain) & ~found.flat)
    if not len(left):
        return Balls(status, lower, upper)
    hull = _room(facets, vertices)
    power = np.full(count, JOG_SMOOTH if smooth else JOG_POLYTOPE)
    for attempt in range(ATTEMPTS):
        results = np.empty((len(left), BALL_RESULTS))
        levels = power[left]
        for level in set(levels.tolist()):
            at = np.flatnonzero(levels == level)
            results[at] = _grow(found, left[at], stop, 10.0**level, attempt, hull)
        status[left], lower[left], upper[left] = results.T
        code = results[:, 0]
        if (code == GROWN).all():
            break
        finer = (code == COARSE) | (code == ARTIFICIAL_LEFT) | (attempt % SAME_JOG == SAME_JOG - 1)
        power[left[finer]] -= 1
        left = left[(code != GROWN) & (code != FULL) & (power[left] >= LEAST_JOG)]
        if not len(left):
            break
    outside = status == ARTIFICIAL_LEFT
    status[outside], lower[outside], upper[outside] = GROWN, 0.0, 0.0
    return Balls(status, lower, upper)


_scratch = threading.local()


def _room(facets: int, vertices: int) -> Hull:
    """Room for a hull, the thread's own where it has as much; used again and again."""
    hull = getattr(_scratch, "hull", None)
    if hull is None or len(hull.facets) != facets or len(hull.vertices) != vertices:
        hull = new_hull(facets, vertices)
        if facets <= KEPT_FACETS:
            _scratch.hull = hull
    return hull


def _grow(
    found: _Round, which: np.ndarray, stop: float, jog: float, seed: int, hull: Hull
) -> np.ndarray:
    """Grow the hulls of some of the bodies; return the entry's results, (k, 3)."""
    bodies = found.bodies
    if len(which) < len(found.inner):
        bodies = some(bodies, which)
    results = np.zeros((len(which), BALL_RESULTS))
    balls_in_bodies(
        *bodies,
        np.ascontiguousarray(found.turns[which]),
        stop,
        jog,
        seed,
        results,
        scratch(),
        *hull,
    )
    return results
