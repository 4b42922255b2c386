"""Poses in which an object rests on a plane.

A rigid body rests on a facet of its convex hull when its centre of mass lies over that facet
(Goldberg et al., International Journal of Robotics Research 18(10), 1999).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

COPLANAR = 1e-3  # angle between triangles of one facet, at most [rad]
LEVEL = 1e-5  # points so near to a facet's plane belong to it [m]


@dataclass(frozen=True)
class StablePose:
    """A facet of the hull that the object can rest on.

    Attributes:
        down: the facet's outward normal, in the frame of the points (3,).
        tilt: angle between that and the direction asked for [rad].
        height: of the centre of mass over the facet [m].
    """

    down: np.ndarray
    tilt: float
    height: float


def stable_poses(points: np.ndarray, com: np.ndarray, down: np.ndarray) -> Iterator[StablePose]:
    """Every pose in which an object rests, the least tilted first, of these the lowest.

    Args:
        points: that span the object (n, 3) [m]; not all in a plane.
        com: its centre of mass (3,) [m].
        down: unit vector from which the tilt counts (3,).
    """
    from scipy.spatial import (  # a fifth of a second, which most processes do not need
        ConvexHull,
        QhullError,
    )

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return
    corners, normals = points[hull.vertices], hull.equations[:, :3]
    tilt = np.arccos(np.clip(normals @ down, -1.0, 1.0))
    height = -(normals @ com + hull.equations[:, 3])
    area, below = _triangles_below(points[hull.simplices], normals, com)
    left = below.copy()
    for row in np.lexsort((-area, np.round(height, 5), np.round(tilt, 3))):
        if not left[row]:
            continue
        facet = normals @ normals[row] > np.cos(COPLANAR)
        left &= ~facet
        # Of coplanar triangles the largest has the most exact normal.
        best = int(np.argmax(np.where(facet, area, 0.0)))
        depth = corners @ normals[best]
        on_facet = corners[depth >= depth.max() - LEVEL]
        if margin_within(on_facet, com, normals[best]) > 0.0:
            yield StablePose(
                normals[best], float(tilt[best]), float(depth.max() - com @ normals[best])
            )


def _triangles_below(
    triangles: np.ndarray, normals: np.ndarray, com: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Twice the areas (n,) of triangles, and over which of them a point lies (n,).

    Args:
        triangles: corners (n, 3, 3) [m].
        normals: outward (n, 3).
        com: the point (3,) [m].
    """
    a, b, c = triangles.swapaxes(0, 1)
    cross = np.cross(b - a, c - a)
    turn = np.sign((cross * normals).sum(axis=1))
    below = np.ones(len(triangles), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        inside = turn * (np.cross(side, com - start) * normals).sum(axis=1)
        below &= inside >= -LEVEL * np.linalg.norm(side, axis=1)
    return np.linalg.norm(cross, axis=1), below


def margin_within(facet: np.ndarray, com: np.ndarray, down: np.ndarray) -> float:
    """How far inside an area the centre of mass lies, seen along a direction [m].

    Args:
        facet: points that span the area (n, 3) [m].
        com: centre of mass (3,) [m].
        down: unit vector normal to the area (3,).

    Returns:
        distance from the nearest side of the area; negative outside, or where it is a line or a
        point.
    """
    first = np.cross(down, np.eye(3)[int(np.argmin(np.abs(down)))])
    first /= np.linalg.norm(first)
    plane = np.stack((first, np.cross(down, first)), axis=1)
    from scipy.spatial import ConvexHull, QhullError

    try:
        border = ConvexHull(facet @ plane).equations
    except (QhullError, ValueError):
        return -np.inf
    return float(-(border[:, :2] @ (com @ plane) + border[:, 2]).max())
