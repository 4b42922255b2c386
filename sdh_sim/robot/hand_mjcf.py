"""A hand's MJCF as MuJoCo gets it: what was read and checked here alone, never a file."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import PurePosixPath

import mujoco
import numpy as np

from sdh_sim.errors import MjcfError
from sdh_sim.robot.hand_words import (
    ATTRIBUTES,
    CHILDREN,
    DROPPED,
    DROPPED_ATTRIBUTES,
    REASONS,
    WITHIN,
)
from sdh_sim.user_files.folder import Folder
from sdh_sim.user_files.mesh_limits import MeshPiece, joined
from sdh_sim.user_files.meshes import read_mesh_file
from sdh_sim.user_files.mjcf_meshes import take_mesh_place, written_mesh
from sdh_sim.user_files.mjcf_tree import read_tree

MESHES = (".stl", ".obj", ".msh")  # endings that MuJoCo takes, too
MOST = {"body": 100, "geom": 500, "mesh": 60, "joint": 200, "fixed": 50, "exclude": 500}
MAX_TRIANGLES = 300_000  # of all meshes
_LARGEST, _LONGEST = 1e9, 1 << 20  # number, and characters of a value


def read_mjcf(folder: Folder, file: str, angle: str = "") -> tuple[mujoco.MjSpec, list[str]]:
    """The model of a hand, and what of its file does not count.

    Args:
        folder: to read from.
        file: name of the MJCF relative to it.
        angle: ``radian`` or ``degree`` where the file does not say, because it is made to be
            included by one that does; empty: as MuJoCo has it.

    Raises:
        MjcfError: not MJCF, or something in it that a hand may not have.
        SettingsError: a file that cannot be read.
    """
    root = read_tree(folder, file)
    dropped: set[str] = set()
    if angle:
        root.insert(0, ET.Element("compiler", {"angle": angle}))  # the file's own come later
    _check(root, dropped)
    for tag, most in MOST.items():
        if (count := sum(1 for _ in root.iter(tag))) > most:
            raise MjcfError(f"has {count} elements <{tag}>; at most {most} are taken")
    meshes = _read_meshes(folder, root, PurePosixPath(file).parent, dropped)
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        reason = " ".join(str(error).split())[:160]
        raise MjcfError(f"is not MJCF that MuJoCo can read: {reason}") from error
    for mesh in spec.meshes:
        mesh.file = ""
        vertices, faces = meshes[mesh.name]
        mesh.uservert = vertices.astype(np.float32).reshape(-1)
        mesh.userface = faces.astype(np.int32).reshape(-1)
        if mesh.inertia == mujoco.mjtMeshInertia.mjMESH_INERTIA_LEGACY:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX  # it need not be closed
    return spec, sorted(dropped)


def _check(element: ET.Element, dropped: set[str], parent: str = "") -> None:
    """Take out of an element, and of those below it, what does not count.

    Args:
        element: changed in place.
        dropped: names of what was taken out; added to.
        parent: what the element stands in.

    Raises:
        MjcfError: it has what a hand may not have.
    """
    tag = element.tag
    allowed = WITHIN.get((parent, tag), ATTRIBUTES.get(tag, ()))
    for name, value in list(element.attrib.items()):
        if name in allowed:
            _check_value(tag, name, value)
        elif name in DROPPED_ATTRIBUTES.get(tag, ()):
            del element.attrib[name]
            dropped.add(name)
        else:
            raise MjcfError(
                f"has {name!r:.40} of <{tag}>, which a hand may not have{_reason(name)}"
            )
    for child in list(element):
        name = child.tag
        if name in DROPPED.get(tag, ()):
            element.remove(child)
            dropped.add(name)
        elif name in CHILDREN.get(tag, ()):
            _check(child, dropped, tag)
        else:
            raise MjcfError(
                f"has <{name:.40}> in <{tag}>, which a hand may not have{_reason(name)}"
            )


def _check_value(tag: str, name: str, value: str) -> None:
    """Raise MjcfError unless a value is printable and its numbers are finite."""
    where = f"{value!r:.60} as {name!r} of <{tag}>"
    if len(value) > _LONGEST or not value.replace("\n", " ").replace("\t", " ").isprintable():
        raise MjcfError(f"has {where}; give a printable value")
    for word in value.split():
        try:
            number = float(word)
        except ValueError:
            continue
        if not (math.isfinite(number) and abs(number) <= _LARGEST):
            raise MjcfError(f"has {where}; give finite numbers up to {_LARGEST:g}")


def _reason(name: str) -> str:
    """Why an element or attribute is refused, as the end of a message; may be empty."""
    return f": {REASONS[name]}" if name in REASONS else ""


def _read_meshes(
    folder: Folder, root: ET.Element, place: PurePosixPath, dropped: set[str]
) -> dict[str, MeshPiece]:
    """Vertices and triangles of every mesh by its name, in the file's unit.

    Args:
        folder: to read from.
        root: of the checked MJCF; its meshes get names of files that MuJoCo never opens.
        place: folder of the MJCF file, relative to ``folder``.
        dropped: what does not count; added to.
    """
    where = take_mesh_place(root, place)
    found: dict[str, MeshPiece] = {}
    parents = [(asset, mesh) for asset in root.findall("asset") for mesh in asset.findall("mesh")]
    for number, (asset, mesh) in enumerate(parents):
        name, file = mesh.get("name", ""), mesh.get("file")
        if file is not None:
            file = where.path(file)
            name = name or PurePosixPath(file).stem
        if name in found:  # MuJoCo would refuse it; programs that join files take the first
            asset.remove(mesh)
            dropped.add(f"the second mesh {name!r:.60}")
            continue
        if file is not None:
            piece = joined(read_mesh_file(folder, file, MESHES))
        elif name and "vertex" in mesh.attrib:
            piece = written_mesh(name, mesh)
            if len(piece[0]) < 4:
                raise MjcfError(f"has the mesh {name!r:.60} of fewer than four vertices")
        else:
            raise MjcfError("has a <mesh> with neither a file nor a vertex and a name")
        mesh.attrib |= {"name": name, "file": f"{number}.obj"}
        found[name] = piece
    if sum(len(faces) for _, faces in found.values()) > MAX_TRIANGLES:
        raise MjcfError(f"has more than {MAX_TRIANGLES} triangles in its meshes; simplify them")
    return found
