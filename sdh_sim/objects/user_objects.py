"""A user's folder becomes what a built-in object is: one body ``object`` that stands on z = 0.

The shape comes from the folder's mesh or MJCF; mass, friction and the rest from ``object.toml``.
MuJoCo gets numbers that were read and checked here, never a file.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import mujoco
import numpy as np

from sdh_sim.errors import MeshError, MjcfError, ObjectError
from sdh_sim.objects.facts import MJCF, Facts, Spread
from sdh_sim.objects.facts_file import model_file, read_facts
from sdh_sim.objects.folder_reader import Folder
from sdh_sim.objects.mesh_files import MAX_FACES, MeshPiece, read_mesh
from sdh_sim.objects.mesh_parts import Part, check_solid, hull_ratio, parts_of
from sdh_sim.objects.mjcf_files import parse_mjcf
from sdh_sim.objects.placement import check_extents, set_mass_and_pose
from sdh_sim.user_references import ObjectFolder

MAX_MJCF = 1 << 20  # [bytes]
MAX_MESH = 16 << 20  # [bytes]
_COLOUR = (0.55, 0.62, 0.7, 1.0)
_CONTACT = {"contype": 1, "conaffinity": 15, "condim": 3}  # models/objects/README.md
_VISUAL_GROUP, _COLLISION_GROUP = 2, 3  # the second is not drawn


@dataclass(frozen=True)
class UserObject:
    """The object of a user's folder.

    Attributes:
        reference: path and content of the folder, for workers and ``run.json``.
        name: of the object in tables.
        spec: the body ``object`` without a joint, standing on z = 0 at the origin.
        spread: of the grasps; None: the default.
        file: with the shape, relative to the folder.
        parts: number of collision shapes.
        hull_ratio: volume of the hulls over that of the meshes (1: convex); None without meshes.
    """

    reference: ObjectFolder
    name: str
    spec: mujoco.MjSpec
    spread: Spread | None
    file: str
    parts: int
    hull_ratio: float | None


def read_folder(path: str | Path) -> UserObject:
    """The object of a folder.

    Raises:
        ObjectError: anything in it that cannot be used.
    """
    folder = Folder(path)
    facts = read_facts(folder)
    file = model_file(folder, facts)
    try:
        if PurePosixPath(file).suffix.lower() == MJCF:
            spec, parts = _from_mjcf(folder, facts, file)
        else:
            spec, parts = _from_mesh(folder, facts, file)
        shapes = _set_roles(spec, facts.friction)
        set_mass_and_pose(folder, spec, facts, file)
        spec.compile()  # a model that cannot be compiled is refused here, not in a trial
    except (MeshError, MjcfError) as error:
        raise folder.error(f"{file} {error}") from error
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        if isinstance(error, ObjectError):
            raise
        reason = (str(error).splitlines() or [""])[0][:160]
        raise folder.error(f"{file} cannot be compiled: {reason}") from error
    return UserObject(
        reference=ObjectFolder(str(folder.path), folder.sha256()),
        name=facts.name,
        spec=spec,
        spread=facts.spread,
        file=file,
        parts=shapes,
        hull_ratio=hull_ratio(parts) if parts else None,
    )


def _from_mesh(folder: Folder, facts: Facts, file: str) -> tuple[mujoco.MjSpec, list[Part]]:
    """The body with a visual and a collision geom for every part of a mesh file.

    Raises:
        MeshError: a mesh that cannot be used.
    """
    pieces = read_mesh(folder.read(file, MAX_MESH), PurePosixPath(file).suffix)
    points = np.concatenate([vertices[np.unique(faces)] for vertices, faces in pieces])
    check_extents(np.ptp(points, axis=0) * facts.scale, "set scale", facts.scale)
    parts = parts_of(pieces, facts.scale)
    check_solid(parts, facts.hull)
    spec = mujoco.MjSpec()
    spec.add_material(name="surface", rgba=_COLOUR)
    body = spec.worldbody.add_body(name="object")
    for number, part in enumerate(parts):
        mesh = spec.add_mesh(name=f"part_{number}")
        _set_surface(mesh, part.vertices, part.faces, solid=True)
        for name, contact in (("visual", 0), ("collision", 1)):
            body.add_geom(
                name=f"{name}_{number}",
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=mesh.name,
                material="surface" if not contact else "",
                contype=contact,
                conaffinity=contact,
            )
    return spec, parts


def _from_mjcf(folder: Folder, facts: Facts, file: str) -> tuple[mujoco.MjSpec, list[Part]]:
    """The body of an MJCF file, its meshes read from the folder; the parts of those that collide.

    Raises:
        MjcfError: MJCF, or a mesh that it names, that cannot be used.
        ObjectError: a file that cannot be read, or a scale.
    """
    if facts.scale != 1.0:
        raise folder.error("object.toml: scale is for mesh files; MJCF has a scale for each mesh")
    root = parse_mjcf(folder.read(file, MAX_MJCF))
    pieces = _read_meshes(folder, root, PurePosixPath(file).parent)
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    colliding = {geom.meshname for geom in spec.geoms if _collides(geom)}
    parts: list[Part] = []
    for mesh in spec.meshes:
        vertices, faces = _joined(pieces[mesh.name])
        if mesh.name in colliding:
            # A mirrored mesh has its triangles inside out, which MuJoCo corrects.
            outward = faces[:, ::-1] if np.prod(mesh.scale) < 0 else faces
            parts += _solid_parts(mesh.name, vertices * np.asarray(mesh.scale), outward, facts.hull)
        mesh.file = ""
        _set_surface(mesh, vertices, faces, solid=mesh.name in colliding)
    return spec, parts


def _read_meshes(
    folder: Folder, root: ET.Element, place: PurePosixPath
) -> dict[str, list[MeshPiece]]:
    """The pieces of every mesh by its name; the tree gets file names that MuJoCo never opens.

    Args:
        folder: to read from.
        root: of the checked MJCF; changed in place.
        place: folder of the MJCF file, relative to ``folder``.
    """
    compiler = root.find("compiler")
    options = {} if compiler is None else compiler.attrib
    place = place / (options.pop("meshdir", options.pop("assetdir", "")))
    options.pop("assetdir", None)
    pieces: dict[str, list[MeshPiece]] = {}
    for number, mesh in enumerate(root.iter("mesh")):
        name = str(place / mesh.attrib["file"])
        mesh.attrib.setdefault("name", PurePosixPath(name).stem)
        ending = PurePosixPath(name).suffix
        if ending.lower() not in (".stl", ".obj", ".ply", ".off", ".glb"):
            raise MjcfError(f"has the mesh {name!r:.80}; it must be STL, OBJ, PLY, OFF or GLB")
        try:
            found = read_mesh(folder.read(name, MAX_MESH), ending)
        except MeshError as error:
            raise MjcfError(f"has the mesh {name!r:.80}, which {error}") from error
        mesh.set("file", f"{number}.obj")  # MuJoCo wants a name with an ending that it knows
        pieces[mesh.attrib["name"]] = found
    if sum(len(faces) for found in pieces.values() for _, faces in found) > MAX_FACES:
        raise MjcfError(f"has more than {MAX_FACES} triangles in its meshes; simplify them")
    return pieces


def _solid_parts(name: str, vertices: np.ndarray, faces: np.ndarray, hull: bool) -> list[Part]:
    """The parts of one mesh of an MJCF that collides, vertices (n, 3) [m], triangles (m, 3)."""
    parts = parts_of([(vertices, faces)], 1.0)
    try:
        check_solid(parts, hull)
    except MeshError as error:
        raise MjcfError(f"has the mesh {name!r:.60}, which {error}") from error
    if len(parts) > 1 and not hull:
        raise MjcfError(
            f"has the mesh {name!r:.60}, which is {len(parts)} parts: write each to a "
            "file and a geom of its own, or accept the hull of all with hull = true"
        )
    return parts


def _joined(pieces: list[MeshPiece]) -> MeshPiece:
    """Pieces as one: vertices (n, 3), triangles (m, 3)."""
    starts = np.cumsum([0, *(len(v) for v, _ in pieces)])
    faces = [f + start for (_, f), start in zip(pieces, starts, strict=False)]
    return np.concatenate([v for v, _ in pieces]), np.concatenate(faces)


def _set_surface(
    mesh: mujoco.MjsMesh, vertices: np.ndarray, faces: np.ndarray, solid: bool
) -> None:
    """Give a mesh its vertices (n, 3) [m] and triangles (m, 3); a solid one has a volume."""
    mesh.uservert = vertices.astype(np.float32).reshape(-1)
    mesh.userface = faces.astype(np.int32).reshape(-1)
    kind = mujoco.mjtMeshInertia
    mesh.inertia = kind.mjMESH_INERTIA_EXACT if solid else kind.mjMESH_INERTIA_SHELL


def _collides(geom: mujoco.MjsGeom) -> bool:
    return bool(geom.contype or geom.conaffinity)


def _set_roles(spec: mujoco.MjSpec, friction: float) -> int:
    """Make every geom visual or colliding, as those of built-in objects are.

    Args:
        spec: the object; changed in place.
        friction: Coulomb's coefficient of what collides.

    Returns:
        the number of collision shapes.

    Raises:
        MjcfError: nothing collides.
    """
    colliding = [geom for geom in spec.geoms if _collides(geom)]
    if not colliding:
        raise MjcfError("has no geom that touches anything (all have contype 0, conaffinity 0)")
    # Collision shapes are hidden where visual ones show the object.
    hidden = len(colliding) < len(spec.geoms)
    for geom in spec.geoms:
        if geom in colliding:
            for name, value in _CONTACT.items():
                setattr(geom, name, value)
            geom.friction = (friction, 0.005, 0.0001)
            geom.group = _COLLISION_GROUP if hidden else _VISUAL_GROUP
        else:
            geom.group = _VISUAL_GROUP
            geom.mass = 0.0
    return len(colliding)
