"""Closed surfaces that touch, told apart.

Parts that touch share corners or edges with each other. They are told apart by the order of the
file and, where that does not help, by the side of an edge on which the solid lies.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

_AROUND_AN_EDGE = 32  # triangles at one edge that are told apart
_SAME_ANGLE = 1e-4  # triangles that lie on each other [rad]


def edges_of(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each side of a triangle, the number of its edge and its direction along it (m, 3)."""
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].astype(np.int64)
    low, high = ends.min(axis=2), ends.max(axis=2)
    _, edge = np.unique(low * (int(faces.max()) + 1) + high, return_inverse=True)
    return edge.reshape(-1, 3), np.where(ends[..., 0] < ends[..., 1], 1, -1)


def shells(vertices: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    """Rows of the triangles of each closed surface, in the order of the file.

    Args:
        vertices: (n, 3).
        faces: triangles (m, 3) that are closed together.
    """
    edge, sign = edges_of(faces)
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
