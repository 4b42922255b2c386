"""ε: make wrench spaces about round, ask whether they hold the origin, grow the hulls."""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from graspq._compiled.ball_batch import RESULTS as BALL_RESULTS
from graspq._compiled.ball_batch import STATUS as BALL_STATUS
from graspq._compiled.ball_batch import balls_in_bodies, new_hull
from graspq._compiled.body import Bodies
from graspq._compiled.incremental_hull import FULL, GROWN, Hull
from graspq._compiled.inscribed_ball import ARTIFICIAL_LEFT, COARSE
from graspq._compiled.ray_batch import RESULTS, STATUS, VALUE, shoot_bodies
from graspq._compiled.ray_shooting import CAPPED, SOLVED
from graspq._engines.bodies import some
from graspq._engines.shooting import NO_FORCES, NO_RAYS, scratch
from graspq._engines.whitening import Whitened, whiten
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


def _inside(found: Whitened) -> tuple[np.ndarray, np.ndarray]:
    """Whether each body holds the origin strictly inside, and whether that is certain, (N,).

    A set holds the origin inside when, seen from its inner point, it reaches past it.
    """
    bodies, inner = found.bodies, found.inner
    count = len(inner)
    results = np.zeros((count, RESULTS))
    zero = bodies.holds_origin
    # A body whose inner point is the origin gets no task, and an infinite reach.
    first_task = np.arange(count)
    away = np.abs(inner).max(axis=1) > AT_ORIGIN
    shoot_bodies(
        *bodies,
        np.zeros((count, 6)) if zero else inner,
        np.ascontiguousarray(-inner.T),
        first_task,
        first_task + away,
        1e-6 if bodies.centres.shape[1] else 1e-12,
        NO_OWNERS,
        NO_OWNERS,
        results,
        NO_FORCES,
        NO_RAYS,
        scratch(),
    )
    status, value = results[:, STATUS], results[:, VALUE]
    inside = status == SOLVED
    if not zero:
        inside &= value > 1.0 + BEYOND
    return inside, status != CAPPED


def inside_of(bodies: Bodies) -> tuple[np.ndarray, np.ndarray]:
    """Whether each body is known to hold the origin strictly inside, or known not to, (N,)."""
    found = whiten(bodies)
    inside, certain = _inside(found)
    certain &= ~found.flat
    return inside & certain, ~inside & certain


def balls_of(bodies: Bodies, stop: float, facets: int, vertices: int) -> Balls:
    """Largest balls around the origin in polytopes, or in one body of any kind.

    Status ``IS_FLAT`` leaves a body that may be flat to others; ``FULL`` asks for more room.
    """
    found = whiten(bodies)
    inside, certain = _inside(found)
    smooth = bodies.centres.shape[1] > 0
    count = len(found.inner)
    # Status, lower and upper bound; the ball of a body without the origin is 0.
    balls = np.zeros((count, BALL_RESULTS))
    balls[:, BALL_STATUS] = np.where(found.flat, IS_FLAT, GROWN)
    left = np.flatnonzero((inside | ~certain) & ~found.flat)
    hull = _room(facets, vertices)
    power = np.full(count, JOG_SMOOTH if smooth else JOG_POLYTOPE)
    for attempt in range(ATTEMPTS):
        if not len(left):
            break
        levels = power[left]
        for level in set(levels.tolist()):
            at = left[levels == level]
            balls[at] = _grow(found, at, stop, 10.0**level, attempt, hull)
        code = balls[left, BALL_STATUS]
        finer = (code == COARSE) | (code == ARTIFICIAL_LEFT) | (attempt % SAME_JOG == SAME_JOG - 1)
        power[left[finer]] -= 1
        left = left[(code != GROWN) & (code != FULL) & (power[left] >= LEAST_JOG)]
    status = balls[:, BALL_STATUS]
    balls[status == ARTIFICIAL_LEFT] = GROWN, 0.0, 0.0
    return Balls(*balls.T)


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
    found: Whitened, which: np.ndarray, stop: float, jog: float, seed: int, hull: Hull
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
