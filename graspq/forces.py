"""Contact forces that exert a given wrench with the least effort, as a quadratic program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact import Contact, tangent_basis
from graspq.errors import GraspError, as_array, as_number
from graspq.hand_bound import HandBound, intervals_of, motions_of, points_of

# OSQP stops at this tolerance, in units of the wrench's force; what it then lacks in balance is
# checked against the second. Its status 1 is solved, 2 solved within a wider tolerance.
OSQP_TOLERANCE, BALANCE_TOLERANCE = 1e-9, 1e-5
OSQP_SOLVED = (1, 2)
# Wrenches without a force are taken in units of this force [N].
SMALLEST_UNIT = 1e-3


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
    from scipy.sparse import csc_matrix, diags

    contacts = grip.contacts if isinstance(grip, HandBound) else tuple(grip)
    if not contacts or not all(isinstance(c, Contact) for c in contacts):
        raise GraspError(f"grip: expected a HandBound or at least one Contact, got {grip!r}")
    if isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3:
        raise GraspError(f"edges: expected an integer >= 3, got {edges!r}")
    target = as_array("wrench", wrench, (6,))
    about = as_array("origin", origin, (3,))
    scale = as_number("torque_scale", torque_scale, positive=True)
    maps = [_maps(c, about, scale) for c in contacts]
    grasp = np.hstack([block for block, _ in maps])
    cones, limits, low, high = _limits(grip, contacts, maps, int(edges), grasp.shape[1])
    # Motor torques that load no joint are variables too, at no cost.
    free = limits.shape[1] - grasp.shape[1]
    grasp = np.hstack([grasp, np.zeros((6, free))])
    cones = np.hstack([cones, np.zeros((len(cones), free))])
    unit = max(float(np.linalg.norm(target[:3])), SMALLEST_UNIT)
    rows = np.abs(grasp).max(axis=1)
    rows[rows == 0] = 1.0
    balance, aim = grasp / rows[:, None], target / rows / unit
    start = _feasible(balance, aim, cones, limits, low / unit, high / unit)
    if start is None:
        within = "motor torques" if isinstance(grip, HandBound) else "normal force limits"
        raise GraspError(
            f"contact_forces: no forces inside the friction cones and {within} exert this"
            " wrench; scale it down to what task_scaling allows"
        )
    a = np.vstack([balance, cones, limits])
    cost = np.concatenate([np.ones(a.shape[1] - free), np.zeros(free)])
    solver = osqp.OSQP()
    solver.setup(
        diags(cost, format="csc"),
        np.zeros(a.shape[1]),
        csc_matrix(a),
        np.concatenate([aim, np.full(len(cones), -np.inf), low / unit]),
        np.concatenate([aim, np.zeros(len(cones)), high / unit]),
        verbose=False,
        eps_abs=OSQP_TOLERANCE,
        eps_rel=OSQP_TOLERANCE,
        max_iter=200_000,
        polishing=True,
    )
    solver.warm_start(x=start)
    result = solver.solve(raise_error=False)
    x = np.asarray(result.x) * unit
    if (
        result.info.status_val not in OSQP_SOLVED
        or np.abs(balance @ x - target / rows).max() > BALANCE_TOLERANCE * unit
    ):
        raise GraspError(
            f"contact_forces: OSQP stopped with '{result.info.status}'; the wrench is"
            " close to what the grasp can exert, scale it down"
        )
    return _unpack(grip, maps, x)


def _feasible(
    balance: np.ndarray,
    aim: np.ndarray,
    cones: np.ndarray,
    limits: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> np.ndarray | None:
    """Any forces that exert the wrench, or None: OSQP alone is slow to find that there are none."""
    from scipy.optimize import linprog

    check = linprog(
        np.zeros(balance.shape[1]),
        A_eq=balance,
        b_eq=aim,
        A_ub=np.vstack([cones, limits, -limits]),
        b_ub=np.concatenate([np.zeros(len(cones)), high, -low]),
        bounds=(None, None),
        method="highs",
    )
    if check.status == 2:
        return None
    return np.zeros(balance.shape[1]) if check.x is None else check.x


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
    """Cone rows (<= 0), then rows between two bounds; those have the preloads' columns too."""
    cones, totals = [], []
    at = 0
    for contact, (block, ratio) in zip(contacts, maps, strict=True):
        points = (block.shape[1] - (1 if ratio else 0)) // 3
        torsion = at + 3 * points if ratio else None
        total = np.zeros(width)
        for p in range(points):
            here = slice(at + 3 * p, at + 3 * p + 3)
            cones.append(_cone(contact, edges, width, here, torsion))
            total[here] = contact.normal
        totals.append(total)
        at += block.shape[1]
    if not isinstance(grip, HandBound):
        most = np.array([c.max_normal_force for c in contacts])
        return np.vstack(cones), np.vstack(totals), np.zeros(len(most)), most
    low, high = intervals_of(grip)
    motors = np.hstack([_loads(grip, i, ratio) for i, (_, ratio) in enumerate(maps)])
    passive = len(low) - len(grip.preloads)
    preloads = np.vstack([grip.preloads, np.zeros((passive, grip.preloads.shape[1]))])
    return np.vstack(cones), np.hstack([motors, preloads]), low, high


def _cone(contact: Contact, edges: int, width: int, here: slice, torsion: int | None) -> np.ndarray:
    """Rows (<= 0) of one force's cone, inscribed; the torsion takes its share of the friction."""
    a, b = tangent_basis(contact.normal)
    angle = 2.0 * np.pi * np.arange(edges) / edges
    slope = contact.friction * np.cos(np.pi / edges)
    rows = np.zeros((edges + 1, width))
    rows[:edges, here] = np.outer(np.cos(angle), a) + np.outer(np.sin(angle), b)
    rows[:edges, here] -= slope * contact.normal
    rows[edges, here] = -contact.normal
    if torsion is None:
        return rows
    other = rows.copy()
    for sign, half in ((1.0, rows), (-1.0, other)):
        half[:edges, torsion] = sign * slope
        half[edges, torsion] = sign
    return np.vstack([rows, other])


def _loads(hand: HandBound, i: int, ratio: float) -> np.ndarray:
    """What a contact's variables load the motors and passive motions with, (k + u, 3 p [+ 1])."""
    jacobian, spin = motions_of(hand, i)
    columns = jacobian.transpose(2, 0, 1).reshape(jacobian.shape[2], -1)
    if not ratio:
        return columns
    if spin is None:
        raise GraspError(f"jacobians[{i}]: torsion needs a (6, k) Jacobian")
    twist = spin.T @ hand.contacts[i].normal * ratio
    return np.hstack([columns, twist[:, None]])


def _unpack(
    grip: HandBound | Sequence[Contact],
    maps: list[tuple[np.ndarray, float]],
    x: np.ndarray,
) -> ContactForces:
    forces, torsions, wrenches = [], [], []
    load = None
    at = 0
    if isinstance(grip, HandBound):
        load = grip.preloads @ x[len(x) - grip.preloads.shape[1] :]
    for i, (block, ratio) in enumerate(maps):
        own = x[at : at + block.shape[1]]
        points = (len(own) - (1 if ratio else 0)) // 3
        forces.append(own[: 3 * points].reshape(points, 3))
        torsions.append(own[-1] * ratio if ratio else 0.0)
        wrenches.append(block @ own)
        if isinstance(grip, HandBound) and load is not None:
            load = load + (_loads(grip, i, ratio) @ own)[: len(load)]
        at += block.shape[1]
    effort = float(x[:at] @ x[:at])
    return ContactForces(tuple(forces), np.array(torsions), np.array(wrenches), load, effort)
