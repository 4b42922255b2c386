"""From the triangles of a file to closed surfaces: welded, joined across pieces, and told apart.

A surface is closed where its triangles run along every edge as often in one direction as in the
other. Exporters write one open piece per material, and writers round corners, so what is open is
first joined with the other open pieces, then welded within a tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from sdh_sim.errors import MeshError
from sdh_sim.objects.touching_surfaces import edges_of, shells
from sdh_sim.user_files.mesh_limits import MAX_PARTS, MeshPiece

# Corners that a file should have at one place differ by its rounding: six digits of text, or single
# precision far from the origin. Relative to the diagonal of the mesh's box; the first that closes
# the surface is taken.
WELD = (1e-6, 1e-5, 1e-4)
_NEIGHBOURS = 8  # corners compared with each one when welding; bounds the memory


@dataclass(frozen=True)
class Surfaces:
    """The surfaces of a mesh.

    Attributes:
        closed: each with vertices (n, 3) of its own and triangles (m, 3), in the order of the file.
        open: the triangles that belong to no closed surface, or None.
        joined: open pieces of the file that became closed surfaces together.
        weld: largest distance between corners made one, in the unit of the vertices; 0: none.
    """

    closed: list[MeshPiece]
    open: MeshPiece | None
    joined: int
    weld: float


@dataclass(frozen=True)
class _Triangles:
    """Triangles without shared corners.

    Attributes:
        corners: (m, 3, 3).
        piece: of the file that each comes from (m,).
        place: of each in the file (m,).
    """

    corners: np.ndarray
    piece: np.ndarray
    place: np.ndarray

    def some(self, chosen: np.ndarray) -> _Triangles:
        """Those that a mask (m,) chooses."""
        return _Triangles(self.corners[chosen], self.piece[chosen], self.place[chosen])


def find_surfaces(pieces: list[MeshPiece]) -> Surfaces:
    """The closed surfaces of a mesh, and what is left.

    Args:
        pieces: vertices (n, 3) and triangles (m, 3) of each, in any unit.

    Raises:
        MeshError: more closed surfaces than are taken.
    """
    corners = np.concatenate([vertices[faces] for vertices, faces in pieces])
    piece = np.repeat(np.arange(len(pieces)), [len(faces) for _, faces in pieces])
    every = _Triangles(corners, piece, np.arange(len(corners)))
    found: list[tuple[int, MeshPiece]] = []
    left = np.ones(len(corners), bool)
    for number in range(len(pieces)):
        mine = np.flatnonzero(piece == number)
        left[mine] = _take_closed(every.some(mine), 0.0, found)
    rest = every.some(left)
    joined, weld = 0, 0.0
    diagonal = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    for tolerance in (0.0, *(share * diagonal for share in WELD)):
        if not len(rest.place):
            break
        apart, taken = _weld_distance(rest.corners, tolerance), len(found)
        if apart is None:
            break  # corners nearer to each other than the file's rounding: nothing left to tell
        still = _take_closed(rest, tolerance, found)
        if len(found) > taken:
            origins = len(np.unique(rest.piece[~still]))
            joined += origins if origins > 1 else 0
            weld = max(weld, apart)
        rest = rest.some(still)
    return Surfaces(
        [surface for _, surface in sorted(found, key=lambda entry: entry[0])],
        _merged(rest.corners).mesh if len(rest.place) else None,
        joined,
        weld,
    )


def _take_closed(
    some: _Triangles, tolerance: float, found: list[tuple[int, MeshPiece]]
) -> np.ndarray:
    """Add the closed surfaces among triangles to a list; a mask (m,) of the triangles left.

    Triangles without an area count as taken: they bound nothing.

    Args:
        some: triangles.
        tolerance: corners nearer than that are one.
        found: surfaces with the place of their first triangle in the file; appended to.
    """
    merged = _merged(some.corners, tolerance)
    (vertices, faces), kept = merged.mesh, merged.kept
    left = np.zeros(len(some.place), bool)
    if not len(faces):
        return left
    label = _components(len(vertices), faces)
    edge, sign = edges_of(faces)
    balance = np.bincount(edge.reshape(-1), sign.reshape(-1))
    is_open = np.zeros(label.max() + 1, bool)
    is_open[np.repeat(label, 3)[balance[edge.reshape(-1)] != 0]] = True
    left[kept[is_open[label]]] = True
    labels = dict.fromkeys(label[~is_open[label]].tolist())
    _check_number(len(labels) + len(found))
    for one in labels:
        rows = np.flatnonzero(label == one)
        for shell in shells(vertices, faces[rows]):
            _check_number(len(found) + 1)
            used, index = np.unique(faces[rows[shell]], return_inverse=True)
            place = int(some.place[kept[rows[shell[0]]]])
            found.append((place, (vertices[used], index.reshape(-1, 3))))
    return left


def _check_number(parts: int) -> None:
    """Raise MeshError where there are more parts than are taken."""
    if parts > MAX_PARTS:
        raise MeshError(
            f"falls into {parts} or more separate parts; at most {MAX_PARTS} are taken: join or "
            "drop some"
        )


@dataclass(frozen=True)
class _Merged:
    """Triangles that share corners.

    Attributes:
        mesh: vertices (n, 3) and triangles (m, 3) with three corners each.
        kept: which of the triangles given these are (m,).
    """

    mesh: MeshPiece
    kept: np.ndarray


def _merged(corners: np.ndarray, tolerance: float = 0.0) -> _Merged:
    """Corners at one place become one; triangles without three corners go.

    Args:
        corners: of triangles (k, 3, 3).
        tolerance: vertices nearer than that become one.
    """
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1)
    if tolerance > 0.0:
        index = _weld(vertices, tolerance)[index]
    triangles = index.reshape(-1, 3)
    a, b, c = triangles.T
    kept = np.flatnonzero((a != b) & (b != c) & (c != a))
    return _Merged((vertices, triangles[kept]), kept)


def _weld(vertices: np.ndarray, tolerance: float) -> np.ndarray:
    """For each vertex (n,), the first of those that it becomes one with."""
    from scipy.spatial import cKDTree  # a fifth of a second, which most processes do not need

    count = len(vertices)
    near = min(_NEIGHBOURS, count)
    distance, other = cKDTree(vertices).query(vertices, near, distance_upper_bound=tolerance)
    distance, other = np.reshape(distance, (count, near)), np.reshape(other, (count, near))
    rows, columns = np.nonzero(np.isfinite(distance))
    links = coo_matrix((np.ones(len(rows)), (rows, other[rows, columns])), shape=(count, count))
    _, label = connected_components(links, directed=False)
    _, first = np.unique(label, return_index=True)
    return first[label]


def _weld_distance(corners: np.ndarray, tolerance: float) -> float | None:
    """How far a weld moves a corner at most; None: chains of corners would collapse."""
    if not tolerance > 0.0:
        return 0.0
    vertices = np.unique(corners.reshape(-1, 3), axis=0)
    moved = float(np.linalg.norm(vertices - vertices[_weld(vertices, tolerance)], axis=1).max())
    return moved if moved <= 2 * tolerance else None


def _components(count: int, faces: np.ndarray) -> np.ndarray:
    """For each triangle (m,), the number of the set that it shares corners with."""
    ends = np.concatenate((faces[:, :2], faces[:, 1:]))
    links = coo_matrix((np.ones(len(ends)), ends.T), shape=(count, count))
    return connected_components(links, directed=False)[1][faces[:, 0]]
