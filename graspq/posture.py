"""How good a hand's posture is: room in the joints' ranges, and what its Jacobian transmits.

Roa and Suárez: Grasp quality measures: review and performance, Autonomous Robots 38, 2015,
section 4, has these measures with their sources; SynGrasp (Malvezzi et al., IEEE Robotics and
Automation Magazine 22(4), 2015) publishes code for them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graspq.errors import GraspError, as_array

# Singular values below this share of the largest are zero.
RANK_TOLERANCE = 1e-10


def range_deviation(angles: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> float:
    """Return Σ ((θ - mid) / range)²: how far joints are from the middle of their ranges.

    0 where every joint is in the middle, a quarter of their number where every joint is at an end;
    low is good. It does not see the object.

    Args:
        angles: positions θ of the joints, shape (k,) [rad or m].
        lower: lower ends of their ranges, shape (k,), in the same units.
        upper: upper ends, shape (k,).

    Raises:
        GraspError: naming the argument whose shape or value is wrong, or an empty range.
    """
    position = as_array("angles", angles, (None,))
    low, high = (
        as_array(name, value, position.shape, "one value per joint")
        for name, value in (("lower", lower), ("upper", upper))
    )
    if not len(position):
        raise GraspError("angles: got no joint, expected shape (k,) with k >= 1")
    if (high <= low).any():
        k = int(np.argmax(high <= low))
        raise GraspError(
            f"upper: expected every entry above that of lower, got {high[k]} and {low[k]} at {k};"
            " leave joints without a range out"
        )
    return float((((position - 0.5 * (low + high)) / (high - low)) ** 2).sum())


def singularity_distance(jacobian: ArrayLike) -> float:
    """Return the smallest of the min(m, k) singular values of a Jacobian; high is good.

    0 in a singular posture: some joint speeds then move no contact, or some velocity of the
    contacts (for m <= k) cannot be made. Columns of zeros, of joints that move no contact, are
    left out.

    Args:
        jacobian: joint speeds to velocities, shape (m, k). Its unit is that of the result; rows of
            different units must have been divided by a length scale before.

    Raises:
        GraspError: where it is no finite matrix, or no joint moves anything.
    """
    return float(_singular_values(jacobian)[-1])


def manipulability(jacobian: ArrayLike) -> float:
    """Return √det(J Jᵀ), or √det(Jᵀ J) where J is taller than wide; high is good.

    The product of the min(m, k) singular values: the volume of the manipulability ellipsoid but for
    a constant (Yoshikawa: Manipulability of robotic mechanisms, Int. J. Robotics Research 4(2),
    1985). Columns of zeros are left out, so that grasps by different numbers of joints have
    different units and do not compare.

    Args:
        jacobian: as in ``singularity_distance``.

    Raises:
        GraspError: as in ``singularity_distance``.
    """
    return float(np.prod(_singular_values(jacobian)))


def transmission_uniformity(grasp_map: ArrayLike, jacobian: ArrayLike) -> float:
    """Return σmin / σmax of the hand-object Jacobian H = (G⁺)ᵀ J, in [0, 1]; high is good.

    H takes joint speeds to the object's velocity that fits the contacts' velocities best (least
    squares). 1: every joint motion moves the object alike; 0: some joint motion does not move it.
    σmin is the smallest of the min(6, k) singular values. Published code has the inverse, which is
    infinite in singular postures.

    Args:
        grasp_map: G, contact forces to wrenches, shape (6, m), moments divided by a length.
        jacobian: J, joint speeds to the velocities of the contacts along the same m components,
            shape (m, k). Columns of zeros are left out.

    Raises:
        GraspError: for shapes that do not fit, or where no joint moves anything.
    """
    forces = as_array("grasp_map", grasp_map, (6, None), "one column per contact force component")
    hint = "one row per column of grasp_map"
    motions = as_array("jacobian", jacobian, (forces.shape[1], None), hint)
    moving = _moving(motions)
    values = np.linalg.svd(np.linalg.pinv(forces).T @ moving, compute_uv=False)
    if values[0] <= RANK_TOLERANCE * np.linalg.norm(moving):
        return 0.0
    return float(values[-1] / values[0])


def _singular_values(jacobian: ArrayLike) -> np.ndarray:
    matrix = as_array("jacobian", jacobian, (None, None), "rows velocities, columns joints")
    values = np.linalg.svd(_moving(matrix), compute_uv=False)
    return np.where(values > RANK_TOLERANCE * values[0], values, 0.0)


def _moving(matrix: np.ndarray) -> np.ndarray:
    """The columns of the joints that move something."""
    moves = np.abs(matrix).max(axis=0, initial=0.0) > 0.0
    if not moves.any():
        raise GraspError(
            f"jacobian: got shape {matrix.shape} without an entry other than 0; give the contacts"
            " of links that joints move"
        )
    return matrix[:, moves]
