"""One closed surface around a union of convex solids, by surface nets.

Gibson's surface nets (1998): every grid cell that the surface crosses holds one vertex, every
crossed grid edge one quad. The vertices are then slid evenly over the surface and put exactly on
it, which no marching method does and a boolean of meshes does not distribute.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import trimesh

Array = npt.NDArray[np.float64]

_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def union_surface(
    parts: Sequence[trimesh.Trimesh], pitch: float, relaxations: int = 8
) -> trimesh.Trimesh:
    """Closed mesh of the union of convex meshes, vertices about `pitch` apart [m].

    Features thinner than two pitches may be lost. Raises ValueError when the result is not closed:
    a finer pitch resolves two sheets that pass through one cell.
    """
    solids = [_convex(part, 2.0 * pitch) for part in parts]
    low = np.min([p.bounds[0] for p in parts], axis=0) - 1.37 * pitch
    high = np.max([p.bounds[1] for p in parts], axis=0) + 1.37 * pitch
    shape = np.ceil((high - low) / pitch).astype(int) + 1
    grid = np.stack(np.meshgrid(*(np.arange(s) for s in shape), indexing="ij"), axis=-1)
    values = _distance(low + pitch * grid.reshape(-1, 3), solids)[0].reshape(shape)

    vertices, cell_ids = _cell_vertices(values)
    faces = _quads(values < 0.0, cell_ids)
    vertices = low + pitch * vertices
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    neighbours = _neighbour_means(mesh)
    for _ in range(relaxations):
        distance, normal = _distance(vertices, solids)
        step = neighbours(vertices) - vertices
        step -= np.sum(step * normal, axis=1, keepdims=True) * normal
        vertices = vertices + 0.5 * step
        for _ in range(3):
            distance, normal = _distance(vertices, solids)
            vertices = vertices - distance[:, None] * normal
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if not mesh.is_watertight:
        raise ValueError(f"the surface is not closed at a pitch of {pitch} m: try a finer one")
    return mesh


@dataclass(frozen=True)
class _Convex:
    """Facets of a convex mesh: outward unit normals (k, 3), offsets (k,) and bounds (2, 3) [m]."""

    normals: Array
    offsets: Array
    bounds: Array


def _convex(part: trimesh.Trimesh, margin: float) -> _Convex:
    """A part's distinct facets, and its bounding box grown by the margin [m]."""
    normals = np.asarray(part.face_normals)
    offsets = np.sum(normals * part.triangles_center, axis=1)
    rows = np.unique(np.column_stack((normals, offsets)).round(9), axis=0)
    return _Convex(rows[:, :3], rows[:, 3], part.bounds + np.array([[-margin], [margin]]))


def _distance(points: Array, parts: Sequence[_Convex]) -> tuple[Array, Array]:
    """Signed distance (n,) [m] to the nearest part's facet planes and its unit gradient (n, 3).

    Infinite outside the grown bounding boxes of all parts, where no surface is near.
    """
    best = np.full(len(points), np.inf)
    gradient = np.zeros((len(points), 3))
    for part in parts:
        near = np.flatnonzero(np.all((points > part.bounds[0]) & (points < part.bounds[1]), axis=1))
        heights = points[near] @ part.normals.T - part.offsets
        facet = np.argmax(heights, axis=1)
        distance = heights[np.arange(len(near)), facet]
        nearer = distance < best[near]
        best[near[nearer]] = distance[nearer]
        gradient[near[nearer]] = part.normals[facet[nearer]]
    return best, gradient


def _cell_vertices(values: Array) -> tuple[Array, npt.NDArray[np.int64]]:
    """Mean of the edge crossings of every crossed cell (v, 3), in grid units, and its index."""
    cells = np.array(values.shape) - 1
    corner = np.stack(
        [values[i : i + cells[0], j : j + cells[1], k : k + cells[2]] for i, j, k in _CORNERS],
        axis=-1,
    )
    crossed = (corner.min(-1) < 0.0) & (corner.max(-1) >= 0.0)
    where, value = np.argwhere(crossed), corner[crossed]
    total, count = np.zeros((len(where), 3)), np.zeros((len(where), 1))
    for a in range(8):
        for b in range(a + 1, 8):
            if np.abs(_CORNERS[a] - _CORNERS[b]).sum() != 1:
                continue
            hit = (value[:, a] < 0.0) != (value[:, b] < 0.0)
            t = value[hit, a] / (value[hit, a] - value[hit, b])
            total[hit] += _CORNERS[a] + t[:, None] * (_CORNERS[b] - _CORNERS[a])
            count[hit] += 1.0
    ids = np.full(crossed.shape, -1)
    ids[crossed] = np.arange(len(where))
    return where + total / count, ids


def _quads(inside: npt.NDArray[np.bool_], ids: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Two triangles around every grid edge that leaves or enters the solid, facing outwards."""
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        here, there = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
        edges = np.argwhere(np.moveaxis(here != there, 0, axis))
        leaving = inside[tuple(edges.T)]
        step_u, step_v = np.eye(3, dtype=int)[u], np.eye(3, dtype=int)[v]
        around = (edges - step_u - step_v, edges - step_v, edges, edges - step_u)
        quad = np.column_stack([ids[tuple(cell.T)] for cell in around])
        quad[~leaving] = quad[~leaving][:, ::-1]
        faces += [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
    return np.concatenate(faces)


def _neighbour_means(mesh: trimesh.Trimesh):
    """Function from vertices (v, 3) to the mean of each one's neighbours (v, 3)."""
    first, second = np.concatenate((mesh.edges_unique, mesh.edges_unique[:, ::-1])).T
    degree = np.bincount(first, minlength=len(mesh.vertices)).astype(float)

    def means(vertices: Array) -> Array:
        sums = [
            np.bincount(first, weights=vertices[second, i], minlength=len(vertices))
            for i in range(3)
        ]
        return np.column_stack(sums) / degree[:, None]

    return means
