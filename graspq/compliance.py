"""Grasps with compliant pads and servos: contact stiffness, grasp stiffness.

A contact exerts a force along its normal and two tangents, and, where it is soft, a moment about
its normal. Moments stand in as forces: divided by the contact's own friction arm τ*/(μ g*) in the
contact, so that the friction cone is round in all its components, and by a given length in the
wrench. Pads yield in series with the servos behind them:

    K = (C_s + J C_q Jᵀ)⁻¹        C_s, C_q compliances of pads and servos,
    stiffness of the grasp = G K Gᵀ.

Cutkosky, Kao: Computing and controlling the compliance of a robotic hand, IEEE Trans. Robotics and
Automation 5(2), 1989; Rimon, Burdick: The Mechanics of Robot Grasping, 2019. Terms from contact
forces that turn with the object (geometric stiffness) are left out, as SynGrasp does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from graspq.contact import tangent_basis
from graspq.errors import GraspError, as_array, as_number
from graspq.hand_bound import HandBound, motions_of

SOFTEST = 1e-12  # passive motions yield freely: their share of the pads' stiffness, for solving


@dataclass(frozen=True, eq=False, init=False)
class CompliantGrasp:
    """A hand's contacts as points with springs behind them.

    Attributes:
        hand: contacts and motors.
        grasp_map: G, contact forces to wrenches (6, m) [N, N m / length], moments about the origin
            of the contacts' frame.
        jacobian: J, motor speeds, then passive motions, to contact velocities (m, k + u).
        pads: stiffness of every force component [N/m], (m,).
        servos: of the motors, then of the passive motions (0), (k + u,) [N m/rad].
        owners: contact of every component (m,).
        normals: which components are normal forces (m,) bool.
        length: that moments of the wrench are divided by [m].
    """

    hand: HandBound
    grasp_map: np.ndarray
    jacobian: np.ndarray
    pads: np.ndarray
    servos: np.ndarray
    owners: np.ndarray
    normals: np.ndarray
    length: float

    def __init__(
        self,
        hand: HandBound,
        pad_stiffness: ArrayLike,
        servo_stiffness: ArrayLike,
        length: float,
        torsion_stiffness: ArrayLike | None = None,
    ) -> None:
        """Check and store a grasp.

        Args:
            hand: contacts without patches, each a point; soft ones (``max_torsion`` > 0) need
                (6, k) Jacobians.
            pad_stiffness: of every contact, the same in all directions, shape (n,) [N/m], above 0.
            servo_stiffness: of every motor's position servo, shape (k,) [N m/rad or N/m], above 0.
            length: of the object, that makes moments comparable with forces [m], above 0.
            torsion_stiffness: of every contact about its normal, shape (n,) [N m/rad], above 0
                where it is soft; None: no contact is soft.

        Raises:
            GraspError: naming the argument that cannot be used.
        """
        if not isinstance(hand, HandBound):
            raise GraspError(f"hand: expected a HandBound, got {type(hand).__name__}")
        count, motors = len(hand.contacts), len(hand.torque_limit)
        pads = _stiffness("pad_stiffness", pad_stiffness, count, "contact")
        servos = _stiffness("servo_stiffness", servo_stiffness, motors, "motor")
        scale = as_number("length", length, positive=True)
        twist = np.zeros(count)
        if torsion_stiffness is not None:
            twist = as_array("torsion_stiffness", torsion_stiffness, (count,), "one per contact")
        columns, rows, springs, owners, normals = [], [], [], [], []
        for i, contact in enumerate(hand.contacts):
            if contact.patch is not None:
                raise GraspError(f"contacts[{i}]: expected a point, got a patch; give patch=None")
            linear, spin = motions_of(hand, i)
            axes = np.vstack([contact.normal, *tangent_basis(contact.normal)])
            arms = np.cross(contact.position, axes) / scale
            columns.append(np.hstack([axes, arms]))
            rows.append(axes @ linear[0])
            springs += [pads[i]] * 3
            size = 3
            arm = friction_arm(hand, i)
            if torsion_stiffness is not None and arm > 0.0:
                if not twist[i] > 0.0:
                    raise GraspError(
                        f"torsion_stiffness: contact {i} is soft, expected a value above 0, got"
                        f" {twist[i]}; give one, or a contact with max_torsion=0"
                    )
                if spin is None:
                    raise GraspError(f"jacobians[{i}]: the contact is soft; give a (6, k) Jacobian")
                moment = arm * contact.normal
                columns.append(np.concatenate([np.zeros(3), moment / scale])[None])
                rows.append((moment @ spin)[None])
                springs.append(twist[i] / arm**2)
                size = 4
            owners += [i] * size
            normals += [True] + [False] * (size - 1)
        free = rows[0].shape[1] - motors
        fields = {
            "hand": hand,
            "grasp_map": np.vstack(columns).T,
            "jacobian": np.vstack(rows),
            "pads": np.array(springs),
            "servos": np.concatenate([servos, np.zeros(free)]),
            "owners": np.array(owners),
            "normals": np.array(normals),
            "length": scale,
        }
        for name, value in fields.items():
            object.__setattr__(self, name, value)


def friction_arm(hand: HandBound, i: int) -> float:
    """τ*/(μ g*) of a contact [m]: the arm at which its friction exerts its moment; 0 where hard."""
    contact = hand.contacts[i]
    grip = contact.friction * contact.max_normal_force
    return contact.max_torsion / grip if grip > 0.0 else 0.0


def contact_stiffness(grasp: CompliantGrasp, kept: ArrayLike | None = None) -> np.ndarray:
    """Return K = (C_s + J C_q Jᵀ)⁻¹: forces by which contacts answer the object's motion, [N/m].

    Passive motions, which no servo holds, yield freely: K then does no work on them.

    Args:
        grasp: with its m force components.
        kept: those that act, shape (m,) bool; None: all. Others exert nothing, and do not count.

    Returns:
        shape (r, r) for the r components kept.

    Raises:
        GraspError: for a mask of another shape.
    """
    chosen = _mask(grasp, kept)
    pads, motions = grasp.pads[chosen], grasp.jacobian[chosen]
    # The same by the matrix inversion lemma, which also takes motions without a servo.
    pushed = pads[:, None] * motions
    yields = motions.T @ pushed + np.diag(grasp.servos)
    yields += SOFTEST * float(pads.max(initial=0.0)) * np.diag(grasp.servos == 0.0)
    return np.diag(pads) - pushed @ np.linalg.pinv(yields, rcond=SOFTEST, hermitian=True) @ pushed.T


def grasp_stiffness(grasp: CompliantGrasp) -> np.ndarray:
    """Return G K Gᵀ, the wrench that answers a small motion of the object, shape (6, 6) [N/m].

    Motions are translations [m], then rotations [rad] times the grasp's length, about the origin
    of the contacts' frame. Symmetric, without negative eigenvalues. No contact slips or lifts off.

    Args:
        grasp: the grasp.
    """
    stiffness = grasp.grasp_map @ contact_stiffness(grasp) @ grasp.grasp_map.T
    return 0.5 * (stiffness + stiffness.T)


def least_stiffness(grasp: CompliantGrasp) -> float:
    """Return the smallest eigenvalue of ``grasp_stiffness`` [N/m]; high is good.

    0: the object moves some way against no resistance. It sees neither friction nor torque limits.

    Args:
        grasp: the grasp.
    """
    return max(0.0, float(np.linalg.eigvalsh(grasp_stiffness(grasp))[0]))


def _mask(grasp: CompliantGrasp, kept: ArrayLike | None) -> np.ndarray:
    if kept is None:
        return np.ones(len(grasp.pads), dtype=bool)
    chosen = np.asarray(kept)
    if chosen.shape != grasp.pads.shape or chosen.dtype != bool:
        raise GraspError(
            f"kept: expected {len(grasp.pads)} booleans, one per force component, got"
            f" {chosen.dtype} of shape {chosen.shape}"
        )
    return chosen


def _stiffness(name: str, value: ArrayLike, count: int, what: str) -> np.ndarray:
    array = as_array(name, value, (count,), f"one per {what}")
    if (array <= 0.0).any():
        k = int(np.argmax(array <= 0.0))
        raise GraspError(f"{name}: expected values above 0, got {array[k]} at {k}")
    return array
