"""What the contacts' best forces leave of a wrench, as BODex and GraspQP rate grasps.

The sign of the normals does not matter as long as all point to the same side of the surface:
``graspq.Contact`` and DexGraspBench have them into the object (MuJoCo's normal, from the hand's
geom to the object's).

References:
    J. Chen, Y. Ke and H. Wang: BODex: scalable and efficient robotic dexterous grasp synthesis
    using bilevel optimization, ICRA 2025, arXiv 2412.16490; DexGraspBench, of the same group.
    R. Zurbrügg, A. Cramariuc and M. Hutter: GraspQP: differentiable optimization of force closure
    for diverse and robust dexterous grasping, CoRL 2025.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graspq._engines.nearest_point import nearest_point
from graspq.contact_arrays import (
    ContactArrays,
    as_coefficients,
    as_contacts,
    tangents_from_y,
)
from graspq.errors import GraspError, as_array, as_choice, as_number

# Load of the six directions, over the largest normal force of a contact.
LOAD = 0.1

SPAN_TARGETS = ("axes", "zero")
SPAN_SHIFT = 1e-2
SPAN_FACTOR = 2.0
# Singular values below this share of the largest are 0; their sixth root would not be small.
ROUND_OFF = 1e-14


def qp_residual(
    positions: ArrayLike,
    normals: ArrayLike,
    friction: ArrayLike,
    torsion: ArrayLike = 0.0,
) -> float:
    """Return the QP residual of BODex as DexGraspBench has it; low is good.

    The mean, over forces of 0.1 along ± x, y, z through the contacts' mean, of the norm of what the
    contacts leave of it, |Σ w_i + (f, 0)|. Each contact exerts a combination of six wrenches of
    unit normal force: four edges of the friction pyramid, and normal force with ± torsion. Its
    weights are >= 0 and add up to at most 1, those of all contacts to at least 1. Moments [N m]
    stand beside forces [N] as they are, so those on an object of a hand's size hardly count. The
    axes of the pyramid follow from the y axis of the frame: a turned frame gives slightly other
    values. It does not see the object's weight or the hand's limits. The quadratic programs are
    solved to round-off (Wolfe's nearest point), where interior points leave about 1e-7.

    DexGraspBench takes half the true coefficients, to leave a margin.

    Args:
        positions: contacts (n, 3) [m].
        normals: unit normals (n, 3), all into the object or all out of it.
        friction: coefficient of friction, one or one per contact.
        torsion: largest moment about the normal over the normal force [m], one or one per contact.

    Raises:
        GraspError: for bad input.
    """
    contacts = as_contacts(positions, normals)
    wrenches = _pyramids(contacts, friction, torsion)
    loads = np.hstack([LOAD * np.vstack([np.eye(3), -np.eye(3)]), np.zeros((6, 3))])
    return float(np.mean([_residual(wrenches, load) for load in loads]))


def qp_dfc_residual(
    positions: ArrayLike,
    normals: ArrayLike,
    friction: ArrayLike,
    torsion: ArrayLike = 0.0,
) -> float:
    """Return the QP-DFC residual of DexGraspBench: ``qp_residual`` without a load; low is good.

    The smallest norm of a wrench that contacts which press exert together; 0: they can balance
    each other. Arguments, errors and what it is blind to are as for ``qp_residual``.
    """
    contacts = as_contacts(positions, normals)
    return _residual(_pyramids(contacts, friction, torsion), np.zeros(6))


def _pyramids(contacts: ContactArrays, friction: ArrayLike, torsion: ArrayLike) -> np.ndarray:
    """Six wrenches of unit normal force for every contact about the contacts' mean (n, 6, 6)."""
    places, normals = contacts
    count = len(places)
    side = as_coefficients("friction", friction, count)[:, None]
    twist = as_coefficients("torsion", torsion, count)[:, None]
    first, second = tangents_from_y(normals)
    sides = (side * first, -side * first, side * second, -side * second, 0.0 * first, 0.0 * first)
    forces = normals[:, None] + np.stack(sides, axis=1)
    moments = np.cross((places - places.mean(axis=0))[:, None], forces)
    moments[:, 4] += twist * normals
    moments[:, 5] -= twist * normals
    return np.concatenate([forces, moments], axis=2)


def _residual(wrenches: np.ndarray, load: np.ndarray) -> float:
    """Smallest norm of the contacts' wrench plus a load (6,)."""
    each = np.arange(len(wrenches))

    def farthest(direction: np.ndarray) -> np.ndarray:
        reach = wrenches @ direction
        best = reach.argmax(axis=1)
        pressing = reach[each, best] > 0
        if not pressing.any():  # some contact has to press all the same
            pressing[np.argmax(reach[each, best])] = True
        return wrenches[each[pressing], best[pressing]].sum(axis=0) + load

    return float(np.linalg.norm(nearest_point(farthest, farthest(np.zeros(6)))))


def span_loss(
    positions: ArrayLike,
    normals: ArrayLike,
    friction: float = 0.2,
    *,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    targets: str = "axes",
    torque_weight: float = 5.0,
    largest_weight: float = 50.0,
    svd_gain: float = 0.1,
) -> float:
    """Return GraspQP's span metric; low is good.

    2 (r̄ + 0.01) exp(-gain s), with r̄ the mean of half the squared residual of the contacts' cone
    edges F against target wrenches, and s the sixth root of the product of F's singular values.

    - ``targets="axes"``: ± unit wrenches along the six axes, edge weights from 0 to
      ``largest_weight``: what the contacts can exert.
    - ``targets="zero"``: no wrench, weights from 1 to 1 + ``largest_weight``: whether they can
      balance each other while all press, what the authors generate grasps with by default.

    Every contact has four edges √(1 - μ²) n ± μ t, a quarter each. The tangents t are made from the
    direction (1, 1, 1) and keep the length that the cross product with it gives them: friction is
    less than μ where the normal comes near that direction, and a turned frame gives other values.
    It does not see limits of forces or weight. The residual is solved exactly, which the authors'
    fast solver does not (their SciPy solver does).

    Args:
        positions: contacts (n, 3) [m].
        normals: unit normals (n, 3), all into the object or all out of it. (The tangents of normals
            within 26° of (1, 1, 1) are others than those of the reversed ones.)
        friction: μ, at most 1.
        centre: what moments are taken about (3,) [m].
        targets: "axes" or "zero".
        torque_weight: factor on moments [1/m].
        largest_weight: of an edge; the default is the class's, the authors' script gives 20.
        svd_gain: gain of the singular values' term.

    Raises:
        GraspError: for bad input.
    """
    contacts = as_contacts(positions, normals)
    mu = as_number("friction", friction)
    if mu > 1.0:
        raise GraspError(f"friction: span_loss needs a number <= 1, got {mu:g}")
    as_choice("targets", targets, SPAN_TARGETS)
    most = as_number("largest_weight", largest_weight, positive=True)
    gain = as_number("svd_gain", svd_gain)
    arms = contacts.positions - as_array("centre", centre, (3,))
    weight = as_number("torque_weight", torque_weight, positive=True)
    edges = _span_edges(contacts.normals, mu)
    moments = weight * np.cross(arms[:, None], edges)
    columns = np.concatenate([edges, moments], axis=2).reshape(-1, 6).T
    if targets == "zero":
        residuals = [_box_residual(columns, np.zeros(6), 1.0, 1.0 + most)]
    else:
        aims = np.vstack([np.eye(6), -np.eye(6)])
        residuals = [_box_residual(columns, aim, 0.0, most) for aim in aims]
    values = np.zeros(6)
    found = np.linalg.svd(columns, compute_uv=False)
    values[: len(found)] = np.where(found > ROUND_OFF * found[0], found, 0.0)
    spread = float(np.prod(values) ** (1.0 / 6.0))
    mean = float(np.mean([0.5 * r * r for r in residuals]))
    return SPAN_FACTOR * (mean + SPAN_SHIFT) * float(np.exp(-gain * spread))


def _span_edges(normals: np.ndarray, friction: float) -> np.ndarray:
    """A quarter of each of GraspQP's cone edges (n, 4, 3)."""
    base = np.full(normals.shape, 1.0 / np.sqrt(3.0))
    near = (base * normals).sum(axis=1) / (np.linalg.norm(normals, axis=1) + 1e-6) > 0.9
    base[near, 1] -= 2.0
    first = np.cross(normals, base)
    second = np.cross(normals, first)
    push = np.sqrt(1.0 - friction**2) * normals
    edges = [push + friction * t for t in (first, second, -first, -second)]
    return np.stack(edges, axis=1) / 4.0


def _box_residual(columns: np.ndarray, aim: np.ndarray, low: float, high: float) -> float:
    """Smallest norm of columns @ x - aim over low <= x <= high."""

    def farthest(direction: np.ndarray) -> np.ndarray:
        return columns @ np.where(direction @ columns > 0, high, low) - aim

    return float(np.linalg.norm(nearest_point(farthest, farthest(aim))))
