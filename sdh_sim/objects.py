"""The objects that can be grasped: found in models/objects, their numbers read from the MJCF."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

from sdh_sim.model_files import models_dir
from sdh_sim.settings import SettingsError

# The order of the paper's figure 5; other folders follow by name.
PAPER_ORDER = ("box", "oval_bottle", "spray_bottle", "cylindrical_bottle")


@dataclass(frozen=True)
class ObjectInfo:
    """What is known of an object before any simulation.

    Attributes:
        name: folder name of the model.
        mass_kg: mass [kg].
        friction: coefficient of Coulomb friction against the pads.
        com_m: centre of mass in the object's frame (3,) [m].
        extents_m: size along the axes of the object's frame (3,) [m].
        standing_quat: orientation in which it stands on the table, w x y z (4,).
        standing_height: height of the object's frame over the table when standing [m].
        height: height of its top over the table when standing [m].
        narrow_yaw: direction of its narrower horizontal side when standing at yaw 0 [rad].
        half_narrow, half_wide: half of the narrower and the wider horizontal side [m].
        inertia_kgm2: inertia tensor at the centre of mass, object axes (3, 3) [kg m^2].
    """

    name: str
    mass_kg: float
    friction: float
    com_m: np.ndarray
    extents_m: np.ndarray
    standing_quat: np.ndarray
    standing_height: float
    height: float
    narrow_yaw: float
    half_narrow: float
    half_wide: float
    inertia_kgm2: np.ndarray


@cache
def object_names() -> tuple[str, ...]:
    """Names of all object models, the paper's four first in its order."""
    folder = models_dir() / "objects"
    found = {p.name for p in folder.iterdir() if (p / f"{p.name}.xml").is_file()}
    first = [name for name in PAPER_ORDER if name in found]
    return (*first, *sorted(found - set(first)))


def object_file(name: str) -> Path:
    """The object's MJCF.

    Raises:
        SettingsError: no such object.
    """
    if name not in object_names():
        raise SettingsError(f"object: got {name!r}; choose one of {', '.join(object_names())}")
    return models_dir() / "objects" / name / f"{name}.xml"


@cache
def object_info(name: str) -> ObjectInfo:
    """Numbers of an object, from its compiled MJCF.

    Raises:
        SettingsError: no such object.
    """
    path = object_file(name)
    model = mujoco.MjModel.from_xml_path(str(path))
    body = model.body("object").id
    vertices = _collision_vertices(model)
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.body_quat[body])
    world = vertices @ rotation.reshape(3, 3).T + model.body_pos[body]
    principal = np.empty(9)
    mujoco.mju_quat2Mat(principal, model.body_iquat[body])
    axes = principal.reshape(3, 3)
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
    )


def _collision_vertices(model: mujoco.MjModel) -> np.ndarray:
    """Points that span the collision shapes, in the object's frame (n, 3) [m]."""
    points = []
    for geom in np.flatnonzero(model.geom_contype):
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[geom]
            start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
            local = model.mesh_vert[start : start + count].astype(float)
        else:
            centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
            signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
            local = centre + signs * half
        points.append(local @ rotation.reshape(3, 3).T + model.geom_pos[geom])
    return np.concatenate(points)


def _frozen(values: np.ndarray) -> np.ndarray:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
