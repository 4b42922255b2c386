"""ε and V from qhull on every sum of vertices: slow, and independent of the rest.

The hull of the product of the contacts' vertices is how most grasp software builds the wrench space
(Ferrari, Canny: Planning optimal grasps, 1992; Miller, Allen: GraspIt!, 2004); qhull: Barber,
Dobkin, Huhdanpaa: The Quickhull algorithm for convex hulls, 1996. Tests and benchmarks use it.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from graspq.errors import GraspError
from graspq.inputs import as_bound, as_polytopes

# Beyond so many sums in six dimensions qhull takes minutes and gigabytes.
MOST_POINTS = 60_000
# Spaces thinner than this share of their width are flat; distances below it are 0.
FLAT = 1e-9


def product_epsilon(wrenches: Any, bound: str = "linf", unloading: bool = True) -> float:
    """Return the radius ε of the largest ball around the origin inside the wrench space.

    0.0 when the origin is not strictly inside. Force and moment are weighed as they come in
    ``wrenches``: one newton beside one (scaled) newton metre, about their own origin.
    """
    hull = product_hull(as_polytopes(wrenches, "the hull"), as_bound(bound), unloading)
    if hull is None:
        return 0.0
    distance, scale = -hull.equations[:, -1], np.abs(hull.points).max()
    nearest = float(distance.min())
    return nearest if nearest > FLAT * scale else 0.0


def product_volume(wrenches: Any, bound: str = "linf", unloading: bool = True) -> float:
    """Return the six-dimensional volume of the grasp wrench space; 0.0 when it is flat."""
    hull = product_hull(as_polytopes(wrenches, "the hull"), as_bound(bound), unloading)
    return 0.0 if hull is None else float(hull.volume)


def product_hull(grasp: list[np.ndarray], bound: str, unloading: bool) -> Any:
    """qhull's hull of a grasp, or None when it is flat."""
    from scipy.spatial import ConvexHull

    if unloading:
        grasp = [np.hstack([w, np.zeros((6, 1))]) for w in grasp]
    if bound == "l1":
        points = np.hstack(grasp).T
    else:
        count = int(np.prod([w.shape[1] for w in grasp], dtype=float))
        if count > MOST_POINTS:
            raise GraspError(
                f"wrenches: the sum of the contacts' sets has {count} points, more"
                f" than {MOST_POINTS}; take fewer edges or contacts"
            )
        points = np.array([sum(c) for c in itertools.product(*[list(w.T) for w in grasp])])
    points = np.unique(points, axis=0)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(spread) < 6 or spread[5] <= FLAT * spread[0]:
        return None
    return ConvexHull(points)
