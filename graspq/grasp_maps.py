"""The grasp map G from contact forces to a wrench, and measures by its singular values.

References:
    Z. Li and S. Sastry: Task-oriented optimal grasping by multifingered robot hands, IEEE J.
    Robotics and Automation 4(1), 1988 (smallest singular value, volume of the ellipsoid).
    B.-H. Kim, S.-R. Oh, B.-J. Yi and I. H. Suh: Optimal grasping based on non-dimensionalized
    performance indices, IROS 2001 (isotropy).
    M. A. Roa and R. Suárez: Grasp quality measures: review and performance, Autonomous Robots 38,
    2015, section 2.1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact_arrays import as_contacts, as_positions
from graspq.errors import GraspError, as_array, as_number


def grasp_map(
    positions: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    length: float = 1.0,
) -> np.ndarray:
    """Return the grasp map G, from contact forces to a wrench (force, moment / length).

    Every contact has three columns, the forces along the axes of the frame; with ``normals`` a
    fourth, the frictional moment about the normal (soft finger), in units of force × ``length``.
    Axes of each contact's own would turn the columns and leave the singular values as they are.

    Args:
        positions: contacts (n, 3) [m].
        normals: unit normals (n, 3), into or out of the object; None: hard fingers.
        origin: what moments are taken about, such as the centre of mass (3,) [m].
        length: what moments are divided by [m], so that all rows of G have one unit.

    Returns:
        (6, 3 n), or (6, 4 n) with normals, whose columns come in the order of the contacts.

    Raises:
        GraspError: for bad input.
    """
    if normals is None:
        places, axes = as_positions(positions), None
    else:
        places, axes = as_contacts(positions, normals)
    arms = (places - as_array("origin", origin, (3,))) / as_number("length", length, positive=True)
    columns = 3 if axes is None else 4
    blocks = np.zeros((len(places), 6, columns))
    blocks[:, :3, :3] = np.eye(3)
    x, y, z = arms.T
    blocks[:, 3, 1], blocks[:, 3, 2] = -z, y
    blocks[:, 4, 0], blocks[:, 4, 2] = z, -x
    blocks[:, 5, 0], blocks[:, 5, 1] = -y, x
    if axes is not None:
        blocks[:, 3:, 3] = axes
    return blocks.transpose(1, 0, 2).reshape(6, -1)


def smallest_singular_value(grasp_matrix: ArrayLike) -> float:
    """Return σmin(G): the wrench that unit contact forces exert in their weakest direction.

    High is good; 0: some wrench cannot be exerted at all, even by forces that pull (two hard
    fingers cannot turn the object about the line between them). It knows neither friction nor that
    contacts only push.

    Args:
        grasp_matrix: (6, k), from ``grasp_map``; also the wrenches of friction cone edges.

    Raises:
        GraspError: for bad input.
    """
    return float(_singular_values(grasp_matrix)[5])


def ellipsoid_volume(grasp_matrix: ArrayLike) -> float:
    """Return √det(G Gᵀ), the product of the singular values.

    The volume of the ellipsoid of wrenches that unit contact forces exert, over that of the unit
    ball. High is good. It grows with the number of contacts, and is blind as
    ``smallest_singular_value`` is. (``wrench_volume`` of Dex-Net is the square root of it.)

    Args:
        grasp_matrix: as ``smallest_singular_value``.

    Raises:
        GraspError: for bad input.
    """
    return float(np.prod(_singular_values(grasp_matrix)))


def isotropy(grasp_matrix: ArrayLike) -> float:
    """Return σmin(G) / σmax(G), from 0 to 1: 1 when unit forces exert a ball of wrenches.

    High is good; 0 where G is 0. It is blind as ``smallest_singular_value`` is, and depends on the
    length that moments are divided by.

    Args:
        grasp_matrix: as ``smallest_singular_value``.

    Raises:
        GraspError: for bad input.
    """
    values = _singular_values(grasp_matrix)
    return float(values[5] / values[0]) if values[0] > 0 else 0.0


def _singular_values(grasp_matrix: ArrayLike) -> np.ndarray:
    """The six singular values, largest first; 0 for those beyond the number of columns."""
    matrix = as_array("grasp_matrix", grasp_matrix, (6, None), "give grasp_map's result")
    if matrix.shape[1] == 0:
        raise GraspError("grasp_matrix: got no column, expected shape (6, k) with k >= 1")
    values = np.zeros(6)
    found = np.linalg.svd(matrix, compute_uv=False)
    values[: len(found)] = found
    # Round-off of a singular map is not a small value of it.
    values[values < 1e-14 * values[0]] = 0.0
    return values
