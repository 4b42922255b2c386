"""The grasp wrench space as an object: support, membership, facets, and 3-D pictures of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from graspq.errors import GraspError, as_array, as_choice
from graspq.inputs import as_bound, as_grasp, as_polytopes, pack
from graspq.scaling import task_scaling

if TYPE_CHECKING:
    import trimesh

PARTS = {"force": slice(0, 3), "moment": slice(3, 6)}
MOST_ROUNDS = 60


class WrenchSpace:
    """All wrenches that a grasp can exert (equations 4 and 5).

    Attributes:
        wrenches: the contacts' sets, as given.
        bound: "linf" or "l1".
        unloading: whether contacts may press with less than their limit.
    """

    def __init__(self, wrenches: Any, bound: str = "linf", unloading: bool = True) -> None:
        self.wrenches = as_grasp(wrenches)
        self.bound = as_bound(bound)
        self.unloading = bool(unloading)
        self._packed = pack(self.wrenches, self.bound, self.unloading)

    def support(self, directions: ArrayLike) -> np.ndarray:
        """Return h(u) = max u·w over the space, for (6,) a number, for (m, 6) shape (m,)."""
        from graspq._engines.bodies import support_values

        u = as_array("directions", np.atleast_2d(np.asarray(directions, float)), (None, 6))
        values = support_values(self._packed.body, u.T)
        return values[0] if np.ndim(directions) == 1 else values

    def contains(self, wrench: ArrayLike, tol: float = 1e-9) -> bool:
        """Return whether ``wrench`` (6,) lies in the space, within a relative ``tol``."""
        w = as_array("wrench", wrench, (6,))
        if not w.any():
            if self.unloading:
                return True
            return not task_scaling(self.wrenches, np.eye(6)[:1].T, self.bound, False).value < 0
        if self.unloading:
            return task_scaling(self.wrenches, w, self.bound, True).value >= 1.0 - tol
        from graspq._engines.bodies import span_of

        ray = w - span_of(self._packed.body).inner
        if not ray.any():
            return True
        moved = [
            np.hstack([v - v.mean(axis=1, keepdims=True)])
            for v in as_polytopes(self.wrenches, "contains without unloading")
        ]
        if self.bound == "l1":
            every = np.hstack(as_polytopes(self.wrenches, "contains without unloading"))
            moved = [every - every.mean(axis=1, keepdims=True)]
        return task_scaling(moved, ray, "linf", True).value >= 1.0 - tol

    def facets(self) -> tuple[np.ndarray, np.ndarray]:
        """Return unit normals (m, 6) and offsets (m,): the space is normals @ w <= offsets.

        Raises:
            GraspError: when the space is flat or has too many vertices for its hull.
        """
        from graspq._engines.qhull_check import product_hull

        hull = product_hull(as_polytopes(self.wrenches, "facets"), self.bound, self.unloading)
        if hull is None:
            raise GraspError("facets: the wrench space is flat")
        planes = np.unique(np.round(hull.equations, 9), axis=0)
        return planes[:, :6], -planes[:, 6]

    def projection(self, part: str = "force") -> trimesh.Trimesh:
        """Return the forces (or moments) of all wrenches, whatever the rest, as a mesh.

        Exact for polytopes; ellipsoids are drawn through their support points.
        """
        from scipy.spatial import ConvexHull, QhullError

        rows = PARTS[as_choice("part", part, tuple(PARTS))]
        sets = [self._drawn(i)[rows] for i in range(len(self.wrenches))]
        if self.unloading:
            sets = [np.hstack([s, np.zeros((3, 1))]) for s in sets]
        if self.bound == "l1":
            sets = [np.hstack(sets)]
        total = np.zeros((3, 1))
        for s in sets:
            total = (total[:, :, None] + s[:, None, :]).reshape(3, -1)
            try:
                total = total[:, ConvexHull(total.T).vertices]
            except QhullError:
                total = np.unique(np.round(total, 12), axis=1)
        return self._mesh(total.T, f"projection: the {part}s")

    def slice(self, part: str = "force", tol: float = 1e-9) -> trimesh.Trimesh:
        """Return the forces at zero moment (or moments at zero force) as a mesh.

        Planes are added where rays leave the space until every corner is inside; ``tol`` is
        the relative distance at which a corner counts as inside (ellipsoids take 1e-3).
        """
        from scipy.spatial import HalfspaceIntersection

        rows = PARTS[as_choice("part", part, tuple(PARTS))]
        tol = max(tol, 1e-3) if self._packed.smooth else tol
        planes = self._stops(np.vstack([np.eye(3), -np.eye(3)]), rows)[1]
        for _ in range(MOST_ROUNDS):
            faces = np.hstack([planes, -np.ones((len(planes), 1))])
            corners = HalfspaceIntersection(faces, np.zeros(3)).intersections
            corners = corners[np.isfinite(corners).all(axis=1)]
            reaches, found = self._stops(corners, rows)
            outside = reaches < 1.0 - tol
            if not outside.any():
                return self._mesh(corners, f"slice: the {part}s")
            planes = np.unique(np.vstack([planes, found[outside]]).round(12), axis=0)
        raise GraspError(f"slice: {len(planes)} planes were not enough; take a larger tol")

    def _stops(self, points: np.ndarray, rows: slice) -> tuple[np.ndarray, np.ndarray]:
        from graspq._engines.bodies import filled, span_of
        from graspq._engines.shooting import reaches

        if not self.unloading:
            raise GraspError("slice: needs unloading=True, so that the space holds the origin")
        packed, span = self._packed, span_of(self._packed.body)
        rays = np.zeros((6, len(points)))
        rays[rows] = points.T
        if span.rank < 6:
            scaled = rays / span.size[:, None]
            if np.abs(span.normals @ scaled).max() > 1e-9 * np.abs(scaled).max():
                raise GraspError("slice: it is flat, the contacts cannot exert every direction")
            packed = filled(packed, span)
        status, found, planes = reaches(packed.body, rays, 1e-6 if packed.smooth else 1e-12)
        if status.any():
            raise GraspError(
                "slice: the origin is not strictly inside it, so some directions"
                " cannot be exerted at all"
            )
        return found, planes[rows].T

    def _drawn(self, i: int) -> np.ndarray:
        w = self.wrenches[i]
        if isinstance(w, np.ndarray):
            return w
        k = np.arange(300) + 0.5
        polar, around = np.arccos(1 - 2 * k / 300), np.pi * (1 + 5**0.5) * k
        ball = np.stack(
            [np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)]
        )
        round_ = w.centres.T[:, :, None] + w.axes @ ball
        return np.hstack([np.hstack(list(round_)), w.points])

    @staticmethod
    def _mesh(points: np.ndarray, what: str) -> trimesh.Trimesh:
        import trimesh
        from scipy.spatial import ConvexHull, QhullError

        try:
            scale = float(np.abs(points).max())
            hull = ConvexHull(np.unique(np.round(points / scale, 10), axis=0) * scale)
        except (QhullError, ValueError) as error:
            raise GraspError(f"{what} are flat, there is no solid to draw") from error
        a, b, c = hull.points[hull.simplices].transpose(1, 0, 2)
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
        faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
        mesh = trimesh.Trimesh(hull.points, faces, process=False)
        mesh.remove_unreferenced_vertices()
        return mesh
