"""Contact forces that exert a given wrench with the least effort, as a quadratic program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact import Contact, tangent_basis
from graspq.errors import GraspError, as_array, as_number
from graspq.hand_bound import HandBound, points_of


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Forces of a grasp that add up to a wrench.

    Attributes:
        point_forces: per contact the force at each of its points, (p_i, 3) [N].
        torsions: moment about its normal of every contact, (n,) [N m].
        wrenches: wrench of every contact, (n, 6).
        motor_torque: load of the motors, (k,) [N m]; None without a ``HandBound``.
        effort: sum of the squared forces [N²].
    """

    point_forces: tuple[np.ndarray, ...]
    torsions: np.ndarray
    wrenches: np.ndarray
    motor_torque: np.ndarray | None
    effort: float


def contact_forces(
    grip: HandBound | Sequence[Contact],
    wrench: ArrayLike,
    edges: int = 12,
    *,
    torque_scale: float = 1.0,
    origin: ArrayLike = (0.0, 0.0, 0.0),
) -> ContactForces:
    """Return the contact forces of least effort Σ |f|² that exert ``wrench``; solved by OSQP.

    Every force stays inside its friction cone (``edges`` edges, inscribed). A ``HandBound``
    limits them by its motors; a list of contacts by each contact's ``max_normal_force``.
    A moment τ of a soft point contact counts as the force ``τ g*/τ*``.

    Args:
        grip: a hand, or contacts.
        wrench: what the contacts must exert together, shape (6,).
        edges: edges of the friction cones, at least 3.
        torque_scale: of ``wrench``, as in ``contact_wrenches``.
        origin: of ``wrench``, as in ``contact_wrenches``, shape (3,) [m].

    Raises:
        GraspError: when no forces exert the wrench, saying so, or for bad input.
    """
    import osqp
    from scipy.optimize import linprog
    from scipy.sparse import csc_matrix, identity

    contacts = grip.contacts if isinstance(grip, HandBound) else tuple(grip)
    if not contacts or not all(isinstance(c, Contact) for c in contacts):
        raise GraspError(f"grip: expected a HandBound or at least one Contact, got {grip!r}")
    if isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3:
        raise GraspError(f"edges: expected an integer >= 3, got {edges!r}")
    target = as_array("wrench", wrench, (6,))
    about = as_array("origin", origin, (3,))
    scale = as_number("torque_scale", torque_scale, positive=True)
    maps = [_maps(c, about, scale) for c in contacts]
    grasp = np.hstack([m for m, _ in maps])
    cones, limits, low, high = _limits(grip, contacts, maps, int(edges), grasp.shape[1])
    unit = max(float(np.linalg.norm(target[:3])), 1e-3)
    rows = np.abs(grasp).max(axis=1)
    rows[rows == 0] = 1.0
    balance, aim = grasp / rows[:, None], target / rows / unit
    a = np.vstack([balance, cones, limits])
    lower = np.concatenate([aim, np.full(len(cones), -np.inf), low / unit])
    upper = np.concatenate([aim, np.zeros(len(cones)), high / unit])
    bounded = np.isfinite(lower[6:])
    check = linprog(
        np.zeros(a.shape[1]),
        A_eq=balance,
        b_eq=aim,
        bounds=(None, None),
        method="highs",
        A_ub=np.vstack([a[6:], -a[6:][bounded]]),
        b_ub=np.concatenate([upper[6:], -lower[6:][bounded]]),
    )
    if check.status == 2:
        within = (
            "friction cones and motor torques"
            if isinstance(grip, HandBound)
            else ("friction cones and normal force limits")
        )
        raise GraspError(
            f"contact_forces: no forces inside the {within} exert this wrench; scale"
            " it down to what task_scaling allows"
        )
    solver = osqp.OSQP()
    solver.setup(
        identity(a.shape[1], format="csc"),
        np.zeros(a.shape[1]),
        csc_matrix(a),
        lower,
        upper,
        verbose=False,
        eps_abs=1e-9,
        eps_rel=1e-9,
        max_iter=200_000,
        polishing=True,
    )
    solver.warm_start(x=check.x)
    result = solver.solve(raise_error=False)
    x = np.asarray(result.x) * unit
    if (
        result.info.status_val not in (1, 2)
        or np.abs(balance @ x - target / rows).max() > 1e-5 * unit
    ):
        raise GraspError(
            f"contact_forces: OSQP stopped with '{result.info.status}'; the wrench is"
            " close to what the grasp can exert, scale it down"
        )
    return _unpack(grip, contacts, maps, x)


