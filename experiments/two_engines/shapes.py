"""Collision shapes of a compiled MuJoCo model as shapes of Drake."""

from __future__ import annotations

import mujoco
import numpy as np
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, Shape, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from sdh_sim.errors import SettingsError
from sdh_sim.objects.collision_shape import shapes_of
from sdh_sim.poses import rotation_of


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


def standing_points(model: mujoco.MjModel, body: int, spacing: float = 8e-3) -> np.ndarray:
    """Points on the collision shapes of a body with which it stands on a plane (n, 3) [m].

    They are corners of boxes and meshes and points on the rims of round shapes, in the body's
    frame; of those nearer to each other than ``spacing`` [m] one stays.
    """
    found = [points for geom, points in shapes_of(model) if model.geom_bodyid[geom] == body]
    points = np.concatenate(found)
    chosen: list[np.ndarray] = []
    for point in points[np.argsort(-np.linalg.norm(points - points.mean(axis=0), axis=1))]:
        if all(np.linalg.norm(point - other) >= spacing for other in chosen):
            chosen.append(point)
    return np.array(chosen)
