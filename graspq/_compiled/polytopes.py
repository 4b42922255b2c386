"""Polytopes with their faces, packed for ``minkowski_volume``, and the memory that it needs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Columns of a face: a vertex, up to five more that with it span the face, how many faces cover it,
# and one vertex out of each that is not in the face.
BASE, BASIS, COVERS, COVER = 0, 1, 6, 7
# A count that starts from a plain 0 has a type of its own, for which Numba compiles once more.
ZERO = np.int64(0)
# Columns of a body after the first face of each dimension (0 to 6, and the end): its vertices, and
# whether one of its faces is chosen.
FIRST_VERTEX, END_VERTEX, TAKEN = 8, 9, 10
# Parts of ``Workspace.sums``: 6 V and the area, the sum of the area vectors, a vertex of the sum of
# the chosen faces in their complement.
VOLUME, AREA, CLOSURE, VERTEX = 0, 1, 2, 8


class Polytopes(NamedTuple):
    """The bodies and their faces, in arrays for all bodies.

    Attributes:
        vertices: vertices of all bodies, (V, 6).
        bodies: per body where its faces of every dimension and its vertices are, (n, 11).
        faces: vertices of every face, and of the faces that cover it, (F, 7 + most covers).
        volumes: volume of a face over that of the parallelotope of its basis, (F,).
    """

    vertices: np.ndarray
    bodies: np.ndarray
    faces: np.ndarray
    volumes: np.ndarray


class Workspace(NamedTuple):
    """Memory for one sum.

    Attributes:
        choice: per depth the body, the face, and rows in use before it, (4, 3).
        sizes: per depth the volume of the faces chosen before it, (4,).
        rows: orthonormal directions of the chosen faces, then of their complement, (6, 6).
        flat: vertices in the complement, and whether another hides one, (V, 4).
        cuts: of the chosen faces, in the complement, (K, 3).
        rays: two cones: rays and a height of each, (2 (K + 4), 4).
        levels: heights of vertices along rays, (V, K + 4).
        arcs: normals of edges in the cone, three rows each, (3 E + 3, 3).
        normal: of a facet in the complement, (3,).
        sums: what the facets add up to, (11,).
    """

    choice: np.ndarray
    sizes: np.ndarray
    rows: np.ndarray
    flat: np.ndarray
    cuts: np.ndarray
    rays: np.ndarray
    levels: np.ndarray
    arcs: np.ndarray
    normal: np.ndarray
    sums: np.ndarray


def workspace_for(polytopes: Polytopes) -> Workspace:
    """Memory for the sum of these bodies."""
    vertices, cuts = len(polytopes.vertices), 3 * int(polytopes.faces[:, COVERS].max())
    edges = int((polytopes.bodies[:, 2] - polytopes.bodies[:, 1]).sum())
    return Workspace(
        choice=np.zeros((4, 3), np.int64),
        sizes=np.ones(4),
        rows=np.zeros((6, 6)),
        flat=np.zeros((vertices, 4)),
        cuts=np.zeros((cuts, 3)),
        rays=np.zeros((2 * (cuts + 4), 4)),
        levels=np.zeros((vertices, cuts + 4)),
        arcs=np.zeros((3 * edges + 3, 3)),
        normal=np.zeros(3),
        sums=np.zeros(11),
    )
