"""Meshes of an MJCF file: where their files are, and those that are written in it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np

from sdh_sim.errors import MjcfError
from sdh_sim.user_files.mesh_limits import MeshPiece


@dataclass(frozen=True)
class MeshPlace:
    """Where the mesh files of an MJCF file are.

    Attributes:
        folder: of the meshes, relative to the user's folder.
        strip: the folders in a mesh's name do not count.
    """

    folder: PurePosixPath
    strip: bool

    def path(self, file: str) -> str:
        """Of the mesh file that the MJCF calls so, relative to the user's folder."""
        if self.strip:
            file = PurePosixPath(file.replace("\\", "/")).name
        return str(self.folder / file)


def take_mesh_place(root: ET.Element, place: PurePosixPath) -> MeshPlace:
    """Where the meshes are; takes what says so out of the tree, as nothing else may open a file.

    Args:
        root: of the MJCF; changed in place.
        place: folder of the MJCF file, relative to the user's.
    """
    options: dict[str, str] = {}
    for compiler in root.findall("compiler"):
        options |= compiler.attrib
        for name in ("meshdir", "assetdir", "strippath"):
            compiler.attrib.pop(name, None)
    folder = place / options.get("meshdir", options.get("assetdir", ""))
    return MeshPlace(folder, options.get("strippath") == "true")


def written_mesh(name: str, mesh: ET.Element) -> MeshPiece:
    """Vertices (n, 3) and triangles (m, 3; none: their hull is meant) that the MJCF itself has.

    Args:
        name: of the mesh, for messages.
        mesh: the element; loses both.

    Raises:
        MjcfError: not numbers in threes, or a corner that is no vertex.
    """
    try:
        points = np.array([float(v) for v in mesh.attrib.pop("vertex").split()])
        corners = np.array([float(v) for v in mesh.attrib.pop("face", "").split()])
    except ValueError as error:
        raise MjcfError(f"has the mesh {name!r:.60}, whose vertex or face is no number") from error
    if len(points) % 3 or len(corners) % 3:
        raise MjcfError(f"has the mesh {name!r:.60}, whose vertex or face is not in threes")
    vertices, faces = points.reshape(-1, 3), corners.astype(np.int64).reshape(-1, 3)
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise MjcfError(f"has the mesh {name!r:.60}, whose face names a vertex that it lacks")
    return vertices, faces
