"""The connected surfaces of a mesh, each of which must be closed, outward and convex.

MuJoCo collides the convex hull of a mesh. So a shape that is not convex comes as several closed
convex parts in one file (what tools for convex decomposition write), or is refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from sdh_sim.errors import MeshError
from sdh_sim.objects.mesh_files import MeshPiece

MAX_PARTS = 64
HULL_RATIO = 1.05  # a hull of up to so many times the volume counts as the mesh itself


@dataclass(frozen=True)
class Part:
    """One connected surface.

    Attributes:
        vertices: (n, 3) [m].
        faces: corners of the triangles (m, 3).
        volume: enclosed, negative where the surface is inside out [m^3]; NaN: it is not closed.
        hull_volume: of the convex hull [m^3].
    """

    vertices: np.ndarray
    faces: np.ndarray
    volume: float
    hull_volume: float


def parts_of(pieces: list[MeshPiece], scale: float) -> list[Part]:
    """The connected surfaces of a mesh, in metres.

    Args:
        pieces: vertices (n, 3) and triangles (m, 3) of each, in the file's unit.
        scale: metres per unit.

    Raises:
        MeshError: none, more of them than are taken, or one is flat.
    """
    found: list[Part] = []
    for vertices, faces in pieces:
        for v, f in _connected(*_merged(vertices * scale, faces)):
            if len(found) >= MAX_PARTS:
                raise MeshError(f"has more than {MAX_PARTS} separate parts; join or drop some")
            try:
                hull = float(ConvexHull(v).volume)
            except (QhullError, ValueError) as error:
                raise MeshError("has a part that is flat; remove it or give it a thickness") from (
                    error
                )
            mesh = trimesh.Trimesh(v, f, process=False)
            closed = mesh.is_watertight and mesh.is_winding_consistent
            found.append(Part(v, f, float(mesh.volume) if closed else np.nan, hull))
    if not found:
        raise MeshError("holds no triangle with an area")
    return found


def _merged(vertices: np.ndarray, faces: np.ndarray) -> MeshPiece:
    """Vertices at the same place become one; triangles with two corners at one place go."""
    merged, index = np.unique(vertices[faces.reshape(-1)], axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    a, b, c = triangles.T
    return merged, triangles[(a != b) & (b != c) & (c != a)]


def _connected(vertices: np.ndarray, faces: np.ndarray) -> list[MeshPiece]:
    """The surfaces that share no vertex, each with its own vertices, in the order of the file."""
    if not len(faces):
        return []
    ends = np.concatenate((faces[:, :2], faces[:, 1:]))
    links = coo_matrix((np.ones(len(ends)), ends.T), shape=(len(vertices),) * 2)
    _, label = connected_components(links, directed=False)
    of_face = label[faces[:, 0]]
    order = list(dict.fromkeys(of_face.tolist()))
    if len(order) > MAX_PARTS:
        raise MeshError(
            f"falls into {len(order)} separate parts; at most {MAX_PARTS} are taken (where "
            "neighbouring triangles share no vertex, it is not closed)"
        )
    found = []
    for part in order:
        used, index = np.unique(faces[of_face == part], return_inverse=True)
        found.append((vertices[used], index.reshape(-1, 3)))
    return found


def check_solid(parts: list[Part], hull: bool) -> None:
    """Raise MeshError unless every part is closed, outward and (or ``hull``) convex."""
    for number, part in enumerate(parts):
        which = _which(parts, number)
        if np.isnan(part.volume):
            raise MeshError(
                f"is not watertight{which}: it has a hole, or triangles that are turned or meet "
                "three at an edge; repair it in a mesh editor"
            )
        if part.volume <= 0.0:
            raise MeshError(
                f"is inside out{which}: its volume is {part.volume:.3g} m³; flip the triangles, "
                "or leave the surface of an inner cavity out"
            )
    ratios = [part.hull_volume / part.volume for part in parts]
    worst = int(np.argmax(ratios))
    if ratios[worst] > HULL_RATIO and not hull:
        raise MeshError(
            f"is not convex{_which(parts, worst)}: its hull has {ratios[worst]:.3g} times its "
            "volume, and MuJoCo collides the hull; divide it into closed convex parts in the same "
            "file, or accept the hull with hull = true"
        )


def _which(parts: list[Part], number: int) -> str:
    """Names a part by its place in space: files order and name parts in many ways."""
    if len(parts) == 1:
        return ""
    centre = ", ".join(f"{v:.4g}" for v in parts[number].vertices.mean(axis=0))
    return f" (the one of {len(parts)} parts around {centre} m)"


def hull_ratio(parts: list[Part]) -> float:
    """Volume of the parts' convex hulls over the volume of the parts; 1 where all are convex."""
    return sum(p.hull_volume for p in parts) / sum(p.volume for p in parts)
