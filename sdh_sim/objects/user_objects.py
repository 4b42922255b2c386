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
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.objects.facts import MJCF, Facts, inertia_matrix, model_file, read_facts
from sdh_sim.objects.folder_reader import Folder
from sdh_sim.objects.mesh_files import MAX_FACES, Part, check_solid, hull_ratio, parts_of, read_mesh
from sdh_sim.objects.mjcf_files import parse
from sdh_sim.objects.object_info import Spread
from sdh_sim.poses import rotation_of
from sdh_sim.user_references import ObjectFolder

MAX_MJCF = 1 << 20  # [bytes]
MAX_MESH = 16 << 20
SIZE = (0.01, 0.5)  # the largest extent [m]
THINNEST = 0.005  # the smallest; thinner, the pads' contacts would reach through [m]
STANDS_WITHIN = 0.001  # of its lowest point an object stands on [m]
TOPPLES = 0.002  # centre of mass beyond the area it stands on [m]
HALF = np.sqrt(0.5)
# The quaternion that turns the object's `up` axis to the world's z, and its inverse.
STANDING = {"x": (HALF, 0.0, -HALF, 0.0), "y": (HALF, HALF, 0.0, 0.0), "z": (1.0, 0.0, 0.0, 0.0)}
_COLOUR = (0.55, 0.62, 0.7, 1.0)
_CONTACT = {"contype": 1, "conaffinity": 15, "condim": 3}  # models/objects/README.md