def _maps(contact: Contact, origin: np.ndarray, scale: float) -> tuple[np.ndarray, float]:
    """Wrench of the contact's variables (6, 3 p [+ 1]), and the moment per torsion variable."""
    blocks = []
    for point in points_of(contact):
        arm = point - origin
        cross = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
        blocks.append(np.vstack([np.eye(3), scale * cross]))
    ratio = 0.0
    if contact.patch is None and contact.max_torsion > 0 and contact.max_normal_force > 0:
        ratio = contact.max_torsion / contact.max_normal_force
        blocks.append(np.concatenate([np.zeros(3), scale * ratio * contact.normal])[:, None])
    return np.hstack(blocks), ratio


def _limits(
    grip: HandBound | Sequence[Contact],
    contacts: Sequence[Contact],
    maps: list[tuple[np.ndarray, float]],
    edges: int,
    width: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cone rows (<= 0), then rows between two bounds."""
    cones, limits, low, high = [], [], [], []
    angle = 2.0 * np.pi * np.arange(edges) / edges
    motors = np.zeros((len(grip.torque_limit) if isinstance(grip, HandBound) else 0, width))
    at = 0
    for i, (contact, (block, ratio)) in enumerate(zip(contacts, maps, strict=True)):
        a, b = tangent_basis(contact.normal)
        side = np.outer(np.cos(angle), a) + np.outer(np.sin(angle), b)
        side -= contact.friction * np.cos(np.pi / edges) * contact.normal
        points = (block.shape[1] - (1 if ratio else 0)) // 3
        total = np.zeros(width)
        for p in range(points):
            here = slice(at + 3 * p, at + 3 * p + 3)
            rows = np.zeros((edges + 1, width))
            rows[:edges, here] = side
            rows[edges, here] = -contact.normal
            total[here] = contact.normal
            if ratio:
                slope = contact.friction * np.cos(np.pi / edges)
                twin = rows.copy()
                rows[:edges, at + 3 * points] = slope
                twin[:edges, at + 3 * points] = -slope
                rows[edges, at + 3 * points] = 1.0
                twin[edges, at + 3 * points] = -1.0
                rows = np.vstack([rows, twin])
            cones.append(rows)
            if isinstance(grip, HandBound):
                motors[:, here] = grip.jacobians[i][p].T
        if isinstance(grip, HandBound) and ratio:
            spin = grip.spins[i]
            if spin is None:
                raise GraspError(f"jacobians[{i}]: torsion needs a (6, k) Jacobian")
            motors[:, at + 3 * points] = spin.T @ contact.normal * ratio
        if not isinstance(grip, HandBound):
            limits.append(total[None])
            low.append(0.0)
            high.append(contact.max_normal_force)
        at += block.shape[1]
    if isinstance(grip, HandBound):
        return np.vstack(cones), motors, grip.lower, grip.upper
    return np.vstack(cones), np.vstack(limits), np.array(low), np.array(high)


def _unpack(
    grip: HandBound | Sequence[Contact],
    contacts: Sequence[Contact],
    maps: list[tuple[np.ndarray, float]],
    x: np.ndarray,
) -> ContactForces:
    forces, torsions, wrenches = [], [], []
    load = np.zeros(len(grip.torque_limit)) if isinstance(grip, HandBound) else None
    at = 0
    for i, (contact, (block, ratio)) in enumerate(zip(contacts, maps, strict=True)):
        own = x[at : at + block.shape[1]]
        points = (len(own) - (1 if ratio else 0)) // 3
        forces.append(own[: 3 * points].reshape(points, 3))
        torsions.append(own[-1] * ratio if ratio else 0.0)
        wrenches.append(block @ own)
        if isinstance(grip, HandBound) and load is not None:
            load += np.einsum("pck,pc->k", grip.jacobians[i], forces[-1])
            spin = grip.spins[i]
            if ratio and spin is not None:
                load += spin.T @ contact.normal * torsions[-1]
        at += block.shape[1]
    return ContactForces(tuple(forces), np.array(torsions), np.array(wrenches), load, float(x @ x))
