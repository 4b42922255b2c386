"""Contacts of one hand that share motors, and what the motors may do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact import Contact, tangent_basis
from graspq.errors import GraspError, as_array, as_number
from graspq.transmission import Transmission, reduce_transmission


@dataclass(frozen=True, eq=False, init=False)
class HandBound:
    """The contacts of one hand, the motors behind them and what the motors may do.

    The contact forces f_i inside their friction cones load the motors with Σ J_iᵀ f_i. Without
    ``motor_torque`` this may be anything within the limits ("capability"). With it, motors at
    their limit, |τ| >= (1 - slack) τ̄, go on pushing with that torque within ``slack`` of it,
    and the others hold their position with any torque inside their limits ("held"): what
    torque-limited position servos do. The contacts' own ``max_normal_force`` does not matter.

    A ``transmission`` A and ``couplings`` E say how motors drive joints: gears, tendons, coupled
    or underactuated joints. The Jacobians J_q are then in joint coordinates, and the statics are
    Σ J_qᵀ f = Aᵀ τ + Eᵀ λ with λ free. Joints neither driven nor coupled bear no torque; springs,
    friction and end stops of joints are left out.

    Attributes:
        contacts: the contacts; a patch exerts a force at every taxel.
        jacobians: per contact, motor speeds to contact velocity, shape (p, 3, k), one for each
            of its p points [m/rad].
        spins: angular rows of the Jacobians, per contact (3, k), or None where not given.
        torque_limit: largest motor torques τ̄, shape (k,) [N m].
        motor_torque: motor torques at the snapshot, shape (k,) [N m], or None.
        slack: relative tolerance of a torque at its limit.
        lower, upper: interval of every motor's torque, each (k,) [N m].
        at_limit: which motors push with a given torque, shape (k,).
        passive_jacobians: as ``jacobians``, for the u motions that no motor drives and on which
            the forces do no work, shape (p, 3, u); u = 0 unless the hand is underactuated.
        passive_spins: angular rows of those, per contact (3, u) or None.
        preloads: motor torques that load no joint, shape (k, r); r = 0 unless motors are redundant.
    """

    contacts: tuple[Contact, ...]
    jacobians: tuple[np.ndarray, ...]
    spins: tuple[np.ndarray | None, ...]
    torque_limit: np.ndarray
    motor_torque: np.ndarray | None
    slack: float
    lower: np.ndarray
    upper: np.ndarray
    at_limit: np.ndarray
    passive_jacobians: tuple[np.ndarray, ...]
    passive_spins: tuple[np.ndarray | None, ...]
    preloads: np.ndarray

    def __init__(
        self,
        contacts: Sequence[Contact],
        jacobians: Sequence[ArrayLike],
        torque_limit: ArrayLike,
        motor_torque: ArrayLike | None = None,
        slack: float = 0.05,
        transmission: ArrayLike | None = None,
        couplings: ArrayLike | None = None,
    ) -> None:
        """Check and store a hand.

        Args:
            contacts: the contacts, at least one.
            jacobians: one per contact, in the contacts' frame: (3, n) translational, the same for
                every taxel; (6, n) translational at ``position`` over angular, moved to each
                taxel; or (p, 3, n) one per taxel. The n columns are joints; motors where neither
                ``transmission`` nor ``couplings`` is given (a coupled joint is then one column).
            torque_limit: largest motor torques, shape (k,) [N m]; forces [N] for linear motors.
            motor_torque: measured motor torques, shape (k,) [N m]; positive as in J^T f for
                the force f on the object.
            slack: relative tolerance of a torque at its limit.
            transmission: moment arms A of the motors about the joints, shape (k, n): joint
                torques are Aᵀ τ, motor speeds A q̇. A gear ratio stands in the diagonal, the
                coefficients of a fixed tendon in a row. None: every joint has its own motor.
            couplings: E, shape (e, n): joint speeds are tied by E q̇ = 0. Rows may repeat each
                other. None: no joint is tied to another.

        Raises:
            GraspError: naming the argument whose shape or value is wrong.
        """
        grip = tuple(contacts)
        if not grip or not all(isinstance(c, Contact) for c in grip):
            raise GraspError(f"contacts: expected at least one Contact, got {contacts!r}")
        if len(jacobians) != len(grip):
            raise GraspError(
                f"jacobians: expected one per contact ({len(grip)}), got {len(jacobians)}"
            )
        limit = as_array("torque_limit", torque_limit, (None,))
        if (limit < 0).any() or not len(limit):
            raise GraspError("torque_limit: expected at least one value, each >= 0")
        share = as_number("slack", slack)
        lower, upper = -limit, limit.copy()
        torque = None
        at_limit = np.zeros(len(limit), dtype=bool)
        if motor_torque is not None:
            torque = as_array("motor_torque", motor_torque, limit.shape)
            at_limit = (np.abs(torque) >= (1.0 - share) * limit) & (limit > 0)
            lower = np.where(at_limit, torque - share * np.abs(torque), lower)
            upper = np.where(at_limit, torque + share * np.abs(torque), upper)
        joints, split = _transmission(len(limit), transmission, couplings)
        given = [
            _jacobian(i, c, j, joints, split is not None)
            for i, (c, j) in enumerate(zip(grip, jacobians, strict=True))
        ]
        if split is None:
            driven, passive = given, [_times(j, np.zeros((joints, 0))) for j in given]
        else:
            driven = [_times(j, split.driven) for j in given]
            passive = [_times(j, split.passive) for j in given]
        fields = {
            "contacts": grip,
            "jacobians": tuple(j[0] for j in driven),
            "spins": tuple(j[1] for j in driven),
            "torque_limit": limit,
            "motor_torque": torque,
            "slack": share,
            "lower": lower,
            "upper": upper,
            "at_limit": at_limit,
            "passive_jacobians": tuple(j[0] for j in passive),
            "passive_spins": tuple(j[1] for j in passive),
            "preloads": np.zeros((len(limit), 0)) if split is None else split.preloads,
        }
        for name, value in fields.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def held(self) -> bool:
        """Whether measured motor torques restrict the forces."""
        return self.motor_torque is not None


def points_of(contact: Contact) -> np.ndarray:
    """Where a contact's forces act: its taxels, or its centre, shape (p, 3) [m]."""
    return contact.position[None, :] if contact.patch is None else contact.patch


