"""Contacts of one hand that share motors, and how far a task can be scaled with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact import Contact, tangent_basis
from graspq.errors import GraspError, as_array, as_number

NO_EQUILIBRIUM = (
    "no equilibrium exists for task {j}: the friction cones cannot balance what"
    " the motors at their limit ({motors}) push with"
)
UNLOADED = (
    "no equilibrium exists: motor {k} pushes with {torque:.4g} N m at its limit, but no"
    " contact loads it"
)
UNREACHABLE = "task {j} cannot be exerted: the friction cones and motors allow only a scale of 0"


@dataclass(frozen=True, eq=False, init=False)
class HandBound:
    """The contacts of one hand, the motors behind them and what the motors may do.

    The contact forces f_i inside their friction cones load the motors with Σ J_iᵀ f_i. Without
    ``motor_torque`` this may be anything within the limits ("capability"). With it, motors at
    their limit, |τ| >= (1 - slack) τ̄, go on pushing with that torque within ``slack`` of it,
    and the others hold their position with any torque inside their limits ("held"): what
    torque-limited position servos do. The contacts' own ``max_normal_force`` does not matter.

    Attributes:
        contacts: the contacts; a patch exerts a force at every taxel.
        jacobians: per contact, motor speeds to contact velocity, shape (p, 3, k), one for each
            of its p points [m/rad]; torsion rows (p, 3, k) in ``spins`` [1].
        spins: angular rows of the Jacobians, per contact (3, k), or None where not given.
        torque_limit: largest motor torques τ̄, shape (k,) [N m].
        motor_torque: motor torques at the snapshot, shape (k,) [N m], or None.
        lower, upper: interval of every motor's torque, each (k,) [N m].
        at_limit: which motors push with a given torque, shape (k,).
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

    def __init__(
        self,
        contacts: Sequence[Contact],
        jacobians: Sequence[ArrayLike],
        torque_limit: ArrayLike,
        motor_torque: ArrayLike | None = None,
        slack: float = 0.05,
    ) -> None:
        """Check and store a hand.

        Args:
            contacts: the contacts, at least one.
            jacobians: one per contact, in the contacts' frame and in motor coordinates (a
                coupled joint is one column): (3, k) translational, the same for every taxel;
                (6, k) translational at ``position`` over angular, moved to each taxel; or
                (p, 3, k) one per taxel.
            torque_limit: largest motor torques, shape (k,) [N m].
            motor_torque: measured motor torques, shape (k,) [N m]; positive as in J^T f for
                the force f on the object.
            slack: relative tolerance of a torque at its limit.
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
        low, high = -limit, limit.copy()
        torque = None
        at_limit = np.zeros(len(limit), dtype=bool)
        if motor_torque is not None:
            torque = as_array("motor_torque", motor_torque, limit.shape)
            at_limit = (np.abs(torque) >= (1.0 - share) * limit) & (limit > 0)
            low = np.where(at_limit, torque - share * np.abs(torque), low)
            high = np.where(at_limit, torque + share * np.abs(torque), high)
        pairs = [
            _jacobian(i, c, j, len(limit))
            for i, (c, j) in enumerate(zip(grip, jacobians, strict=True))
        ]
        fields = {
            "contacts": grip,
            "jacobians": tuple(p[0] for p in pairs),
            "spins": tuple(p[1] for p in pairs),
            "torque_limit": limit,
            "motor_torque": torque,
            "slack": share,
            "lower": low,
            "upper": high,
            "at_limit": at_limit,
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


def cones_of(hand: HandBound, origin: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Friction cones per unit normal force: (K, 6 + k, 4) and each one's contact, (K,).

    Column 0 is the normal force, columns 1 to 3 span the friction ellipsoid around it; the
    rows are the wrench and the motor torques.
    """
    blocks, owners = [], []
    for i, contact in enumerate(hand.contacts):
        a, b = tangent_basis(contact.normal)
        force = np.column_stack([contact.normal, contact.friction * a, contact.friction * b])
        spin = hand.spins[i]
        twist = np.zeros(6 + len(hand.torque_limit))
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
        block = np.empty((len(points), 6 + len(hand.torque_limit), 4))
        block[:, :3, :3] = force
        arms = scale * (points - origin)
        block[:, 3:6, :3] = np.cross(arms[:, None, :], force.T).transpose(0, 2, 1)
        block[:, 6:, :3] = hand.jacobians[i].transpose(0, 2, 1) @ force
        block[:, :, 3] = twist
        blocks.append(block)
        owners += [i] * len(points)
    return np.concatenate(blocks), np.array(owners)


def _jacobian(
    i: int, contact: Contact, value: ArrayLike, motors: int
) -> tuple[np.ndarray, np.ndarray | None]:
    """Translational Jacobian at every point (p, 3, k), and the angular rows (3, k) if given."""
    points = points_of(contact)
    name = f"jacobians[{i}]"
    if np.ndim(value) == 3:  # type: ignore[arg-type]
        return as_array(name, value, (len(points), 3, motors)), None
    rows = np.shape(value)[0] if np.ndim(value) == 2 else 0  # type: ignore[arg-type]
    array = as_array(
        name,
        value,
        (6 if rows == 6 else 3, motors),
        f"(3, {motors}), (6, {motors}) or ({len(points)}, 3, {motors})",
    )
    if rows != 6:
        return np.repeat(array[None], len(points), axis=0), None
    arms = points - contact.position
    moved = array[:3] + np.cross(array[3:].T[None], arms[:, None, :]).transpose(0, 2, 1)
    return moved, array[3:]
