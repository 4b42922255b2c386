"""Wrench spaces in coordinates in which each is about round."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.body import Bodies
from graspq._compiled.whitening import whiten_bodies
from graspq._engines.bodies import span_of


class Whitened(NamedTuple):
    """Bodies in coordinates in which each is about round.

    Attributes:
        bodies: the bodies, with extent 1 in every row.
        turns: the map that took each of them there, shape (N, 6, 6).
        inner: an inner point of each, there, shape (N, 6).
        flat: whether each is flat, or too close to flat to tell, shape (N,).
    """

    bodies: Bodies
    turns: np.ndarray
    inner: np.ndarray
    flat: np.ndarray


def whiten(bodies: Bodies) -> Whitened:
    """Make polytopes, or one body of any kind, about round."""
    if bodies.centres.shape[1]:
        return _by_singular_values(bodies)
    found = whiten_polytopes(bodies)
    if len(found.flat) == 1 and found.flat[0]:
        # Singular values tell what is close to flat better than the scatter, their squares.
        return _by_singular_values(bodies)
    return found


def whiten_polytopes(bodies: Bodies) -> Whitened:
    """Make many polytopes about round, from the scatter of their points."""
    count = len(bodies.first_set) - 1
    points, turns = np.empty_like(bodies.points), np.empty((count, 6, 6))
    inner, flat = np.empty((count, 6)), np.empty(count, dtype=bool)
    whiten_bodies(
        bodies.points,
        bodies.first_point,
        bodies.first_set,
        bodies.holds_origin,
        points,
        turns,
        inner,
        flat,
    )
    return Whitened(bodies._replace(points=points), turns, inner, flat)


def _by_singular_values(body: Bodies) -> Whitened:
    """Make one body of any kind about round."""
    span = span_of(body)
    turn = span.turn / span.size
    points, centres, axes = turn @ body.points, turn @ body.centres, turn @ body.axes
    size = np.abs(np.hstack([points, centres, *axes])).max(axis=1)
    size[size == 0.0] = 1.0
    turn = turn / size[:, None]
    body = body._replace(
        points=np.ascontiguousarray(points / size[:, None]),
        centres=np.ascontiguousarray(centres / size[:, None]),
        axes=np.ascontiguousarray(axes / size[:, None]),
    )
    return Whitened(body, turn[None], (turn @ span.inner)[None], np.array([span.rank < 6]))
