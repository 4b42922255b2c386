"""The shape of a user's object from an MJCF file and its meshes."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath

import mujoco
import numpy as np

from sdh_sim.errors import MeshError, MjcfError
from sdh_sim.objects.contact_settings import WATER
from sdh_sim.objects.facts import MESHES, Facts
from sdh_sim.objects.geoms import collides, set_surface
from sdh_sim.objects.mesh_parts import Part, Parts, hull_of, parts_of
from sdh_sim.objects.mjcf_files import ObjectTree, parse_mjcf
from sdh_sim.objects.mjcf_words import SHAPES
from sdh_sim.poses import rotation_of
from sdh_sim.user_files.folder import Folder
from sdh_sim.user_files.mesh_limits import MAX_FACES, MAX_PARTS, MeshPiece, joined
from sdh_sim.user_files.meshes import read_mesh_file
from sdh_sim.user_files.mjcf_meshes import take_mesh_place, written_mesh

_KIND = mujoco.mjtMeshInertia


@dataclass(frozen=True)
class _Surface:
    """What MuJoCo gets as a mesh.

    Attributes:
        mesh: vertices (n, 3) and triangles (m, 3).
        inertia: what its inertia is of.
    """

    mesh: MeshPiece
    inertia: mujoco.mjtMeshInertia


def from_mjcf(
    folder: Folder, facts: Facts, file: str
) -> tuple[mujoco.MjSpec, Parts | None, list[str]]:
    """The body ``object`` of an MJCF file, its meshes read from the folder.

    Args:
        folder: to read from.
        facts: what ``object.toml`` says.
        file: name of the MJCF relative to the folder.

    Returns:
        the object, the parts of the meshes that collide (None: no mesh does), notes for the user.

    Raises:
        MjcfError: MJCF, or a mesh that it names, that cannot be used.
        MeshError: the object is too large, too small or too thin.
        ObjectError: a file that cannot be read, or a scale.
    """
    if facts.scale != 1.0:
        raise folder.error("object.toml: scale is for mesh files; MJCF has a scale for each mesh")
    tree = parse_mjcf(folder, file)
    notes = []
    if tree.ignored:
        notes.append("ignored, as it says nothing about the shape: " + ", ".join(tree.ignored))
    pieces = _read_meshes(folder, tree.root, PurePosixPath(file).parent)
    spec = _parsed(tree.root)
    if any(geom.type == mujoco.mjtGeom.mjGEOM_PLANE for geom in spec.geoms):
        raise MjcfError(f"has a plane in a body; shapes are {', '.join(SHAPES)}")
    colliding = {
        geom.meshname
        for geom in spec.geoms
        if collides(geom) and geom.type == mujoco.mjtGeom.mjGEOM_MESH
    }
    surfaces: dict[str, _Surface] = {}
    divided: dict[str, list[Part]] = {}
    every: list[Part] = []
    computed = False
    for mesh in spec.meshes:
        if mesh.name not in colliding:
            surfaces[mesh.name] = _Surface(joined(pieces[mesh.name]), _KIND.mjMESH_INERTIA_SHELL)
            continue
        parts = _parts(mesh, pieces[mesh.name], facts)
        every += parts.parts
        computed |= parts.decomposed
        notes += [f"{mesh.name}: {note}" for note in parts.notes]
        whole = _Surface(joined(pieces[mesh.name]), _inertia(mesh, parts))
        if parts.whole or facts.hull:
            surfaces[mesh.name] = whole
        else:
            surfaces[mesh.name] = _Surface(whole.mesh, _KIND.mjMESH_INERTIA_SHELL)
            divided[mesh.name] = parts.parts
            notes += [f"{mesh.name}: divided into {len(parts.parts)} convex parts"]
    if divided:
        surfaces |= _divide(tree, spec, divided)
        spec = _parsed(tree.root)
    for mesh in spec.meshes:
        mesh.file = ""
        set_surface(mesh, *surfaces[mesh.name].mesh, surfaces[mesh.name].inertia)
    return spec, Parts(every, (), decomposed=computed) if every else None, notes


def stated_mass(spec: mujoco.MjSpec) -> float | None:
    """Mass [kg] that the geoms of an MJCF state by mass or density; None: they state none.

    What does not collide has none. All geoms are left with MuJoCo's default density, since mass and
    its distribution are of the shape and ``object.toml``.
    """
    stated = any(
        collides(geom) and (geom.density != WATER or not np.isnan(geom.mass)) for geom in spec.geoms
    )
    mass = None
    if stated:
        try:
            trial = spec.copy()
            for geom in trial.geoms:
                if not collides(geom):
                    geom.mass = 0.0
            mass = float(trial.compile().body("object").mass[0])
        except (ValueError, TypeError, KeyError, mujoco.FatalError):
            mass = None  # what is wrong with the shape is said when the object is compiled
    for geom in spec.geoms:
        geom.density, geom.mass = WATER, np.nan
    return mass


def _parsed(root: ET.Element) -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))


def _read_meshes(
    folder: Folder, root: ET.Element, place: PurePosixPath
) -> dict[str, list[MeshPiece]]:
    """The pieces of every mesh by its name; the tree gets file names that MuJoCo never opens.

    Args:
        folder: to read from.
        root: of the checked MJCF; changed in place.
        place: folder of the MJCF file, relative to ``folder``.
    """
    where = take_mesh_place(root, place)
    pieces: dict[str, list[MeshPiece]] = {}
    for number, mesh in enumerate(root.findall("asset/mesh")):
        if "file" in mesh.attrib:
            name = where.path(mesh.attrib["file"])
            mesh.attrib.setdefault("name", PurePosixPath(name).stem)
            found = read_mesh_file(folder, name, MESHES)
        else:
            if "name" not in mesh.attrib:
                raise MjcfError("has a <mesh> with neither name nor file")
            found = _written_mesh(mesh)
        mesh.set("file", f"{number}.obj")  # MuJoCo wants a name with an ending that it knows
        pieces[mesh.attrib["name"]] = found
    if sum(len(faces) for found in pieces.values() for _, faces in found) > MAX_FACES:
        raise MjcfError(f"has more than {MAX_FACES} triangles in its meshes; simplify them")
    return pieces


def _written_mesh(mesh: ET.Element) -> list[MeshPiece]:
    """The mesh whose vertices, and perhaps triangles, stand in the MJCF itself."""
    name = mesh.attrib["name"]
    vertices, faces = written_mesh(name, mesh)
    if len(faces):
        return [(vertices, faces)]
    try:
        return [hull_of(vertices)]  # as MuJoCo has it
    except MeshError as error:
        raise MjcfError(f"has the mesh {name!r:.60}, which {error}") from error


def _parts(mesh: mujoco.MjsMesh, pieces: list[MeshPiece], facts: Facts) -> Parts:
    """The parts of a mesh that collides, in metres and in the frame that its geoms place."""
    # A mirrored mesh has its triangles inside out, which MuJoCo corrects.
    turned = slice(None, None, -1 if np.prod(mesh.scale) < 0 else 1)
    placed = [(_placed(mesh, vertices), faces[:, turned]) for vertices, faces in pieces]
    try:
        return parts_of(placed, facts.hull, facts.decompose)
    except MeshError as error:
        raise MjcfError(f"has the mesh {mesh.name!r:.60}, which {error}") from error


def _placed(mesh: mujoco.MjsMesh, vertices: np.ndarray) -> np.ndarray:
    """Vertices (n, 3) as MuJoCo places them by the mesh's refpos, refquat and scale [m]."""
    if np.any(mesh.refpos) or not np.allclose(mesh.refquat, (1, 0, 0, 0)):
        turn = np.array(mesh.refquat) / np.linalg.norm(mesh.refquat)
        vertices = (vertices - np.asarray(mesh.refpos)) @ rotation_of(turn)
    return vertices * np.asarray(mesh.scale)


