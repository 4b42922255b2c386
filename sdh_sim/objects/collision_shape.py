"""Points that span an object's collision shapes."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from sdh_sim.poses import rotation_of

_RING = 64  # directions around a round shape; a multiple of 4, to have its extremes on the axes


def collision_vertices(model: mujoco.MjModel) -> np.ndarray:
    """Points that span the shapes of a model which collide, in their bodies' frames (n, 3) [m].

    Of boxes and meshes they are the vertices, of round shapes points on the surface: extents along
    the shape's own axes are exact, along others within 0.2 % of its size.
    """
    return np.concatenate([points for _, points in shapes_of(model)])


def shapes_of(model: mujoco.MjModel) -> Iterator[tuple[int, np.ndarray]]:
    """Each geom that collides, with points (n, 3) [m] that span it in its body's frame."""
    for geom in np.flatnonzero(model.geom_contype):
        rotation = rotation_of(model.geom_quat[geom])
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            local = _mesh_points(model, int(model.geom_dataid[geom]))
        else:
            local = _primitive(int(model.geom_type[geom]), model.geom_size[geom])
        yield int(geom), local @ rotation.T + model.geom_pos[geom]


def _mesh_points(model: mujoco.MjModel, mesh: int) -> np.ndarray:
    """Vertices (n, 3) [m] of a mesh that collide: of its hull, which maxhullvert may simplify."""
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    vertices = model.mesh_vert[start : start + count].astype(float)
    graph = int(model.mesh_graphadr[mesh])
    if graph < 0:
        return vertices
    # MuJoCo's layout: number of vertices and of faces, an address and an index for each vertex, …
    hull = int(model.mesh_graph[graph])
    return vertices[model.mesh_graph[graph + 2 + hull : graph + 2 + 2 * hull]]


def _primitive(kind: int, size: np.ndarray) -> np.ndarray:
    """Points (n, 3) [m] that span a geom of MuJoCo's type ``kind`` in its own frame.

    Args:
        kind: box, cylinder, capsule, ellipsoid or sphere.
        size: the geom's size (3,) [m].
    """
    shapes = mujoco.mjtGeom
    if kind == shapes.mjGEOM_BOX:
        signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
        return signs * size
    angles = 2 * np.pi * np.arange(_RING) / _RING
    ring = np.stack((np.cos(angles), np.sin(angles), np.zeros(_RING)), axis=1)
    ends = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    if kind == shapes.mjGEOM_CYLINDER:
        return np.concatenate([ring * size[0] + end * size[1] for end in ends])
    heights = np.linspace(-1.0, 1.0, _RING + 1)[1:-1]
    ball = [ring * np.sqrt(1 - z * z) + (0.0, 0.0, z) for z in np.sin(heights * np.pi / 2)]
    ball = np.concatenate([*ball, ends])
    if kind == shapes.mjGEOM_CAPSULE:
        return np.concatenate([ball * size[0] + end * size[1] for end in ends])
    return ball * (size if kind == shapes.mjGEOM_ELLIPSOID else size[0])
