"""The shape of a user's object from a mesh file."""

from __future__ import annotations

from pathlib import PurePosixPath

import mujoco
import numpy as np

from sdh_sim.objects.extents import check_extents
from sdh_sim.objects.facts import Facts
from sdh_sim.objects.geoms import set_surface
from sdh_sim.objects.mesh_colours import ColouredSurface, coloured_surfaces
from sdh_sim.objects.mesh_parts import Parts, parts_of
from sdh_sim.user_files.folder import Folder
from sdh_sim.user_files.mesh_limits import MAX_MESH, joined
from sdh_sim.user_files.meshes import read_mesh

_COLOUR = (0.55, 0.62, 0.7, 1.0)
_KIND = mujoco.mjtMeshInertia


def from_mesh(folder: Folder, facts: Facts, file: str) -> tuple[mujoco.MjSpec, Parts, list[str]]:
    """The body ``object`` with a collision geom for every part of a mesh, and visual ones.

    Args:
        folder: to read from.
        facts: what ``object.toml`` says.
        file: name of the mesh relative to the folder.

    Returns:
        the object, its parts, and notes for the user.

    Raises:
        MeshError: a mesh that cannot be used.
        ObjectError: a file that cannot be read.
    """
    data = folder.read(file, MAX_MESH)
    pieces = read_mesh(data, PurePosixPath(file).suffix)
    points = np.concatenate([vertices[np.unique(faces)] for vertices, faces in pieces])
    check_extents(np.ptp(points, axis=0) * facts.scale, facts.scale)
    scaled = [(vertices * facts.scale, faces) for vertices, faces in pieces]
    parts = parts_of(scaled, facts.hull, facts.decompose)
    drawn, notes = coloured_surfaces(folder, file, data, _COLOUR)
    drawn = [ColouredSurface(d.rgba, d.vertices * facts.scale, d.faces) for d in drawn]
    if not drawn and parts.replaced:
        drawn = [ColouredSurface(_COLOUR, *joined(scaled))]
    spec = mujoco.MjSpec()
    spec.add_material(name="surface", rgba=_COLOUR)
    body = spec.worldbody.add_body(name="object")
    for number, surface in enumerate(drawn):
        mesh, material = spec.add_mesh(name=f"drawn_{number}"), f"colour_{number}"
        set_surface(mesh, surface.vertices, surface.faces, _KIND.mjMESH_INERTIA_SHELL)
        spec.add_material(name=material, rgba=surface.rgba)
        _add_geom(body, f"visual_{number}", mesh.name, material, contact=0)
    for number, part in enumerate(parts.parts):
        mesh = spec.add_mesh(name=f"part_{number}")
        set_surface(mesh, part.vertices, part.faces, _KIND.mjMESH_INERTIA_EXACT)
        if not drawn:
            _add_geom(body, f"visual_{number}", mesh.name, "surface", contact=0)
        _add_geom(body, f"collision_{number}", mesh.name, "", contact=1)
    return spec, parts, [*parts.notes, *notes]


def _add_geom(body: mujoco.MjsBody, name: str, mesh: str, material: str, contact: int) -> None:
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=mesh,
        material=material,
        contype=contact,
        conaffinity=contact,
    )
