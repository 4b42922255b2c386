"""Mesh files of users: read by trimesh, within bounds on size, memory and time.

A small file can claim billions of vertices, or show one mesh many times. So counts in the file are
compared with its bytes before trimesh reads it.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import re
import struct
import warnings
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from sdh_sim.errors import MeshError, MjcfError
from sdh_sim.user_files.folder import Folder
from sdh_sim.user_files.mesh_bytes import read_msh, stl_kind
from sdh_sim.user_files.mesh_limits import MAX_FACES, MAX_MESH, MeshPiece

MAX_GROUPS = 1000  # that an OBJ file divides its faces into
_GROUP = re.compile(rb"(?m)^[ \t]*(?:o|g|usemtl|s|endsolid)\b")


def read_mesh(data: bytes, ending: str) -> list[MeshPiece]:
    """Vertices (n, 3) and triangles (m, 3) of every piece of a mesh file, in the file's unit.

    Args:
        data: content of the file; nothing but it is opened.
        ending: of the file's name, such as ``.stl``.

    Raises:
        MeshError: not a mesh of that format, not finite, or over the bounds.
    """
    kind = ending.lower().removeprefix(".")
    if kind == "msh":
        piece = _piece(*read_msh(data))
        _check_faces(len(piece[1]))
        return [piece]
    if kind == "stl":
        data, kind = stl_kind(data)
    _check_counts(data, kind)
    options: dict[str, Any] = {"process": False, "resolver": None, "allow_remote": False}
    if kind in ("obj", "glb", "gltf"):
        options["skip_materials"] = True  # pictures would be decoded
    if kind == "obj":
        options["split_objects"] = True
    import trimesh  # takes a tenth of a second, which workers of built-in objects do not need

    try:
        with _silent():
            scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, **options)
            meshes = [g for g in scene.dump() if isinstance(g, trimesh.Trimesh)]
            pieces = [_piece(np.asarray(g.vertices), np.asarray(g.faces)) for g in meshes]
    except MeshError:
        raise
    except (Exception, RecursionError) as error:  # trimesh raises anything on a damaged file
        reason = f"{type(error).__name__}: {error}".splitlines()[0][:120]
        name = kind.partition("_")[0].upper()
        raise MeshError(f"is not a mesh that can be read as {name} ({reason})") from error
    pieces = [p for p in pieces if len(p[1])]
    if not pieces:
        raise MeshError("holds no triangles")
    _check_faces(sum(len(p[1]) for p in pieces))
    return pieces


def read_mesh_file(folder: Folder, name: str, endings: Sequence[str]) -> list[MeshPiece]:
    """The pieces of a mesh file that an MJCF file of the folder names.

    Args:
        folder: to read from.
        name: of the file, relative to it.
        endings: that its name may have.

    Raises:
        MjcfError: another ending, or no mesh.
        SettingsError: a file that cannot be read.
    """
    ending = PurePosixPath(name).suffix.lower()
    if ending not in endings:
        raise MjcfError(
            f"has the mesh {name!r:.80}; its name must end in one of {', '.join(endings)}"
        )
    try:
        return read_mesh(folder.read(name, MAX_MESH), ending)
    except MeshError as error:
        raise MjcfError(f"has the mesh {name!r:.80}, which {error}") from error


def _check_faces(faces: int) -> None:
    if faces > MAX_FACES:
        raise MeshError(f"has more than {MAX_FACES} triangles or what goes with them; simplify it")


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Without trimesh's own warnings and log: the user gets one message, from this package."""
    log = logging.getLogger("trimesh")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(before)


def _piece(vertices: np.ndarray, faces: np.ndarray) -> MeshPiece:
    """Vertices and triangles of a mesh; raises MeshError unless finite and consistent."""
    vertices, faces = np.asarray(vertices, float), np.asarray(faces, np.int64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise MeshError("holds something else than triangles")
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise MeshError("has a triangle of vertices that it does not have")
    used = np.unique(faces)
    if not np.isfinite(vertices[used]).all():
        raise MeshError("has a vertex that is not a finite number")
    if len(used) and np.abs(vertices[used]).max() > 1e9:
        raise MeshError("has a vertex further than 1e9 from its origin")
    return vertices, faces


def _check_counts(data: bytes, kind: str) -> None:
    """Refuse a file that says it holds more than its bytes can, or more triangles than are taken.

    Args:
        data: content of the file.
        kind: ending of its name, small letters, without the dot.

    Raises:
        MeshError: counts in its header, references or instances ask for too much.
    """
    if kind in ("glb", "gltf"):
        _check_gltf(data, kind)
    elif kind in ("ply", "off"):
        header = data[:100_000].partition(b"end_header")[0] if kind == "ply" else data[:1000]
        tokens = header.split(b"\n") if kind == "ply" else header.split()[:4]
        for token in tokens:
            for number in re.findall(rb"-?\d{1,40}", token):
                if abs(int(number)) > len(data) and (kind == "off" or b"element" in token):
                    raise MeshError("claims to hold more than its bytes can")
                if b"element" in token or kind == "off":
                    _check_faces(int(number) // 3)  # vertices too: three for each face at most
    elif kind in ("obj", "stl_ascii"):
        if len(_GROUP.findall(data)) > MAX_GROUPS:
            raise MeshError(f"divides its faces into more than {MAX_GROUPS} groups; join them")
        if kind == "obj":  # text is slow to read, so its lines are counted first
            _check_faces(data.count(b"\nf"))
            _check_faces(data.count(b"\nv") // 9)  # with normals and texture coordinates


def _check_gltf(data: bytes, kind: str) -> None:
    """Refuse glTF that refers to other files or asks for too much; arguments as above."""
    try:
        document = json.loads(_gltf_text(data) if kind == "glb" else data)
        if document.get("extensionsRequired"):
            raise MeshError("needs extensions of glTF; write it without compression")
        sources = [str(b.get("uri", "data:")) for b in document.get("buffers", [])]
        counts = [int(a["count"]) for a in document.get("accessors", [])]
        views = [int(v["byteLength"]) for v in document.get("bufferViews", [])]
        corners = [
            sum(counts[p.get("indices", p["attributes"]["POSITION"])] for p in mesh["primitives"])
            for mesh in document.get("meshes", [])
        ]
        nodes = document.get("nodes", [])
        shown = sum(corners[node["mesh"]] for node in nodes if "mesh" in node)
    except MeshError:
        raise
    except (ValueError, LookupError, ArithmeticError, TypeError, AttributeError) as error:
        raise MeshError(f"is not a mesh that can be read as {kind.upper()}") from error
    except (struct.error, RecursionError) as error:
        raise MeshError(f"is not a mesh that can be read as {kind.upper()}") from error
    if not all(source.startswith("data:") for source in sources):
        raise MeshError("refers to other files; embed its buffers (GLB does)")
    _check_faces(max([0, shown, *counts]) // 3)  # also where one mesh is shown many times
    if len(counts) > MAX_GROUPS or len(nodes) > MAX_GROUPS:
        raise MeshError(f"has more than {MAX_GROUPS} nodes or accessors; join them")
    if max([0, *views]) > len(data) or sum(counts) > 20 * 3 * MAX_FACES:
        raise MeshError("claims to hold more than its bytes can")


def _gltf_text(data: bytes) -> bytes:
    """The JSON of a GLB file; raises struct.error or ValueError where it has none."""
    magic, _, _, size, chunk = struct.unpack_from("<4sIII4s", data)
    if magic != b"glTF" or chunk != b"JSON":
        raise ValueError("no GLB header")
    return data[20 : 20 + size]
