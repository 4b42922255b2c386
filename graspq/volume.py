"""The volume of the grasp wrench space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graspq._engines.face_lattice import MOST_POINTS, Lattice, lattice_of
from graspq.errors import GraspError
from graspq.inputs import as_bound, as_polytopes

if TYPE_CHECKING:
    from graspq._compiled.polytopes import Polytopes

# Choices of faces that are looked at, at one to four microseconds each; ten soft contacts.
MOST_CHOICES = 1e7
# Every set is turned by about this much, so that no two of their faces are parallel.
GENERAL_POSITION = 1e-8
# Singular values below this share of the largest are 0: the space is flat.
FLAT = 1e-9
# What the area vectors of all facets add up to, over the area: 0 but for round-off (1e-12) when
# every facet was found. Patches whose taxels are nearly coplanar can leave more.
MOST_OPEN = 1e-6


def volume(wrenches: Any, bound: str = "linf", unloading: bool = True) -> float:
    """Return the six-dimensional volume V_GWS of the grasp wrench space; 0.0 when it is flat.

    "linf" adds up the facets of the Minkowski sum, each a sum of the contacts' faces, in
    general position (every set is turned by about 1e-8, the relative error to expect): exact
    for any number of contacts, in about 15 ms for three soft contacts with 12 edges, 80 ms for
    four, 0.4 s for five and 1.2 s for six. "l1" takes the convex hull of all wrenches.

    Args:
        wrenches: one (6, l_i) array per contact.
        bound: "linf" or "l1".
        unloading: whether contacts may press with less than their limit.

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
    from graspq._compiled.minkowski_volume import PATTERNS, add_facets
    from graspq._compiled.polytopes import AREA, CLOSURE, VOLUME, workspace_for

    for i, w in enumerate(grasp):
        if w.shape[1] > MOST_POINTS:
            raise GraspError(
                f"wrenches[{i}]: {w.shape[1]} vertices are more than the"
                f" {MOST_POINTS} whose faces can be added up; take fewer edges, or"
                " augment='none'"
            )
    lattices = [lattice_of(w) for w in grasp]
    choices = _choices(lattices)
    if choices > MOST_CHOICES:
        raise GraspError(
            f"volume: about {choices:.1g} combinations of faces are more than"
            f" {MOST_CHOICES:.0g}; take fewer edges or contacts"
        )
    polytopes = _polytopes(grasp, lattices)
    work = workspace_for(polytopes)
    for pattern in PATTERNS:
        add_facets(polytopes, work, pattern)
    area_vector = work.sums[CLOSURE : CLOSURE + 6]
    gap = float(np.abs(area_vector).max() / work.sums[AREA])
    if gap > MOST_OPEN:
        raise GraspError(
            f"volume: the facets leave a share of {gap:.0e} of the surface open, since faces of a"
            " contact's set cannot be told apart; take another number of edges, or augment='none'"
        )
    return float(work.sums[VOLUME] / 6.0)


def _polytopes(grasp: list[np.ndarray], lattices: list[Lattice]) -> Polytopes:
    """The sets in general position, with their faces, packed for the"""
    from graspq._compiled.polytopes import BASE, BASIS, COVER, COVERS, Polytopes

    rng = np.random.default_rng(20170)
    turns = [np.eye(6) + GENERAL_POSITION * rng.uniform(-1.0, 1.0, (6, 6)) for _ in grasp]
    bodies = [
        (turn @ w[:, lattice.vertices]).T
        for turn, w, lattice in zip(turns, grasp, lattices, strict=True)
    ]
    counts, sizes = np.array([len(b) for b in bodies]), np.array([len(x.base) for x in lattices])
    first_vertex, first_face = np.cumsum(counts) - counts, np.cumsum(sizes) - sizes
    covers = max(x.covers.shape[1] for x in lattices)
    faces = np.zeros((sizes.sum(), COVER + covers), dtype=np.int64)
    for x, f, v in zip(lattices, first_face, first_vertex, strict=True):
        own = faces[f : f + len(x.base)]
        own[:, BASE], own[:, BASIS:COVERS], own[:, COVERS] = x.base + v, x.basis + v, x.cover_count
        own[:, COVER : COVER + x.covers.shape[1]] = x.covers + v
    first = [x.first + f for x, f in zip(lattices, first_face, strict=True)]
    return Polytopes(
        vertices=np.ascontiguousarray(np.concatenate(bodies)),
        bodies=np.column_stack([first, first_vertex, first_vertex + counts, 0 * counts]),
        faces=faces,
        volumes=np.concatenate([x.volume for x in lattices]),
    )


def _choices(lattices: list[Lattice]) -> float:
    """About how many combinations of faces are looked at."""
    counts = np.array([np.diff(x.first) for x in lattices], dtype=float)
    faces = counts.sum(axis=0)

    def pairs(a: int, b: int, last: int) -> float:
        """Faces of dimensions a and b from two bodies, b's among the first ``last``."""
        return float((counts[:last, b] * (faces[a] - counts[:last, a])).sum())

    edges = counts[: max(len(counts) - 2, 0), 1]
    p1, p2, p3 = edges.sum(), (edges**2).sum(), (edges**3).sum()
    triples = (p1**3 - 3 * p1 * p2 + 2 * p3) / 6
    singles = faces[3] + faces[4] + faces[5]
    return float(
        triples
        + singles
        + pairs(2, 1, len(edges))
        + pairs(2, 2, len(counts)) / 2
        + pairs(3, 2, len(counts))
    )
