"""Mesh files of users: read with bounds, then checked to be closed, outward and convex.

MuJoCo collides the convex hull of a mesh. So a shape that is not convex comes as several closed
convex parts in one file (what tools for convex decomposition write), or is refused.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import re
import struct
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from sdh_sim.errors import MeshError

MAX_FACES = 100_000
MAX_PARTS = 64
MAX_GROUPS = 1000  # that an OBJ file divides its faces into
_GROUP = re.compile(rb"(?m)^[ \t]*(?:o|g|usemtl|s|endsolid)\b")
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


def read_mesh(data: bytes, ending: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Vertices (n, 3) and triangles (m, 3) of every piece of a mesh file, in the file's unit.

    Args:
        data: content of the file; nothing but it is opened.
        ending: of the file's name, such as ``.stl``.

    Raises:
        MeshError: not a mesh of that format, not finite, or over the bounds.
    """
    kind = ending.lower().removeprefix(".")
    _check_claims(data, kind)
    options: dict[str, Any] = {"process": False, "resolver": None, "allow_remote": False}
    if kind in ("obj", "glb", "gltf"):
        options["skip_materials"] = True  # pictures would be decoded
    if kind == "obj":
        options["split_objects"] = True
    try:
        with _quiet():
            scene = trimesh.load_scene(io.BytesIO(data), file_type=kind, **options)
            pieces = [_piece(g) for g in scene.dump() if isinstance(g, trimesh.Trimesh)]
    except MeshError:
        raise
    except (Exception, RecursionError) as error:  # a reader of damaged files raises anything
        reason = f"{type(error).__name__}: {error}".splitlines()[0][:120]
        raise MeshError(f"is not a mesh that can be read as {kind.upper()} ({reason})") from error
    pieces = [p for p in pieces if len(p[1])]
    if not pieces:
        raise MeshError("holds no triangles")
    _check_count(sum(len(p[1]) for p in pieces))
    return pieces


def _check_count(faces: int) -> None:
    if faces > MAX_FACES:
        raise MeshError(f"has more than {MAX_FACES} triangles or what goes with them; simplify it")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """The reader keeps what it thinks of a file to itself: one message goes to the user, ours."""
    log = logging.getLogger("trimesh")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(before)


def _piece(mesh: trimesh.Trimesh) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
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


def _check_claims(data: bytes, kind: str) -> None:
    """Refuse what would grow beyond its bytes: counts in heads, references, instances."""
    if kind in ("glb", "gltf"):
        _check_gltf(data, kind)
    elif kind in ("ply", "off"):
        head = data[:100_000].partition(b"end_header")[0] if kind == "ply" else data[:1000]
        words = head.split(b"\n" if kind == "ply" else None)
        for word in words if kind == "ply" else words[:4]:
            for number in re.findall(rb"-?\d{1,40}", word):
                if abs(int(number)) > len(data) and (kind == "off" or b"element" in word):
                    raise MeshError("claims to hold more than its bytes can")
                if b"element" in word or kind == "off":
                    _check_count(int(number) // 3)  # vertices too: three for each face at most
    elif kind in ("obj", "stl"):
        if len(_GROUP.findall(data)) > MAX_GROUPS:
            raise MeshError(f"divides its faces into more than {MAX_GROUPS} groups; join them")
        if kind == "obj":  # text is slow to read: what is too much is counted first
            _check_count(data.count(b"\nf"))
            _check_count(data.count(b"\nv") // 9)  # with normals and texture coordinates


def _check_gltf(data: bytes, kind: str) -> None:
    try:
        document = json.loads(_gltf_text(data) if kind == "glb" else data)
        if document.get("extensionsRequired"):
            raise MeshError("needs extensions of glTF; write it without compression")
        places = [str(b.get("uri", "data:")) for b in document.get("buffers", [])]
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
    if not all(place.startswith("data:") for place in places):
        raise MeshError("refers to other files; embed its buffers (GLB does)")
    _check_count(max([0, shown, *counts]) // 3)  # also where one mesh is shown many times
    if len(counts) > MAX_GROUPS or len(nodes) > MAX_GROUPS:
        raise MeshError(f"has more than {MAX_GROUPS} nodes or accessors; join them")
    if max([0, *views]) > len(data) or sum(counts) > 20 * 3 * MAX_FACES:
        raise MeshError("claims to hold more than its bytes can")


def _gltf_text(data: bytes) -> bytes:
    magic, _, _, size, chunk = struct.unpack_from("<4sIII4s", data)
    if magic != b"glTF" or chunk != b"JSON":
        raise ValueError("no GLB head")
    return data[20 : 20 + size]


def parts_of(pieces: list[tuple[np.ndarray, np.ndarray]], scale: float) -> list[Part]:
    """The connected surfaces of a mesh, in metres.

    Raises:
        MeshError: more of them than are taken, or one is flat.
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


def _merged(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices at the same place become one; triangles with two corners at one place go."""
    place, index = np.unique(vertices[faces.reshape(-1)], axis=0, return_inverse=True)
    joined = index.reshape(-1, 3)
    a, b, c = joined.T
    return place, joined[(a != b) & (b != c) & (c != a)]


def _connected(vertices: np.ndarray, faces: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
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
    for number, part in enumerate(parts, 1):
        which = _which(parts, number - 1)
        if np.isnan(part.volume):
            raise MeshError(
                f"is not watertight{which}: it has a hole, or triangles that are turned or meet "
                "three at an edge; mend it in a mesh editor"
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
    """Names a part by its place, since files order and name parts as they like."""
    if len(parts) == 1:
        return ""
    centre = ", ".join(f"{v:.4g}" for v in parts[number].vertices.mean(axis=0))
    return f" (the one of {len(parts)} parts around {centre} m)"


def hull_ratio(parts: list[Part]) -> float:
    """Volume of the parts' hulls over the volume of the parts."""
    return sum(p.hull_volume for p in parts) / sum(p.volume for p in parts)
