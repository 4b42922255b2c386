"""The objects that can be grasped: the models in models/objects, and folders of users.

Both become one body in a ``MjSpec`` of the same form, and what is known of an object is read from
that.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path

import mujoco
import numpy as np

from sdh_sim.errors import SettingsError
from sdh_sim.model_files import models_dir
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.objects.object_info import ObjectInfo
from sdh_sim.objects.surface import ObjectSurface
from sdh_sim.objects.surface_corners import SurfaceCorners, corners_of
from sdh_sim.objects.user_objects import UserObject, read_folder
from sdh_sim.poses import rotation_of
from sdh_sim.user_references import ObjectFolder

# The order of the paper's figure 5; other folders follow by name.
PAPER_ORDER = ("box", "oval_bottle", "spray_bottle", "cylindrical_bottle")


@cache
def object_names() -> tuple[str, ...]:
    """Names of all object models, the paper's four first in its order."""
    folder = models_dir() / "objects"
    found = {p.name for p in folder.iterdir() if (p / f"{p.name}.xml").is_file()}
    first = [name for name in PAPER_ORDER if name in found]
    return (*first, *sorted(found - set(first)))


def user_object(path: str | Path) -> UserObject:
    """The object of a user's folder.

    Args:
        path: of the folder.

    Raises:
        SettingsError: it cannot be used, or has the name of a built-in object.
    """
    found = read_folder(path)
    if found.name in object_names():
        raise SettingsError(
            f"object: {found.reference.path}: the name {found.name!r} is a built-in object's; "
            "set another name in object.toml"
        )
    return found


def object_spec(name: str, folder: ObjectFolder | None = None) -> mujoco.MjSpec:
    """The object as a model of one body ``object``, new at each call.

    Args:
        name: of a built-in object, or of a user's.
        folder: the user's; None for a built-in object.

    Raises:
        SettingsError: no such object, or the folder is not what it was.
    """
    if folder is not None:
        return _loaded(name, folder).spec.copy()
    if name not in object_names():
        raise unknown_object(name)
    return mujoco.MjSpec.from_file(str(models_dir() / "objects" / name / f"{name}.xml"))


def unknown_object(name: str) -> SettingsError:
    """The error for a name that no object has."""
    return SettingsError(
        f"object: got {name!r:.200}; choose one of {', '.join(object_names())}, or all, or give "
        "the path of a folder with an object of your own"
    )


def find_objects(
    asked: Sequence[str], known: Mapping[str, ObjectFolder]
) -> tuple[tuple[str, ...], dict[str, ObjectFolder]]:
    """Names of the objects asked for, each once, and the folders of those that are users'.

    Args:
        asked: names, ``all`` for the built-in ones, and paths of folders.
        known: folders of the run that goes on: their names may be asked for, and they must not
            have changed.

    Raises:
        SettingsError: no such object, a folder that cannot be used or has changed, or two of
            one name.
    """
    names: list[str] = []
    folders: dict[str, ObjectFolder] = {}
    for item in asked:
        if item == "all":
            names += object_names()
        elif item in object_names():
            names.append(item)
        elif item in known:
            names.append(item)
            folders[item] = unchanged(item, known[item]).reference
        elif "/" in item or os.sep in item or item in (".", "..") or Path(item).is_dir():
            found = user_object(item)
            name, folder = found.name, found.reference
            if name in folders and folders[name].sha256 != folder.sha256:
                raise SettingsError(
                    f"object: {folders[name].path} and {folder.path} are both {name!r}; set "
                    "another name in one object.toml"
                )
            if name in known and known[name].sha256 != folder.sha256:
                raise _changed(folder.path)
            names.append(name)
            folders[name] = folder
        else:
            raise unknown_object(item)
    return tuple(dict.fromkeys(names)), folders


def _changed(path: str) -> SettingsError:
    """The error for a folder that is not what it was."""
    return SettingsError(
        f"object: {path} has changed since the run began; bring its files back, or start a run of "
        "its own with another --out"
    )


def unchanged(name: str, folder: ObjectFolder) -> UserObject:
    """The object of a folder that a run refers to.

    Raises:
        SettingsError: it is missing, cannot be used, or has changed.
    """
    found = user_object(folder.path)
    if (found.name, found.reference.sha256) != (name, folder.sha256):
        raise _changed(folder.path)
    return found


# A large mesh takes seconds to check; the reference, with its SHA-256, says which object it is.
_loaded = lru_cache(maxsize=8)(unchanged)


@lru_cache(maxsize=64)
def object_info(name: str, folder: ObjectFolder | None = None) -> ObjectInfo:
    """Numbers of an object, from its compiled model; arguments and errors as ``object_spec``."""
    spread = None
    if folder is None:
        model = object_spec(name).compile()
    else:
        loaded = _loaded(name, folder)
        model, spread = loaded.spec.compile(), loaded.spread
    body = model.body("object").id
    vertices = collision_vertices(model)
    world = vertices @ rotation_of(model.body_quat[body]).T + model.body_pos[body]
    axes = rotation_of(model.body_iquat[body])
    colliding = np.flatnonzero(model.geom_contype)
    return ObjectInfo(
        name=name,
        mass_kg=float(model.body_mass[body]),
        friction=float(model.geom_friction[colliding[0], 0]),
        com_m=_frozen(model.body_ipos[body]),
        extents_m=_frozen(np.ptp(vertices, axis=0)),
        standing_quat=_frozen(model.body_quat[body]),
        standing_height=float(model.body_pos[body, 2]),
        height=float(world[:, 2].max()),
        narrow_yaw=0.0 if np.ptp(world[:, 0]) <= np.ptp(world[:, 1]) else np.pi / 2,
        half_narrow=0.5 * float(np.ptp(world[:, :2], axis=0).min()),
        half_wide=0.5 * float(np.ptp(world[:, :2], axis=0).max()),
        inertia_kgm2=_frozen(axes @ np.diag(model.body_inertia[body]) @ axes.T),
        spread=spread,
        folder=folder,
    )


@lru_cache(maxsize=16)
def surface_of(name: str, folder: ObjectFolder | None = None) -> ObjectSurface:
    """The surface of an object, made once; arguments and errors as ``object_spec``."""
    return ObjectSurface(object_spec(name, folder))


@lru_cache(maxsize=16)
def surface_corners(name: str, folder: ObjectFolder | None = None) -> SurfaceCorners:
    """Corners of an object's surface, found once; arguments and errors as ``object_spec``."""
    positions, normals = corners_of(object_spec(name, folder).compile())
    return SurfaceCorners(_frozen(positions), _frozen(normals))


def _frozen(values: np.ndarray) -> np.ndarray:
    """A copy that cannot be written to, since infos are shared."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
