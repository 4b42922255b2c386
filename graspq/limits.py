"""What one contact can exert, from joint torque limits and tactile readings (eq. 6 and 7)."""

from __future__ import annotations

from typing import Any

import numpy as np

from graspq.errors import GraspError, as_array, as_number, as_unit


def max_normal_force(jacobian: Any, normal: Any, torque_limit: Any) -> float:
    """Return the largest normal force g* [N] within the joint torque limits (equation 6).

    The linear program max g subject to -τ̄ <= Jᵀ n g <= τ̄ has the closed form
    g* = min over joints of τ̄_k / |(Jᵀ n)_k|.

    Args:
        jacobian: translational Jacobian of the contact point, shape (3, k) [m / rad].
        normal: unit contact normal in the Jacobian's frame, shape (3,).
        torque_limit: largest joint torques τ̄, shape (k,) [N m].

    Raises:
        GraspError: for bad shapes, a negative limit, or when no joint is loaded by the force
            (the structure carries it and g* has no bound).
    """
    jacobian = as_array("jacobian", jacobian, (3, None))
    normal = as_unit("normal", normal)
    limit = as_array("torque_limit", torque_limit, (jacobian.shape[1],))
    if (limit < 0).any():
        raise GraspError(f"torque_limit: expected values >= 0, got {limit.min()}")
    load = np.abs(jacobian.T @ normal)
    # A lever arm below a nanometre-sized share of the Jacobian is round-off, not a joint.
    loaded = load > 1e-12 * max(1e-3, float(np.abs(jacobian).max(initial=0.0)))
    if not loaded.any():
        raise GraspError(
            "jacobian: no joint is loaded by a force along the normal, so the"
            " normal force has no bound; check the normal and the frame"
        )
    return float((limit[loaded] / load[loaded]).min())


def max_torsion(friction: float, g: float, pressures: Any, taxels: Any, centre: Any) -> float:
    """Return the largest frictional moment about the normal τ* [N m] (equation 7).

    τ* = (μ g* / Σ ĝ) Σ ĝ(x, y) l(x, y), with l the distance of a taxel from the centre.

    Args:
        friction: friction coefficient μ.
        g: largest normal force g* [N].
        pressures: tactile readings ĝ >= 0, shape (k,); only their ratios matter.
        taxels: taxel centres, shape (k, 3) [m], projected onto the tangent plane.
        centre: pressure-weighted centre of the contact, shape (3,) [m].
    """
    mu = as_number("friction", friction)
    force = as_number("g", g)
    readings = as_array("pressures", pressures, (None,))
    points = as_array("taxels", taxels, (len(readings), 3))
    middle = as_array("centre", centre, (3,))
    if (readings < 0).any():
        raise GraspError(f"pressures: expected values >= 0, got {readings.min()}")
    total = float(readings.sum())
    if total == 0.0:
        raise GraspError("pressures: their sum is 0; a contact needs at least one reading > 0")
    distance = np.linalg.norm(points - middle, axis=1)
    return float(mu * force * (readings @ distance) / total)