def motions_of(hand: HandBound, i: int) -> tuple[np.ndarray, np.ndarray | None]:
    """Jacobians of contact i for the motors, then the passive motions: (p, 3, k + u), (3, k + u).

    Forces f load these motions with Σ Jᵀ f, which must lie within ``intervals_of``.
    """
    spin, passive = hand.spins[i], hand.passive_spins[i]
    if hand.passive_jacobians[i].shape[2] == 0:
        return hand.jacobians[i], spin
    both = None if spin is None or passive is None else np.hstack([spin, passive])
    return np.concatenate([hand.jacobians[i], hand.passive_jacobians[i]], axis=2), both


def intervals_of(hand: HandBound) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest load of every motor, then of every passive motion (0): (k + u,) each."""
    nothing = np.zeros(hand.passive_jacobians[0].shape[2])
    return np.concatenate([hand.lower, nothing]), np.concatenate([hand.upper, nothing])


def cones_of(hand: HandBound, origin: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Friction cones per unit normal force: (K, 6 + k + u, 4) and each one's contact, (K,).

    Column 0 is the normal force, columns 1 to 3 span the friction ellipsoid around it; the rows
    are the wrench, the motor torques and the loads of the passive motions.
    """
    blocks, owners = [], []
    for i, contact in enumerate(hand.contacts):
        a, b = tangent_basis(contact.normal)
        force = np.column_stack([contact.normal, contact.friction * a, contact.friction * b])
        jacobian, spin = motions_of(hand, i)
        rows = 6 + jacobian.shape[2]
        twist = np.zeros(rows)
        if contact.patch is None and contact.max_torsion > 0:
            if spin is None:
                raise GraspError(
                    f"jacobians[{i}]: the contact has max_torsion > 0, whose load on"
                    " the motors needs a (6, k) Jacobian; give one, or"
                    " max_torsion=0"
                )
            if contact.max_normal_force == 0:
                raise GraspError(f"contacts[{i}]: max_torsion > 0 beside max_normal_force = 0")
            moment = contact.normal * contact.max_torsion / contact.max_normal_force
            twist[3:6] = scale * moment
            twist[6:] = spin.T @ moment
        points = points_of(contact)
        block = np.empty((len(points), rows, 4))
        block[:, :3, :3] = force
        arms = scale * (points - origin)
        block[:, 3:6, :3] = np.cross(arms[:, None, :], force.T).transpose(0, 2, 1)
        block[:, 6:, :3] = jacobian.transpose(0, 2, 1) @ force
        block[:, :, 3] = twist
        blocks.append(block)
        owners += [i] * len(points)
    return np.concatenate(blocks), np.array(owners)


def _transmission(
    motors: int, transmission: ArrayLike | None, couplings: ArrayLike | None
) -> tuple[int, Transmission | None]:
    """The number of joints, and what drives them; None where every joint is a motor's."""
    if transmission is None and couplings is None:
        return motors, None
    if transmission is None:
        arms = np.eye(motors)
    else:
        arms = as_array(
            "transmission",
            transmission,
            (motors, None),
            f"one row per motor (torque_limit has {motors}), one column per joint",
        )
        if arms.shape[1] == 0:
            raise GraspError(
                f"transmission: got shape {arms.shape}, without a joint; give one column per joint"
            )
    joints = arms.shape[1]
    ties = np.zeros((0, joints))
    if couplings is not None:
        where = "motor, as transmission is not given" if transmission is None else "joint"
        hint = f"one row per coupling, one column per {where}"
        ties = as_array("couplings", couplings, (None, joints), hint)
    return joints, reduce_transmission(arms, ties)


def _jacobian(
    i: int, contact: Contact, value: ArrayLike, joints: int, in_joints: bool
) -> tuple[np.ndarray, np.ndarray | None]:
    """Translational Jacobian at every point (p, 3, n), and the angular rows (3, n) if given."""
    points = points_of(contact)
    name = f"jacobians[{i}]"
    if np.ndim(value) == 3:  # type: ignore[arg-type]
        return as_array(name, value, (len(points), 3, joints)), None
    rows = np.shape(value)[0] if np.ndim(value) == 2 else 0  # type: ignore[arg-type]
    array = as_array(
        name,
        value,
        (6 if rows == 6 else 3, joints),
        f"(3, {joints}), (6, {joints}) or ({len(points)}, 3, {joints})"
        + (", one column per joint (as transmission or couplings have)" if in_joints else ""),
    )
    if rows != 6:
        return np.repeat(array[None], len(points), axis=0), None
    arms = points - contact.position
    moved = array[:3] + np.cross(array[3:].T[None], arms[:, None, :]).transpose(0, 2, 1)
    return moved, array[3:]


def _times(
    jacobian: tuple[np.ndarray, np.ndarray | None], motions: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """A contact's Jacobian for other motions: joint speeds (n, k) per new speed."""
    linear, angular = jacobian
    return linear @ motions, None if angular is None else angular @ motions