@dataclass(frozen=True)
class UserObject:
    """What a folder makes.

    Attributes:
        reference: path and content, for workers and ``run.json``.
        name: of the object in tables.
        spec: the body ``object`` without a joint, standing on z = 0 at the origin.
        spread: of the grasps; None: the default.
        file: of the shape.
        parts: collision shapes.
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
        solids = _dress(spec, facts)
        _place(folder, spec, facts, file)
        spec.compile()  # what cannot be, is to say so here
    except (MeshError, MjcfError) as error:
        raise folder.fault(f"{file} {error}") from error
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        if isinstance(error, ObjectError):
            raise
        reason = (str(error).splitlines() or [""])[0][:160]
        raise folder.fault(f"{file} cannot be compiled: {reason}") from error
    return UserObject(
        reference=ObjectFolder(str(folder.path), folder.sha256()),
        name=facts.name,
        spec=spec,
        spread=facts.spread,
        file=file,
        parts=solids,
        hull_ratio=hull_ratio(parts) if parts else None,
    )


def _from_mesh(folder: Folder, facts: Facts, file: str) -> tuple[mujoco.MjSpec, list[Part]]:
    pieces = read_mesh(folder.read(file, MAX_MESH), PurePosixPath(file).suffix)
    _check_size(pieces, facts.scale)
    parts = parts_of(pieces, facts.scale)
    check_solid(parts, facts.hull)
    spec = mujoco.MjSpec()
    spec.add_material(name="surface", rgba=_COLOUR)
    body = spec.worldbody.add_body(name="object")
    for number, part in enumerate(parts):
        mesh = spec.add_mesh(name=f"part_{number}")
        _fill(mesh, part.vertices, part.faces, solid=True)
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
    if facts.scale != 1.0:
        raise folder.fault("object.toml: scale is for mesh files; MJCF has a scale for each mesh")
    root = parse(folder.read(file, MAX_MJCF))
    compiler = root.find("compiler")
    options = {} if compiler is None else compiler.attrib
    place = PurePosixPath(file).parent / (options.pop("meshdir", options.pop("assetdir", "")))
    options.pop("assetdir", None)
    pieces = {}
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
        mesh.set("file", f"{number}.obj")  # never opened, but what is read must look like one
        pieces[mesh.attrib["name"]] = found
    if sum(len(f) for found in pieces.values() for _, f in found) > MAX_FACES:
        raise MjcfError(f"has more than {MAX_FACES} triangles in its meshes; simplify them")
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    solid = {g.meshname for g in spec.geoms if _touches(g)}
    parts: list[Part] = []
    for mesh in spec.meshes:
        vertices, faces = _joined(pieces[mesh.name])
        if mesh.name in solid:
            scaled = vertices * np.asarray(mesh.scale)
            # A mirrored mesh has its triangles turned, which MuJoCo mends.
            turned = faces[:, ::-1] if np.prod(mesh.scale) < 0 else faces
            mine = parts_of([(scaled, turned)], 1.0)
            try:
                check_solid(mine, facts.hull)
            except MeshError as error:
                raise MjcfError(f"has the mesh {mesh.name!r:.60}, which {error}") from error
            if len(mine) > 1 and not facts.hull:
                raise MjcfError(
                    f"has the mesh {mesh.name!r:.60}, which is {len(mine)} parts: write each to a "
                    "file and a geom of its own, or accept the hull of all with hull = true"
                )
            parts += mine
        mesh.file = ""
        _fill(mesh, vertices, faces, solid=mesh.name in solid)
    return spec, parts


def _joined(pieces: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    starts = np.cumsum([0, *(len(v) for v, _ in pieces)])
    faces = [f + start for (_, f), start in zip(pieces, starts, strict=False)]
    return np.concatenate([v for v, _ in pieces]), np.concatenate(faces)


def _fill(mesh: mujoco.MjsMesh, vertices: np.ndarray, faces: np.ndarray, solid: bool) -> None:
    mesh.uservert = vertices.astype(np.float32).reshape(-1)
    mesh.userface = faces.astype(np.int32).reshape(-1)
    kind = mujoco.mjtMeshInertia
    mesh.inertia = kind.mjMESH_INERTIA_EXACT if solid else kind.mjMESH_INERTIA_SHELL


def _touches(geom: mujoco.MjsGeom) -> bool:
    return bool(geom.contype or geom.conaffinity)


def _dress(spec: mujoco.MjSpec, facts: Facts) -> int:
    """Give every geom the role of a built-in object's; the number of collision shapes."""
    solids = [geom for geom in spec.geoms if _touches(geom)]
    if not solids:
        raise MjcfError("has no geom that touches anything (all have contype 0, conaffinity 0)")
    seen = len(solids) < len(spec.geoms)
    for geom in spec.geoms:
        if geom in solids:
            for name, value in _CONTACT.items():
                setattr(geom, name, value)
            geom.friction = (facts.friction, 0.005, 0.0001)
            geom.group = 3 if seen else 2  # what only touches is hidden; something must show
        else:
            geom.group = 2
            geom.mass = 0.0
    return len(solids)


def _place(folder: Folder, spec: mujoco.MjSpec, facts: Facts, file: str) -> None:
    """Mass, inertia and the pose on the table."""
    body = spec.body("object")
    model = spec.compile()
    number = model.body("object").id
    points = collision_vertices(model)
    low, high = points.min(axis=0), points.max(axis=0)
    _check_extents(high - low, "set the sizes in metres" if file.endswith(MJCF) else "set scale")
    volume_mass = float(model.body_mass[number])
    if not volume_mass > 0.0:
        raise MjcfError("encloses no volume")
    com = np.array(model.body_ipos[number] if facts.com is None else facts.com)
    if not ((low <= com) & (com <= high)).all():
        raise folder.fault(
            f"object.toml: com is {_mm(com)} mm, outside the shape, which goes from {_mm(low)} to "
            f"{_mm(high)} mm; give x, y, z in metres in the frame of {file}"
        )
    if facts.inertia is None:
        axes = rotation_of(model.body_iquat[number])
        inertia = axes @ np.diag(model.body_inertia[number]) @ axes.T * (facts.mass / volume_mass)
    else:
        inertia = inertia_matrix(facts.inertia)
        _check_inertia(folder, inertia, facts.mass, np.maximum(high - com, com - low))
    turn = rotation_of(np.array(STANDING[facts.up]))
    standing = points @ turn.T
    height = -float(standing[:, 2].min())
    _check_stands(folder, standing, turn @ com, facts.up)
    body.pos, body.quat = (0.0, 0.0, height), STANDING[facts.up]
    body.explicitinertial = True
    body.mass, body.ipos = facts.mass, com
    body.iquat = (1.0, 0.0, 0.0, 0.0)
    body.fullinertia = (*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2])
    w, *axis = STANDING[facts.up]
    foot = turn.T @ np.array([0.0, 0.0, -height])
    body.add_site(name="base", pos=foot, quat=(w, *(-a for a in axis)), size=[0.005] * 3, group=4)


