"""Geoms and meshes of users' objects in the form that those of built-in objects have."""

from __future__ import annotations

import mujoco
import numpy as np

from sdh_sim.errors import MjcfError
from sdh_sim.objects.contact_settings import COLLISION_GROUP, CONTACT, VISUAL_GROUP


def set_surface(
    mesh: mujoco.MjsMesh, vertices: np.ndarray, faces: np.ndarray, inertia: mujoco.mjtMeshInertia
) -> None:
    """Give a mesh its vertices (n, 3) [m] and triangles (m, 3), and what its inertia is of."""
    mesh.uservert = vertices.astype(np.float32).reshape(-1)
    mesh.userface = faces.astype(np.int32).reshape(-1)
    mesh.inertia = inertia


def collides(geom: mujoco.MjsGeom) -> bool:
    """Whether a geom touches anything."""
    return bool(geom.contype or geom.conaffinity)


def set_roles(spec: mujoco.MjSpec, friction: float) -> int:
    """Make every geom visual or colliding, as those of built-in objects are.

    Args:
        spec: the object; changed in place.
        friction: Coulomb's coefficient of what collides.

    Returns:
        the number of collision shapes.

    Raises:
        MjcfError: nothing collides.
    """
    colliding = [geom for geom in spec.geoms if collides(geom)]
    if not colliding:
        raise MjcfError("has no geom that touches anything (all have contype 0, conaffinity 0)")
    # Collision shapes are hidden where visual ones show the object.
    hidden = len(colliding) < len(spec.geoms)
    for geom in spec.geoms:
        if geom in colliding:
            for name, value in CONTACT.items():
                setattr(geom, name, value)
            geom.friction = (friction, 0.005, 0.0001)
            geom.group = COLLISION_GROUP if hidden else VISUAL_GROUP
        else:
            geom.group = VISUAL_GROUP
            geom.mass = 0.0
    return len(colliding)
