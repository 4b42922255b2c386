"""Corners of an object's surface, of which its flat parts are the convex hulls."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim.objects.collision_shape import shapes_of

_INSIDE = 1e-6  # deeper than that in another shape, a corner is not on the surface [m]
_SAME_NORMAL = 5  # decimals by which normals of one face are alike


class SurfaceCorners(NamedTuple):
    """Corners of the flat parts of a surface; one of several parts is there several times.

    Attributes:
        positions: in the object's frame (n, 3) [m].
        normals: unit normals into the object, of the part (n, 3).
    """

    positions: np.ndarray
    normals: np.ndarray


def corners_of(model: mujoco.MjModel) -> SurfaceCorners:
    """Corners of the shapes of a model of one object that collide, in the order of its geoms.

    Round shapes count as prisms with 64 sides. Corners inside another shape of the object are not
    on its surface.

    Args:
        model: of one body.
    """
    from scipy.spatial import ConvexHull  # a fifth of a second, which most processes do not need

    hulls = [ConvexHull(points) for _, points in shapes_of(model)]
    found = []
    for k, hull in enumerate(hulls):
        places = hull.points[hull.simplices].reshape(-1, 3)
        normals = np.repeat(-hull.equations[:, :3], 3, axis=0)
        keys = np.column_stack([hull.simplices.reshape(-1), normals.round(_SAME_NORMAL) + 0.0])
        _, rows = np.unique(keys, axis=0, return_index=True)
        rows.sort()
        for other in hulls[:k] + hulls[k + 1 :]:
            depth = places[rows] @ other.equations[:, :3].T + other.equations[:, 3]
            rows = rows[depth.max(axis=1) > -_INSIDE]
        found.append((places[rows], normals[rows]))
    return SurfaceCorners(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
