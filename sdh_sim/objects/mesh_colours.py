"""Colours of a mesh for pictures: the diffuse colour of each material of an OBJ file's MTL files.

Nothing depends on them. What is missing, damaged or outside the folder is left out, and so are
textures.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

import numpy as np

from sdh_sim.errors import ObjectError
from sdh_sim.user_files.mesh_limits import MeshPiece

if TYPE_CHECKING:
    from sdh_sim.user_files.folder import Folder

MAX_MTL = 1 << 20  # [bytes]
MAX_LIBRARIES = 8
MAX_MATERIALS = 64  # in use; more are not told apart
_TEXTURE = re.compile(rb"(?m)^[ \t]*(?:map_|bump|disp|refl)")
_LIBRARY = re.compile(rb"(?m)^[ \t]*mtllib[ \t]+([^\r\n]+)")

Colour = tuple[float, float, float, float]


@dataclass(frozen=True)
class ColouredSurface:
    """Triangles of one colour.

    Attributes:
        rgba: red, green, blue, opacity, 0 to 1.
        vertices: (n, 3), in the unit of the file.
        faces: triangles (m, 3).
    """

    rgba: Colour
    vertices: np.ndarray
    faces: np.ndarray


def coloured_surfaces(
    folder: Folder, file: str, data: bytes, default: Colour
) -> tuple[list[ColouredSurface], list[str]]:
    """The surface of an OBJ file by colour, and notes for the user.

    Args:
        folder: to read MTL files from.
        file: name of the OBJ file relative to it.
        data: its content.
        default: colour of triangles whose material has none.

    Returns:
        no surface where no material has a colour.
    """
    if PurePosixPath(file).suffix.lower() != ".obj":
        return [], []
    colours, notes = _materials(folder, PurePosixPath(file).parent, data)
    if not colours:
        return [], notes
    try:
        soups = _triangles_by_material(data)
    except (ValueError, IndexError):
        return [], notes
    by_colour: dict[Colour, list[np.ndarray]] = {}
    for material, corners in soups.items():
        by_colour.setdefault(colours.get(material, default), []).append(corners)
    if len(by_colour) > MAX_MATERIALS:
        return [], [*notes, f"more than {MAX_MATERIALS} colours left out"]
    found = []
    for rgba, corners in by_colour.items():
        vertices, faces = _surface(np.concatenate(corners))
        if len(faces):
            found.append(ColouredSurface(rgba, vertices, faces))
    return found, notes


def _materials(
    folder: Folder, place: PurePosixPath, data: bytes
) -> tuple[dict[bytes, Colour], list[str]]:
    """Colours by material of the MTL files that an OBJ file names, and notes for the user."""
    colours: dict[bytes, Colour] = {}
    notes = []
    textures = False
    for name in _LIBRARY.findall(data)[:MAX_LIBRARIES]:
        try:
            path = str(place / name.decode("utf-8", "replace").strip())
            text = folder.read(path, MAX_MTL, counts=False)
        except ObjectError:
            notes.append("colours of a material file that cannot be read left out")
            continue
        colours.update(_colours(text))
        textures = textures or _TEXTURE.search(text) is not None
    if textures:
        notes.append("textures left out")
    return colours, list(dict.fromkeys(notes))


def _colours(text: bytes) -> dict[bytes, Colour]:
    """Diffuse colours (``Kd``) by material of an MTL file."""
    found: dict[bytes, Colour] = {}
    name = b""
    for line in text.splitlines():
        word, _, value = line.strip().partition(b" ")
        if word == b"newmtl":
            name = value.strip()
        elif word == b"Kd":
            try:
                red, green, blue = (float(v) for v in value.split()[:3])
            except ValueError:
                continue
            if all(0.0 <= v <= 1.0 for v in (red, green, blue)):
                found[name] = (red, green, blue, 1.0)
    return found


def _triangles_by_material(data: bytes) -> dict[bytes, np.ndarray]:
    """Corners (m, 3, 3) of the triangles of an OBJ file by material.

    Raises:
        ValueError, IndexError: not the OBJ that it was taken for.
    """
    points: list[list[float]] = []
    faces: dict[bytes, list[tuple[int, int, int]]] = {}
    material = b""
    for line in data.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == b"v":
            points.append([float(v) for v in words[1:4]])
        elif words[0] == b"usemtl":
            material = line.strip().partition(b" ")[2].strip()
        elif words[0] == b"f":
            at = [int(word.partition(b"/")[0]) for word in words[1:]]
            at = [k - 1 if k > 0 else len(points) + k for k in at]
            if min(at) < 0:
                raise IndexError
            mine = faces.setdefault(material, [])
            mine += [(at[0], at[k], at[k + 1]) for k in range(1, len(at) - 1)]
    vertices = np.array(points, float).reshape(-1, 3)
    return {name: vertices[np.array(of, int).reshape(-1, 3)] for name, of in faces.items()}


def _surface(corners: np.ndarray) -> MeshPiece:
    """Triangles with an area, from corners (m, 3, 3): vertices (n, 3), n at least 4, (m, 3)."""
    a, b, c = corners.swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    corners = corners[area > 1e-12 * max(float(area.max(initial=0.0)), 1e-300)]
    vertices = corners.reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    return np.concatenate((vertices, vertices[:1])), faces  # MuJoCo takes no mesh of 3 vertices
