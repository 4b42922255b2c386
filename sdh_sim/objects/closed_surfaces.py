"""From the triangles of a file to closed surfaces: welded, joined across pieces, and told apart.

A surface is closed where its triangles run along every edge as often in one direction as in the
other. Exporters write one open piece per material, and writers round corners, so what is open is
first joined with the other open pieces, then welded within a tolerance. Parts that touch share
corners or edges with each other; they are told apart by the order of the file and, where that does
not help, by the side of an edge on which the solid lies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sdh_sim.errors import MeshError
from sdh_sim.objects.mesh_limits import MAX_PARTS, MeshPiece

# Corners that a file should have at one place differ by its rounding: six digits of text, or single
# precision far from the origin. Relative to the diagonal of the mesh's box; the first that closes
# the surface is taken.
WELD = (1e-6, 1e-5, 1e-4)
_NEIGHBOURS = 8  # corners compared with each one when welding; bounds the memory
_AROUND_AN_EDGE = 32  # triangles at one edge that are told apart
_SAME_ANGLE = 1e-4  # triangles that lie on each other [rad]


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
    edge, sign = _edges(faces)
    balance = np.bincount(edge.reshape(-1), sign.reshape(-1))
    is_open = np.zeros(label.max() + 1, bool)
    is_open[np.repeat(label, 3)[balance[edge.reshape(-1)] != 0]] = True
    left[kept[is_open[label]]] = True
    labels = dict.fromkeys(label[~is_open[label]].tolist())
    _check_number(len(labels) + len(found))
    for one in labels:
        rows = np.flatnonzero(label == one)
        for shell in _shells(vertices, faces[rows]):
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


def _edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each side of a triangle, the number of its edge and its direction along it (m, 3)."""
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].astype(np.int64)
    low, high = ends.min(axis=2), ends.max(axis=2)
    _, edge = np.unique(low * (int(faces.max()) + 1) + high, return_inverse=True)
    return edge.reshape(-1, 3), np.where(ends[..., 0] < ends[..., 1], 1, -1)


def _shells(vertices: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    """Rows of the triangles of each closed surface, in the order of the file.

    Args:
        vertices: (n, 3).
        faces: triangles (m, 3) that are closed together.
    """
    edge, sign = _edges(faces)
    found = []
    for rows in _in_file_order(edge, sign):
        links = _links(vertices, faces[rows], edge[rows], sign[rows])
        shape = (len(rows), len(rows))
        graph = coo_matrix((np.ones(len(links)), links.T), shape=shape)
        _, label = connected_components(graph, directed=False)
        found += [rows[label == one] for one in dict.fromkeys(label.tolist())]
    return found


def _in_file_order(edge: np.ndarray, sign: np.ndarray) -> list[np.ndarray]:
    """Rows of triangles that follow each other in the file and close a surface.

    A tool for convex decomposition writes its parts one after the other. Where parts touch, only
    this order says which is which.

    Args:
        edge: numbers of the sides' edges (m, 3).
        sign: directions along them (m, 3).
    """
    if (np.bincount(edge.reshape(-1)) <= 2).all():
        return [np.arange(len(edge))]
    balance = [0] * (int(edge.max()) + 1)
    unbalanced, start, found = 0, 0, []
    for row, (numbers, signs) in enumerate(zip(edge.tolist(), sign.tolist(), strict=True)):
        for number, direction in zip(numbers, signs, strict=True):
            before = balance[number]
            balance[number] = after = before + direction
            unbalanced += (after != 0) - (before != 0)
        if unbalanced == 0 and row + 1 - start >= 4:  # the fewest that enclose a volume
            found.append(np.arange(start, row + 1))
            start = row + 1
    if start < len(edge):  # two triangles back to back
        found.append(np.arange(start, len(edge)))
    return found


def _links(
    vertices: np.ndarray, faces: np.ndarray, edge: np.ndarray, sign: np.ndarray
) -> np.ndarray:
    """Pairs of triangles (k, 2) that belong to the same surface, side by side at an edge.

    Where more than two meet, those belong together between which the solid lies: going round the
    edge, it begins at a triangle that runs against the edge and ends at one that runs along it.

    Args:
        vertices: (n, 3).
        faces: triangles (m, 3) that are closed together.
        edge: numbers of the sides' edges (m, 3).
        sign: directions along them (m, 3).
    """
    order = np.argsort(edge.reshape(-1), kind="stable")
    starts = np.flatnonzero(np.diff(edge.reshape(-1)[order], prepend=-1))
    counts = np.diff(starts, append=len(order))
    pairs = starts[counts == 2]
    found = [np.stack((order[pairs], order[pairs + 1]), axis=1) // 3]
    for start, count in zip(starts[counts > 2], counts[counts > 2], strict=True):
        sides = order[start : start + count]
        if count > _AROUND_AN_EDGE:
            found.append(np.stack((sides[:-1], sides[1:]), axis=1) // 3)
            continue
        angle, direction = _around(vertices, faces, sides), sign.reshape(-1)[sides]
        begin, end = np.flatnonzero(direction < 0), np.flatnonzero(direction > 0)
        turn = (angle[end][None, :] - angle[begin][:, None] - _SAME_ANGLE) % (2 * np.pi)
        for _ in range(min(len(begin), len(end))):
            i, j = np.unravel_index(int(np.argmin(turn)), turn.shape)
            found.append(sides[[[begin[i], end[j]]]] // 3)
            turn[i], turn[:, j] = np.inf, np.inf
    return np.concatenate(found)


def _around(vertices: np.ndarray, faces: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Angles (k,) [rad] at which triangles stand around their common edge.

    Args:
        vertices: (n, 3).
        faces: triangles (m, 3).
        sides: 3 times the triangle plus which of its sides the edge is (k,).
    """
    row, side = np.divmod(sides, 3)
    one, other = faces[row, side], faces[row, (side + 1) % 3]
    origin = vertices[min(one[0], other[0])]
    axis = vertices[max(one[0], other[0])] - origin
    axis = axis / max(float(np.linalg.norm(axis)), np.finfo(float).tiny)
    across = vertices[faces[row, (side + 2) % 3]] - origin
    first = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = first - (first @ axis) * axis
    first = first / np.linalg.norm(first)
    return np.arctan2(across @ np.cross(axis, first), across @ first)