def _check_size(pieces: list[tuple[np.ndarray, np.ndarray]], scale: float) -> None:
    points = np.concatenate([v[np.unique(f)] for v, f in pieces])
    _check_extents(np.ptp(points, axis=0) * scale, "set scale", scale)


def _check_extents(extents: np.ndarray, cure: str, scale: float = 1.0) -> None:
    largest = float(extents.max())
    size = " × ".join(f"{e:.4g}" for e in extents)
    if not SIZE[0] <= largest <= SIZE[1]:
        hint = f"{cure} so that it is between {SIZE[0]:g} and {SIZE[1]:g} m"
        for unit, factor in (("millimetres", 1e-3), ("centimetres", 1e-2), ("inches", 0.0254)):
            if largest > SIZE[1] and 0.03 <= largest * factor <= SIZE[1]:
                hint = f"it looks like {unit}: {cure} = {scale * factor:g}"
                break
        for factor in (1e3, 1e2):
            if largest < SIZE[0] and 0.03 <= largest * factor <= SIZE[1]:
                hint = f"its unit looks {factor:g} times as large: {cure} = {scale * factor:g}"
                break
        raise MeshError(f"is {size} m large; {hint}")
    if extents.min() < THINNEST:
        raise MeshError(f"is {size} m large; no side may be thinner than {THINNEST:g} m")


def _check_inertia(folder: Folder, matrix: np.ndarray, mass: float, reach: np.ndarray) -> None:
    moments = np.linalg.eigvalsh(matrix)
    most = mass * float(reach @ reach)
    if moments[0] <= 0.0 or moments[2] > (moments[0] + moments[1]) * (1 + 1e-9):
        problem = "no body has it: moments must be positive, the largest at most the others' sum"
    elif moments[2] > most:
        problem = f"more than the mass in the farthest corner has ({most:.3g} kg m²)"
    elif moments[2] < 1e-5 * most:
        problem = "as if all mass were in one point"
    else:
        return
    text = ", ".join(f"{m:.3g}" for m in moments)
    raise folder.fault(
        f"object.toml: inertia has the principal moments {text} kg m²: {problem}; give xx, yy, "
        "zz, xy, xz, yz in kg m² about the centre of mass, or leave it out"
    )


def _check_stands(folder: Folder, points: np.ndarray, com: np.ndarray, up: str) -> None:
    """The centre of mass is over what the object stands on, or nearly; arguments as standing."""
    foot = points[points[:, 2] <= points[:, 2].min() + STANDS_WITHIN, :2]
    # The largest way from the foot to the centre of mass, over directions, is the distance.
    angles = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    directions = np.stack((np.cos(angles), np.sin(angles)))
    beyond = float((com[:2] @ directions - (foot @ directions).max(axis=0)).max())
    if beyond > TOPPLES:
        raise folder.fault(
            f"it falls over: standing on {up} up, its centre of mass is {1e3 * beyond:.1f} mm "
            "beside the area that it stands on; set up in object.toml, turn the shape, or mend com"
        )


def _mm(values: np.ndarray) -> str:
    return ", ".join(f"{1e3 * v:.1f}" for v in values)
