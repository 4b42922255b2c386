"""A contact's wrench set with its exact friction ellipsoid (equation 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graspq.errors import GraspError, as_array


@dataclass(frozen=True, eq=False, init=False)
class EllipsoidSet:
    """The convex hull of ellipsoids and points in wrench space, by its support function.

    What ``contact_wrenches(contact, edges=None)`` returns; ``task_scaling``, ``epsilon`` and
    ``is_force_closure`` take it in place of an array of vertices.

    Attributes:
        centres: centres of the ellipsoids, shape (6, m).
        axes: ellipsoid k is ``centres[:, k] + axes[k] @ x`` over ``|x| <= 1``, shape (m, 6, 3).
        points: further points of the set, shape (6, k).
    """

    centres: np.ndarray
    axes: np.ndarray
    points: np.ndarray

    def __init__(
        self, centres: ArrayLike, axes: ArrayLike, points: ArrayLike | None = None
    ) -> None:
        values = {
            "centres": as_array("centres", centres, (6, None)),
            "axes": as_array("axes", axes, (None, 6, 3)),
            "points": as_array("points", np.zeros((6, 0)) if points is None else points, (6, None)),
        }
        if values["centres"].shape[1] != len(values["axes"]):
            raise GraspError(
                f"axes: expected one per centre, got {len(values['axes'])} for"
                f" {values['centres'].shape[1]} centres"
            )
        for name, value in values.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def size(self) -> int:
        """Number of ellipsoids and points."""
        return self.centres.shape[1] + self.points.shape[1]

    def support(self, direction: ArrayLike) -> float:
        """Return h(u) = max over the set of u·w, for u of shape (6,)."""
        u = as_array("direction", direction, (6,))
        reach = u @ self.centres + np.linalg.norm(np.einsum("r,krc->kc", u, self.axes), axis=1)
        return float(np.concatenate([reach, u @ self.points]).max())
