"""A user's folder becomes what a built-in object is: one body ``object`` that stands on z = 0.

The shape comes from the folder's mesh or MJCF; mass, friction and the rest from ``object.toml``.
MuJoCo gets numbers that were read and checked here, never a file.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import mujoco
import numpy as np

from sdh_sim.errors import MeshError, MjcfError, ObjectError
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.objects.extents import check_extents
from sdh_sim.objects.facts import FACTS, MJCF, Facts, Spread
from sdh_sim.objects.facts_file import model_file, read_facts
from sdh_sim.objects.geoms import set_roles
from sdh_sim.objects.mesh_object import from_mesh
from sdh_sim.objects.mesh_parts import Parts, hull_ratio
from sdh_sim.objects.mjcf_object import from_mjcf, stated_mass
from sdh_sim.objects.placement import set_mass_and_pose
from sdh_sim.user_files.folder import Folder, FolderKind
from sdh_sim.user_references import ObjectFolder

OBJECT_KIND = FolderKind("object", ObjectError, f"{FACTS} and a mesh or an MJCF file")


@dataclass(frozen=True)
class UserObject:
    """The object of a user's folder.

    Attributes:
        reference: path and content of the folder, for workers and ``run.json``; its notes say what
            was done with the files.
        name: of the object in tables.
        spec: the body ``object`` without a joint, standing on z = 0 at the origin.
        spread: of the grasps; None: the default.
        file: with the shape, relative to the folder.
        parts: number of collision shapes.
        hull_ratio: volume of the hulls over that of the meshes (1: convex); None without meshes.
        stated_mass: that an MJCF states by mass or density [kg]; None: it does not.
    """

    reference: ObjectFolder
    name: str
    spec: mujoco.MjSpec
    spread: Spread | None
    file: str
    parts: int
    hull_ratio: float | None
    stated_mass: float | None = None


def read_folder(path: str | Path) -> UserObject:
    """The object of a folder.

    Raises:
        ObjectError: anything in it that cannot be used.
    """
    folder = Folder(path, OBJECT_KIND)
    facts = read_facts(folder)
    file = model_file(folder, facts)
    try:
        spec, parts, notes, mass = _shape(folder, facts, file)
        shapes = set_roles(spec, facts.friction)
        notes += set_mass_and_pose(folder, spec, facts, file)
        spec.compile()  # a model that cannot be compiled is refused here, not in a trial
    except (MeshError, MjcfError) as error:
        raise folder.error(f"{file} {error}") from error
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        if isinstance(error, ObjectError):
            raise
        reason = (str(error).splitlines() or [""])[0][:160]
        raise folder.error(f"{file} cannot be compiled: {reason}") from error
    # Another version of CoACD may make other parts of the same file: that is another object.
    computed = [p for p in parts.parts if parts.decomposed] if parts else []
    digest = folder.sha256(b"".join(p.vertices.tobytes() + p.faces.tobytes() for p in computed))
    return UserObject(
        reference=ObjectFolder(str(folder.path), digest, tuple(notes)),
        name=facts.name,
        spec=spec,
        spread=facts.spread,
        file=file,
        parts=shapes,
        hull_ratio=hull_ratio(parts.parts) if parts else None,
        stated_mass=mass,
    )


def _shape(
    folder: Folder, facts: Facts, file: str
) -> tuple[mujoco.MjSpec, Parts | None, list[str], float | None]:
    """The body ``object`` of a file, the parts of its meshes, notes, and the mass it states [kg].

    Raises:
        MeshError, MjcfError, ObjectError: a shape that cannot be used.
    """
    if PurePosixPath(file).suffix.lower() != MJCF:
        return *from_mesh(folder, facts, file), None
    spec, parts, notes = from_mjcf(folder, facts, file)
    mass = stated_mass(spec)
    model = spec.compile()
    if np.any(model.geom_contype):
        check_extents(np.ptp(collision_vertices(model), axis=0))
    return spec, parts, notes, mass
