"""The face lattice of one contact's wrench set: its faces of every dimension.

qhull finds the facets; every other face is an intersection of facets, so the lattice follows from
which vertex lies on which facet (Grünbaum: Convex Polytopes, 1967, chapter 3; Kaibel, Pfetsch:
Computing the face lattice of a polytope from its vertex-facet incidences, 2002). Sets of the same
contact model are affine images of each other, so it is found once, in affine coordinates, and
looked up for every other set with the same coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspq.errors import GraspError

# A soft contact with 60 edges; intersections of facets are taken in Python, and take seconds then.
MOST_POINTS, MOST_FACES = 64, 5000
# A vertex this near to a facet lies on it, in affine coordinates: below what edges of cones differ
# by, above qhull's and their round-off. Coordinates are compared in so many digits.
ON_FACET, DIGITS = 1e-8, 10
# Points span another dimension when they leave the span of those before by this share of the set,
# and the frame takes the first that leaves it by a good share of the farthest.
SPANS, GOOD_SHARE = 1e-9, 0.3
# Lattices kept for other sets.
MOST_KNOWN = 64


@dataclass(frozen=True, eq=False)
class Lattice:
    """Faces of a polytope, sorted by dimension.

    Attributes:
        frame: points that span the polytope, an origin first, shape (d + 1,).
        coordinates: affine coordinates of all points in that frame, shape (d, l).
        vertices: which points are vertices, shape (v,).
        first: first face of each dimension 0 to 6, then the total, shape (8,).
        base, basis: per face one vertex and ``dim`` more that span it, (F,) and (F, 5), as
            positions in ``vertices``.
        volume: face volume over that of the parallelotope of its basis, shape (F,).
        covers: per face one vertex out of each face that covers it, (F, most), of which the
            first ``cover_count`` (F,) are used.
    """

    frame: np.ndarray
    coordinates: np.ndarray
    vertices: np.ndarray
    first: np.ndarray
    base: np.ndarray
    basis: np.ndarray
    volume: np.ndarray
    covers: np.ndarray
    cover_count: np.ndarray


_known: dict[tuple[bytes, bytes], Lattice] = {}


def lattice_of(points: np.ndarray) -> Lattice:
    """Return the faces of the hull of ``points`` (6, l).

    The answer depends on the rounded affine coordinates alone, never on what was asked before.
    """
    moved = points - points[:, :1]
    frame = _frame(moved)
    coordinates = np.zeros((len(frame) - 1, points.shape[1]))
    if len(frame) > 1:
        solved = np.linalg.lstsq(moved[:, frame[1:]], moved, rcond=None)[0]
        coordinates = np.round(solved, DIGITS) + 0.0
    key = (np.array(frame).tobytes(), coordinates.tobytes())
    lattice = _known.get(key)
    if lattice is None:
        facets, vertices = _facets(coordinates, len(frame) - 1)
        faces = _all_faces(facets, vertices, len(frame) - 1)
        lattice = _pack(coordinates, frame, vertices, faces, len(frame) - 1)
        if len(_known) >= MOST_KNOWN:
            # A stream of one-off shapes must not pile up.
            _known.clear()
        _known[key] = lattice
    return lattice


def _frame(moved: np.ndarray) -> list[int]:
    """The first points that span the set well, an origin first."""
    rest, chosen = moved.copy(), [0]
    scale = float(np.abs(moved).max())
    while len(chosen) <= 6:
        length = np.linalg.norm(rest, axis=0)
        most = float(length.max())
        if most <= SPANS * scale or scale == 0.0:
            break
        k = int(np.argmax(length > GOOD_SHARE * most))
        chosen.append(k)
        direction = rest[:, k] / length[k]
        for _ in range(2):
            rest = rest - np.outer(direction, direction @ rest)
    return chosen


def _facets(coordinates: np.ndarray, dim: int) -> tuple[list[frozenset[int]], list[int]]:
    """Facets as sets of points, and the vertices."""
    if dim == 0:
        return [], [0]
    if dim == 1:
        ends = [int(np.argmin(coordinates[0])), int(np.argmax(coordinates[0]))]
        return [frozenset([e]) for e in ends], sorted(ends)
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(coordinates.T)
    except QhullError as error:
        raise GraspError(
            "volume: the faces of a contact's wrench set cannot be told apart; take fewer edges"
        ) from error
    vertices = sorted(int(v) for v in hull.vertices)
    height = hull.equations[:, :-1] @ coordinates[:, vertices] + hull.equations[:, -1:]
    on = np.abs(height) <= ON_FACET
    return list({frozenset(int(vertices[i]) for i in np.flatnonzero(row)) for row in on}), vertices


def _all_faces(facets: list[frozenset[int]], vertices: list[int], dim: int) -> set[frozenset[int]]:
    """Every face is an intersection of facets; the polytope itself is one too."""
    faces = {frozenset(vertices), *facets, *(frozenset([v]) for v in vertices)}
    layer = set(facets) if dim > 1 else set()
    while layer:
        layer = {a & b for a in layer for b in facets} - faces - {frozenset()}
        faces |= layer
        if len(faces) > MOST_FACES:
            raise GraspError(
                f"volume: a contact's wrench set has more than {MOST_FACES} faces;"
                " take fewer edges, or augment='none'"
            )
    return faces


def _pack(
    coordinates: np.ndarray,
    chosen: list[int],
    vertices: list[int],
    faces: set[frozenset[int]],
    dim: int,
) -> Lattice:
    place = {v: i for i, v in enumerate(vertices)}
    entries = []
    for face in faces:
        members = sorted(face)
        spanning, volume = _span(coordinates, members)
        entries.append((len(spanning) - 1, members, spanning, volume, face))
    entries.sort(key=lambda e: (e[0], e[1]))
    dims = np.array([e[0] for e in entries])
    first = np.searchsorted(dims, np.arange(8))
    first[7] = len(entries)
    basis = np.zeros((len(entries), 5), dtype=np.int64)
    covers: list[list[int]] = []
    for f, (d, _, spanning, _, face) in enumerate(entries):
        basis[f, : min(d, 5)] = [place[v] for v in spanning[1:6]]
        above = [e[4] for e in entries[first[min(d + 1, 7)] : first[min(d + 2, 7)]]]
        covers.append([place[min(g - face)] for g in above if face < g])
    counts = np.array([len(c) for c in covers])
    padded = np.zeros((len(covers), int(counts.max())), dtype=np.int64)
    for row, cover in zip(padded, covers, strict=True):
        row[: len(cover)] = cover
    return Lattice(
        np.array(chosen),
        coordinates,
        np.array(vertices),
        first.astype(np.int64),
        np.array([place[e[2][0]] for e in entries], dtype=np.int64),
        basis,
        np.array([e[3] for e in entries]),
        padded,
        counts,
    )


def _span(coordinates: np.ndarray, members: list[int]) -> tuple[list[int], float]:
    """Vertices that span a face, and its volume in units of their parallelotope."""
    offsets = coordinates[:, members] - coordinates[:, members[:1]]
    rest, spanning = offsets.copy(), [0]
    while rest.size:
        length = np.linalg.norm(rest, axis=0)
        k = int(np.argmax(length))
        if length[k] <= ON_FACET:
            break
        spanning.append(k)
        direction = rest[:, k] / length[k]
        rest = rest - np.outer(direction, direction @ rest)
    dim = len(spanning) - 1
    volume = 1.0
    if dim >= 2:
        from scipy.spatial import ConvexHull

        inside = np.linalg.lstsq(offsets[:, spanning[1:]], offsets, rcond=None)[0]
        volume = float(ConvexHull(inside.T).volume)
    return [members[k] for k in spanning], volume
