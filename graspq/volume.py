"""The volume of the grasp wrench space."""

from __future__ import annotations

from typing import Any

import numpy as np

from graspq._engines.face_lattice import MOST_POINTS, Lattice, lattice_of
from graspq.errors import GraspError
from graspq.inputs import as_bound, as_polytopes

# Dimensions of the faces that are chosen: they add up to four and an edge is walked, or to
# five without an edge among them.
PATTERNS = (
    (4, 0, 0, 0),
    (3, 1, 0, 0),
    (2, 2, 0, 0),
    (2, 1, 1, 0),
    (1, 1, 1, 1),
    (3, 2, 0, 0),
    (5, 0, 0, 0),
)
MOST_WORK = 5e7
GENERAL = 1e-8
FLAT = 1e-9


def volume(wrenches: Any, bound: str = "linf", unloading: bool = True) -> float:
    """Return the six-dimensional volume V_GWS of the grasp wrench space; 0.0 when it is flat.

    "linf" adds up the facets of the Minkowski sum, each a sum of the contacts' faces, in
    general position (every set is turned by about 1e-8, the relative error to expect).
    "l1" takes the convex hull of all wrenches.

    Raises:
        GraspError: for bad input, ellipsoids, or sets with too many faces to add up.
    """
    grasp = as_polytopes(wrenches, "volume")
    bound = as_bound(bound)
    for i, w in enumerate(grasp):
        if not np.isfinite(w).all():
            raise GraspError(f"wrenches[{i}]: every entry must be finite")
    if unloading:
        grasp = [np.hstack([w, np.zeros((6, 1))]) for w in grasp]
    if bound == "l1":
        grasp = [np.hstack(grasp)]
    whitened = _whiten(grasp)
    if whitened is None:
        return 0.0
    grasp, unit = whitened
    if len(grasp) == 1:
        return unit * _hull_volume(grasp[0])
    return unit * _sum_volume(grasp)


def _whiten(grasp: list[np.ndarray]) -> tuple[list[np.ndarray], float] | None:
    """The sets in coordinates in which they are about round, and the unit of volume."""
    offsets = np.hstack([w - w.mean(axis=1, keepdims=True) for w in grasp])
    size = np.abs(offsets).max(axis=1)
    if size.min() <= FLAT * max(size.max(), 1e-300) * 1e-3:
        return None
    left, values, _ = np.linalg.svd(offsets / size[:, None], full_matrices=False)
    if len(values) < 6 or values[5] <= FLAT * values[0]:
        return None
    turn = (left / values).T / size
    return [turn @ w for w in grasp], float(np.prod(values) * np.prod(size))


def _hull_volume(points: np.ndarray) -> float:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(points.T).volume)
    except QhullError as error:
        raise GraspError("volume: the wrench space is too close to flat for its hull") from error


def _sum_volume(grasp: list[np.ndarray]) -> float:
    from graspq._compiled.minkowski_volume import sum_volume

    for i, w in enumerate(grasp):
        if w.shape[1] > MOST_POINTS:
            raise GraspError(
                f"wrenches[{i}]: {w.shape[1]} vertices are more than the"
                f" {MOST_POINTS} whose faces can be added up; take fewer edges, or"
                " augment='none'"
            )
    lattices = [lattice_of(w) for w in grasp]
    work = _work(lattices)
    if work > MOST_WORK:
        raise GraspError(
            f"volume: about {work:.1g} combinations of faces are more than"
            f" {MOST_WORK:.0g}; take fewer edges or contacts"
        )
    rng = np.random.default_rng(20170)
    bodies = []
    for w, lattice in zip(grasp, lattices, strict=True):
        turn = np.eye(6) + GENERAL * rng.uniform(-1.0, 1.0, (6, 6))
        bodies.append((turn @ w[:, lattice.vertices]).T)
    vertex_first = np.concatenate([[0], np.cumsum([len(b) for b in bodies])])
    faces = np.concatenate([[0], np.cumsum([len(x.base) for x in lattices])])
    covers = np.concatenate([[0], np.cumsum([len(x.cover) for x in lattices])])
    starts = vertex_first[:-1]
    polytopes = (
        np.ascontiguousarray(np.concatenate(bodies)),
        vertex_first.astype(np.int64),
        np.array([x.first + f for x, f in zip(lattices, faces[:-1], strict=True)]),
        0,
        np.concatenate([x.base + s for x, s in zip(lattices, starts, strict=True)]),
        np.concatenate([x.basis + s for x, s in zip(lattices, starts, strict=True)]),
        np.concatenate([x.volume for x in lattices]),
        np.concatenate(
            [
                np.array([0]),
                *[x.cover_first[1:] + c for x, c in zip(lattices, covers[:-1], strict=True)],
            ]
        ),
        np.concatenate([x.cover + s for x, s in zip(lattices, starts, strict=True)]),
    )
    return float(sum_volume(polytopes, np.array(PATTERNS)))


def _work(lattices: list[Lattice]) -> float:
    """About how many combinations of faces there are to look at."""
    from itertools import combinations, permutations

    counts = [np.diff(x.first) for x in lattices]
    bodies = range(len(lattices))
    total = 0.0
    for pattern in PATTERNS:
        dims = [d for d in pattern if d]
        if len(dims) > len(lattices):
            continue
        # Equal dimensions take rising bodies, so each set of bodies counts once.
        groups = (
            combinations(bodies, len(dims))
            if len(set(dims)) == 1
            else (
                c
                for c in permutations(bodies, len(dims))
                if all(dims[i] != dims[i + 1] or c[i] < c[i + 1] for i in range(len(dims) - 1))
            )
        )
        total += sum(
            float(np.prod([counts[b][d] for b, d in zip(c, dims, strict=True)], dtype=float))
            for c in groups
        )
    return total