def _inertia(mesh: mujoco.MjsMesh, parts: Parts) -> mujoco.mjtMeshInertia:
    """What the inertia of a mesh that collides is of: as the file says, else of the solid."""
    kinds = (_KIND.mjMESH_INERTIA_CONVEX, _KIND.mjMESH_INERTIA_SHELL)
    if mesh.inertia in kinds:
        return mesh.inertia
    return _KIND.mjMESH_INERTIA_CONVEX if parts.replaced else _KIND.mjMESH_INERTIA_EXACT


def _divide(
    tree: ObjectTree, spec: mujoco.MjSpec, divided: Mapping[str, list[Part]]
) -> dict[str, _Surface]:
    """Give every geom that collides as a mesh of several parts a copy for each of them.

    Args:
        tree: changed in place.
        spec: of the tree, to know which geoms collide.
        divided: parts of the meshes, by name.

    Returns:
        surfaces of the new meshes, by name.
    """
    surfaces: dict[str, _Surface] = {}
    for asset in tree.root.findall("asset"):
        for mesh in [m for m in asset.findall("mesh") if m.get("name") in divided]:
            for number, part in enumerate(divided[mesh.attrib["name"]]):
                made = copy.deepcopy(mesh)
                name = f"{mesh.attrib['name']}:{number}"
                made.attrib |= {"name": name, "scale": "1 1 1", "file": f"{number}.obj"}
                made.attrib |= {"refpos": "0 0 0", "refquat": "1 0 0 0"}
                asset.append(made)
                surfaces[name] = _Surface((part.vertices, part.faces), _KIND.mjMESH_INERTIA_EXACT)
    known = {geom.name: geom for geom in spec.geoms}
    for parent in list(tree.root.iter()):
        for element in parent.findall("geom"):
            geom = known.get(element.get("name", ""))
            if parent.tag == "default" or geom is None or geom.meshname not in divided:
                continue
            if not collides(geom) or geom.type != mujoco.mjtGeom.mjGEOM_MESH:
                continue
            at = list(parent).index(element)
            parent.remove(element)
            for number in range(len(divided[geom.meshname])):
                made = copy.deepcopy(element)
                made.attrib |= {"name": f"{geom.name}:{number}"}
                made.attrib |= {"mesh": f"{geom.meshname}:{number}"}
                parent.insert(at + number, made)
    copies = len(tree.root.findall("worldbody")[0].findall(".//geom"))
    if copies > 2 * MAX_PARTS:
        raise MjcfError(f"is divided into {copies} geoms; at most {2 * MAX_PARTS} are taken")
    return surfaces
