"""The surface of a known object: its normal where a finger touches it."""

from __future__ import annotations

import mujoco
import numpy as np

_PROBE_RADIUS = 1e-4  # [m]
_FARTHEST = 0.5  # objects are smaller than that [m]


class ObjectSurface:
    """Surface of an object's collision shapes.

    Args:
        shape: the object as a model of one body ``object``.
    """

    def __init__(self, shape: mujoco.MjSpec) -> None:
        spec = mujoco.MjSpec()
        spec.worldbody.add_geom(
            name="probe", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_PROBE_RADIUS, 0.0, 0.0]
        )
        frame = spec.worldbody.add_frame()
        spec.attach(shape, prefix="object/", frame=frame)
        self._model = model = spec.compile()
        self._data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, self._data)
        body = model.body("object/object").id
        self._position = self._data.xpos[body].copy()
        self._rotation = self._data.xmat[body].reshape(3, 3).copy()
        self._probe = model.geom("probe").id
        colliding = np.flatnonzero(model.geom_contype)
        self._shapes = [int(geom) for geom in colliding if geom != self._probe]

    def inward_normals(self, points: np.ndarray) -> np.ndarray:
        """Unit normals into the object (n, 3) at the points of its surface nearest to given points.

        Args:
            points: in the object's frame (n, 3) [m], inside or outside.

        Returns:
            in the object's frame; zero for a point on the surface itself.
        """
        return np.array([self._normal(point) for point in np.asarray(points, dtype=float)])

    def _normal(self, point: np.ndarray) -> np.ndarray:
        """Unit normal into the object (3,) at the point of its surface nearest to one (3,) [m]."""
        model, data = self._model, self._data
        data.geom_xpos[self._probe] = at = self._position + self._rotation @ point
        nearest, found = np.inf, np.zeros(3)
        ends = np.empty(6)
        for shape in self._shapes:
            distance = mujoco.mj_geomDistance(model, data, self._probe, shape, _FARTHEST, ends)
            if distance < nearest:
                toward = ends[3:] - at
                nearest, found = distance, toward if distance > -_PROBE_RADIUS else -toward
        length = float(np.linalg.norm(found))
        return self._rotation.T @ found / length if length > 0.0 else found
