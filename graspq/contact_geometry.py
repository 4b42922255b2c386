"""Where the contacts lie: distance from the centre of mass, area and shape of their polygon.

References:
    M. A. Roa and R. Suárez: Grasp quality measures: review and performance, Autonomous Robots 38,
    2015, section 2.2, with D. Ding, Y.-H. Lee and S. Wang: Computation of 3-D form-closure grasps,
    IEEE T-RA 17(4), 2001 (distance); B. Mirtich and J. Canny: Easily computable optimum grasps in
    2-D and 3-D, ICRA 1994 (area); Y. C. Park and G. P. Starr: Grasp synthesis of polygonal objects
    using a three-fingered robot hand, IJRR 11(3), 1992 (angles).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact_arrays import as_positions
from graspq.errors import as_array

# Points whose polygon has less than this share of their spread as area lie on a line.
FLAT = 1e-12


class _Polygon(NamedTuple):
    """Convex polygon of contacts in their plane.

    Attributes:
        corners: counter-clockwise (k, 2) [m].
        area: [m²].
    """

    corners: np.ndarray
    area: float


def centroid_distance(positions: ArrayLike, centre: ArrayLike = (0.0, 0.0, 0.0)) -> float:
    """Return the distance of the contacts' centroid from the centre of mass [m].

    Low is good: weight and inertia then have short arms. It sees neither normals nor friction,
    nor on which side of the contacts the weight hangs.

    Args:
        positions: contacts (n, 3) [m].
        centre: centre of mass, same frame (3,) [m].

    Raises:
        GraspError: for bad input.
    """
    offset = as_positions(positions).mean(axis=0) - as_array("centre", centre, (3,))
    return float(np.linalg.norm(offset))


def contact_area(positions: ArrayLike) -> float:
    """Return the area of the contacts' polygon [m²]: the triangle of three contacts.

    More than three contacts are projected onto the plane nearest to them (least squares), and the
    area is that of their convex hull there. Fewer than three, or contacts on a line, have none: 0.
    High is good: a larger polygon resists larger moments with the same forces. It sees neither
    normals nor friction, nor how large the object is.

    Args:
        positions: contacts (n, 3) [m].

    Raises:
        GraspError: for bad input.
    """
    polygon = _polygon(as_positions(positions))
    return 0.0 if polygon is None else polygon.area


def contact_shape(positions: ArrayLike) -> float:
    """Return how far the inner angles of the contacts' polygon are from equal, from 0 to 1.

    The sum of |θ - θ̄| over the polygon of ``contact_area`` with k corners, θ̄ = π (k - 2) / k (60°
    for three), divided by its largest value, that of a polygon folded to a line: two angles of 0
    and the others π. Low is good; 0: regular. Fewer than three contacts, or contacts on a line,
    have the worst, 1. Contacts inside the hull of the others do not count.

    Args:
        positions: contacts (n, 3) [m].

    Raises:
        GraspError: for bad input.
    """
    polygon = _polygon(as_positions(positions))
    if polygon is None:
        return 1.0
    before = np.roll(polygon.corners, 1, axis=0) - polygon.corners
    after = np.roll(polygon.corners, -1, axis=0) - polygon.corners
    cross = after[:, 0] * before[:, 1] - after[:, 1] * before[:, 0]
    angles = np.arctan2(cross, (before * after).sum(axis=1))
    count = len(angles)
    even = np.pi * (count - 2) / count
    worst = (count - 2) * (np.pi - even) + 2 * even
    return float(np.abs(angles - even).sum() / worst)


def _polygon(places: np.ndarray) -> _Polygon | None:
    """Convex hull of contacts in the plane nearest to them; None: they have none."""
    from scipy.spatial import ConvexHull, QhullError

    if len(places) < 3:
        return None
    offsets = places - places.mean(axis=0)
    _, sizes, axes = np.linalg.svd(offsets, full_matrices=False)
    if sizes[1] <= FLAT * sizes[0]:
        return None
    flat = offsets @ axes[:2].T
    try:
        hull = ConvexHull(flat)
    except QhullError:
        return None
    return _Polygon(flat[hull.vertices], float(hull.volume))
