"""What NumPy tells about a wrench space: its span, an inner point, support."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.body import LEAST_EXTENT, Bodies
from graspq.inputs import Packed

# Singular values of the set, in units of its extent, that count as none: relative to the largest,
# and as round-off of coordinates of size one.
RANK, ROUND_OFF = 1e-10, 1e-14
# What rows in units of their extent may be off by, as an extent counts as at least 1e-6 of the
# largest.
ROW_ROUND_OFF = 1e-10


class Span(NamedTuple):
    """The directions of one wrench space.

    Attributes:
        inner: a relative inner point, shape (6,).
        size: extent per row, 1 where it has none, shape (6,).
        normals: orthonormal basis of the directions that it lacks, in units of ``size``,
            shape (6 - rank, 6).
        turn: the map that makes a set of full rank about round, in units of ``size``, (6, 6).
    """

    inner: np.ndarray
    size: np.ndarray
    normals: np.ndarray
    turn: np.ndarray

    @property
    def rank(self) -> int:
        """Dimension of the span."""
        return 6 - len(self.normals)

    @property
    def axes(self) -> np.ndarray:
        """Orthonormal basis of the span, in wrench coordinates, shape (6, rank)."""
        if self.rank == 6:
            return np.eye(6)
        left = np.linalg.svd((self.normals / self.size).T)[0][:, len(self.normals) :]
        # Along the coordinate axes where the span lies along them.
        own = np.flatnonzero(np.linalg.norm(left, axis=1) > 1.0 - 1e-12)
        return np.eye(6)[:, own] if len(own) == self.rank else left


def atoms(body: Bodies) -> np.ndarray:
    """Vectors that span the directions of one body, shape (6, N)."""
    points, starts, centres, axes, first, _, zero = body
    blocks = [axes.transpose(1, 0, 2).reshape(6, -1)]
    for i in range(len(starts) - 1):
        block = np.hstack(
            [points[:, starts[i] : starts[i + 1]], centres[:, first[i] : first[i + 1]]]
        )
        blocks.append(block if zero else block - block.mean(axis=1, keepdims=True))
    return np.hstack(blocks)


def span_of(body: Bodies) -> Span:
    """Return the span of one body, from the singular values of what spans it."""
    points, starts, centres, axes, first, _, zero = body
    size = np.abs(np.hstack([points, centres, *axes])).max(axis=1, initial=0.0)
    size = np.maximum(size, LEAST_EXTENT * size.max())
    size[size == 0] = 1.0
    inner = np.zeros(6)
    for i in range(len(starts) - 1):
        own = np.hstack([points[:, starts[i] : starts[i + 1]], centres[:, first[i] : first[i + 1]]])
        inner += own.sum(axis=1) / (own.shape[1] + zero)
    vectors = atoms(body) / size[:, None]
    # Six directions to the left in either case, and no square matrix of all atoms to the right.
    left, values, _ = np.linalg.svd(vectors, full_matrices=vectors.shape[1] < 6)
    scale = max(float(values[0]), 1e-300) if len(values) else 1.0
    rank = int((values > max(RANK * scale, ROUND_OFF)).sum())
    turn = (left[:, :rank] / values[:rank]).T if rank == 6 else np.eye(6)
    return Span(inner, size, left[:, rank:].T, turn)


def filled(packed: Packed, span: Span) -> Packed:
    """Add a set that spans the directions a flat space lacks: within its span it stays as it is."""
    return _with_cross(packed, (span.normals * span.size).T)


def project(packed: Packed, axes: np.ndarray) -> Packed:
    """Project a space onto a subspace, and fill the directions across so wide that ε is that of it.

    ``axes`` (6, k) is an orthonormal basis of the subspace. In direction u = cos θ a + sin θ c,
    with a in the subspace and c across, the filled space reaches ε cos θ + L sin θ / √(6 - k) or
    further. That is at least ε where the width L is at least ε √6.
    """
    body = packed.body
    onto = axes @ axes.T
    across = np.linalg.svd(axes)[0][:, axes.shape[1] :]
    lengths = [np.linalg.norm(body.points, axis=0), np.linalg.norm(body.centres, axis=0)]
    lengths.append(np.linalg.norm(body.axes, axis=(1, 2)))
    # No body reaches further than all its sets' furthest wrenches together.
    most = (len(body.first_point) - 1) * max(x.max(initial=0.0) for x in lengths)
    body = body._replace(
        points=np.ascontiguousarray(onto @ body.points),
        centres=np.ascontiguousarray(onto @ body.centres),
        axes=np.ascontiguousarray(onto @ body.axes),
    )
    return _with_cross(packed._replace(body=body), 6.0 * max(most, 1e-300) * across)


def _with_cross(packed: Packed, arms: np.ndarray) -> Packed:
    """Add the hull of ± some vectors (6, m) as a set, of a contact of its own that comes last."""
    body, count = packed.body, 2 * arms.shape[1]
    body = body._replace(
        points=np.ascontiguousarray(np.hstack([body.points, arms, -arms])),
        first_point=np.append(body.first_point, body.first_point[-1] + count),
        first_ellipsoid=np.append(body.first_ellipsoid, body.first_ellipsoid[-1]),
        first_set=body.first_set + np.array([0, 1]),
    )
    owners = np.append(packed.owners, np.full(count, packed.contacts))
    return packed._replace(body=body, owners=owners, fillers=1)


def holds_zero(body: Bodies) -> bool:
    """Whether every set has the zero wrench among its points, as one that may unload does."""
    points, starts, centres, axes, first, _, _ = body
    nought = np.flatnonzero(~points.any(axis=0))
    none = np.flatnonzero(~centres.any(axis=0) & ~axes.any(axis=(1, 2)))
    return all(
        ((nought >= starts[i]) & (nought < starts[i + 1])).any()
        or ((none >= first[i]) & (none < first[i + 1])).any()
        for i in range(len(starts) - 1)
    )


def support_values(body: Bodies, directions: np.ndarray) -> np.ndarray:
    """Support value of one body in every direction (6, m), shape (m,)."""
    points, starts, centres, axes, first, _, zero = body
    along = directions.T @ points
    turned = np.einsum("krc,rm->mkc", axes, directions)
    round_ = directions.T @ centres + np.linalg.norm(turned, axis=2)
    total = np.zeros(directions.shape[1])
    for i in range(len(starts) - 1):
        best = np.hstack([along[:, starts[i] : starts[i + 1]], round_[:, first[i] : first[i + 1]]])
        total += best.max(axis=1, initial=0.0 if zero else -np.inf)
    return total


def shares(packed: Packed) -> np.ndarray:
    """The contacts' shares of the inner point of a body without the origin, shape (n, 6)."""
    points, starts, centres, _, first, _, _ = packed.body
    forces = np.zeros((packed.contacts + packed.fillers, 6))
    for i in range(len(starts) - 1):
        own, round_ = slice(starts[i], starts[i + 1]), slice(first[i], first[i + 1])
        count = starts[i + 1] - starts[i] + first[i + 1] - first[i]
        np.add.at(forces, packed.owners[own], points[:, own].T / count)
        np.add.at(forces, packed.ellipsoid_owners[round_], centres[:, round_].T / count)
    return forces[: packed.contacts]


def tip(axes: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Where an ellipsoid with these axes (6, 3) and centre 0 reaches furthest, shape (6,)."""
    side = axes.T @ direction
    length = float(np.linalg.norm(side))
    return axes @ side / length if length > 0 else np.zeros(6)


def some(bodies: Bodies, which: np.ndarray) -> Bodies:
    """Some of many polytopes."""
    sets = _runs(bodies.first_set[which], bodies.first_set[which + 1])
    columns = _runs(bodies.first_point[sets], bodies.first_point[sets + 1])
    counts = np.diff(bodies.first_point)[sets]
    first_set = np.concatenate([[0], np.cumsum(np.diff(bodies.first_set)[which])])
    return bodies._replace(
        points=np.ascontiguousarray(bodies.points[:, columns]),
        first_point=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        first_ellipsoid=np.zeros(len(sets) + 1, dtype=np.int64),
        first_set=first_set.astype(np.int64),
    )


def _runs(begins: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """All numbers of several ranges, one range after the other."""
    counts = ends - begins
    return np.arange(counts.sum()) + np.repeat(begins - np.cumsum(counts) + counts, counts)
