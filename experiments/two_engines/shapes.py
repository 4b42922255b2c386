"""Collision shapes of a compiled MuJoCo model as shapes of Drake."""

# pyright: reportMissingImports=false
from __future__ import annotations

import mujoco
import numpy as np
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, Shape, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from sdh_sim.errors import SettingsError
from sdh_sim.objects.collision_shape import shapes_of
from sdh_sim.poses import rotation_of

FOOT = 0.03  # of an object that stands: what may touch the table before it has left the hand [m]
APART = 6e-3  # least distance of points that it stands on [m]


def transform_of(position: np.ndarray, quat: np.ndarray) -> RigidTransform:
    """A pose from a position (3,) [m] and a unit quaternion w x y z (4,)."""
    rotation = RotationMatrix.ProjectToRotationMatrix(rotation_of(quat))
    return RigidTransform(rotation, np.asarray(position, dtype=float))


def shape_of(model: mujoco.MjModel, geom: int) -> Shape:
    """The shape of a geom in its own frame [m]; of a mesh its convex hull, as in MuJoCo.

    Raises:
        SettingsError: a kind of geom that has no counterpart.
    """
    kinds, size = mujoco.mjtGeom, model.geom_size[geom]
    match int(model.geom_type[geom]):
        case kinds.mjGEOM_SPHERE:
            return Sphere(size[0])
        case kinds.mjGEOM_CAPSULE:
            return Capsule(size[0], 2 * size[1])
        case kinds.mjGEOM_CYLINDER:
            return Cylinder(size[0], 2 * size[1])
        case kinds.mjGEOM_ELLIPSOID:
            return Ellipsoid(*size)
        case kinds.mjGEOM_BOX:
            return Box(*(2 * size))
        case kinds.mjGEOM_PLANE:
            return HalfSpace()
        case kinds.mjGEOM_MESH:
            mesh = int(model.geom_dataid[geom])
            first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
            vertices = model.mesh_vert[first : first + count].astype(float)
            return Convex(np.asfortranarray(vertices.T), model.mesh(mesh).name)
    raise SettingsError(
        f"geom {model.geom(geom).name!r} is of a kind that the other engine has not: take "
        "spheres, capsules, cylinders, ellipsoids, boxes, planes or meshes"
    )


def standing_points(model: mujoco.MjModel, body: int, pose: np.ndarray) -> np.ndarray:
    """Points of a body's collision shapes with which it can stand on a level plane (n, 3) [m].

    They are corners of boxes and meshes and points on the rims of round shapes, in the body's
    frame: those no higher than ``FOOT`` above its lowest point, one of those close together.

    Args:
        model: compiled.
        body: id.
        pose: of the body in the world (7,).
    """
    found = [points for geom, points in shapes_of(model) if model.geom_bodyid[geom] == body]
    points = np.concatenate(found)
    height = points @ rotation_of(pose[3:])[2]
    low = np.flatnonzero(height < height.min() + FOOT)
    chosen: list[np.ndarray] = []
    for point in points[low[np.argsort(height[low], kind="stable")]]:
        if all(np.linalg.norm(point - other) >= APART for other in chosen):
            chosen.append(point)
    return np.array(chosen)
