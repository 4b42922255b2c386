"""Task wrench sets (equation 8)."""

from __future__ import annotations

from typing import Any

import numpy as np

from graspq.contact import tangent_basis
from graspq.errors import GraspError, as_array, as_number


def gravity_tasks(
    mass: float,
    com: Any,
    gravity: Any,
    radius: float = 0.02 / 3,
    samples: int = 20,
    *,
    torque_scale: float = 1.0,
    origin: Any = (0.0, 0.0, 0.0),
) -> np.ndarray:
    """Return the wrenches that a hand must exert against gravity, shape (6, samples).

    Each is (force, moment about ``origin``) = (-m g, (c - origin) × (-m g)) with c a point
    near the centre of mass. The first c is the centre of mass itself, the others lie evenly
    on the circle of ``radius`` around it in the plane across gravity. A ball is no harder
    than its disc (an offset along gravity has no moment) and a disc no harder than its rim
    (a wrench set is convex), so the samples are spent where they can decide.

    Args:
        mass: mass of the object [kg], > 0.
        com: centre of mass, shape (3,) [m].
        gravity: gravitational acceleration in the same frame, shape (3,) [m/s²], not 0.
        radius: uncertainty of the centre of mass [m]; 0 puts every sample on it.
        samples: number of wrenches, at least 1.
        torque_scale: factor on every moment.
        origin: point that moments are taken about, shape (3,) [m].
    """
    kilograms = as_number("mass", mass, positive=True)
    centre = as_array("com", com, (3,))
    field = as_array("gravity", gravity, (3,))
    strength = float(np.linalg.norm(field))
    if strength == 0.0:
        raise GraspError("gravity: got the zero vector; without gravity there is no task")
    reach = as_number("radius", radius)
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or samples < 1:
        raise GraspError(f"samples: expected an integer >= 1, got {samples!r}")
    scale = as_number("torque_scale", torque_scale, positive=True)
    about = as_array("origin", origin, (3,))
    a, b = tangent_basis(field / strength)
    angle = 2.0 * np.pi * np.arange(samples - 1) / max(samples - 1, 1)
    points = np.vstack(
        [centre, centre + reach * (np.outer(np.cos(angle), a) + np.outer(np.sin(angle), b))]
    )
    force = np.tile(-kilograms * field, (samples, 1))
    moment = scale * np.cross(points - about, force)
    return np.vstack([force.T, moment.T])
