"""Potential contact robustness (PCR) and potential grasp robustness (PGR) of a compliant grasp.

A disturbance w of the object changes the contact forces by G⁺_K w with

    G⁺_K = K Gᵀ (G K Gᵀ)⁻¹,        K the stiffness of pads and servos (``compliance``).

So no contact slips and no motor exceeds its limit as long as |w| < d / σmax(G⁺_K), with d the
distance of the contact forces from the nearest limit. The forces are those that bear the weight,
plus internal ones that the servos can control: the range of (1 - G⁺_K G) K J. PCR takes the best
of them.

Contacts that slip or let go need not bring the grasp down. PGR gives each contact one of three
states, sticks (all forces), slips (the normal force alone), off (none), and takes the best of all
3ⁿ sets in which stiffness still holds the object in place.

Bicchi: On the closure properties of robotic grasping, Int. J. Robotics Research 14(4), 1995;
Pozzi, Malvezzi, Prattichizzo: On grasp quality measures: grasp robustness and contact force
distribution in underactuated and compliant robotic hands, IEEE RA-L 2(1), 2017. SynGrasp's code
minimises a smooth barrier function in place of the distance, takes stiffness 1, and bounds contact
forces by constants; here the distance itself is maximised, by a linear program, within the motors'
limits.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike

from graspq.compliance import CompliantGrasp, contact_stiffness
from graspq.errors import GraspError, as_array

MOST_CONTACTS = 7  # 3^7 sets of states are looked through
HELD_TOLERANCE = 1e-9  # of G K Gᵀ, smallest eigenvalue over largest, below which an object is loose
STICKS, SLIPS, OFF = 0, 1, 2


def contact_robustness(grasp: CompliantGrasp, wrench: ArrayLike, edges: int = 12) -> float:
    """Return the potential contact robustness [N]; high is good.

    The largest force (or moment over the grasp's length) in any direction beside ``wrench`` under
    which no contact slips or lifts off and no motor exceeds its limit. 0 where the stiffness of the
    contacts does not hold the object in place, or no controllable internal forces make the grasp
    bear ``wrench``.

    It does not see contacts' places beyond their centres, errors of perception, or what happens
    once a contact slips.

    Args:
        grasp: the grasp; the friction of its contacts counts, not their largest normal force.
        wrench: that the hand exerts, shape (6,) [N, N m] about the origin of the contacts' frame.
        edges: of the friction cones, inscribed, at least 3.

    Raises:
        GraspError: for bad input.
    """
    states = np.full(len(grasp.hand.contacts), STICKS)
    return _Robustness(grasp, wrench, edges).of(states)


def grasp_robustness(grasp: CompliantGrasp, wrench: ArrayLike, edges: int = 12) -> float:
    """Return the potential grasp robustness [N]: the best over the states of all contacts.

    At least the contact robustness; arguments, orientation and units are the same.

    Raises:
        GraspError: for bad input, or more than ``MOST_CONTACTS`` contacts.
    """
    count = len(grasp.hand.contacts) if isinstance(grasp, CompliantGrasp) else 0
    if count > MOST_CONTACTS:
        raise GraspError(
            f"grasp: got {count} contacts, whose 3^{count} sets of states are too many; give at"
            f" most {MOST_CONTACTS}, or take contact_robustness"
        )
    search = _Robustness(grasp, wrench, edges)
    every = [np.array(states) for states in itertools.product((STICKS, SLIPS, OFF), repeat=count)]
    bounds = np.array([search.bound(states) for states in every])
    best = 0.0
    for k in np.argsort(-bounds, kind="stable"):
        if bounds[k] <= best:
            break
        best = max(best, search.of(every[k]))
    return best


class _Robustness:
    """What the sets of states of one grasp share."""

    def __init__(self, grasp: CompliantGrasp, wrench: ArrayLike, edges: int) -> None:
        if not isinstance(grasp, CompliantGrasp):
            raise GraspError(f"grasp: expected a CompliantGrasp, got {type(grasp).__name__}")
        if isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3:
            raise GraspError(f"edges: expected an integer >= 3, got {edges!r}")
        self.grasp = grasp
        self.wrench = as_array("wrench", wrench, (6,)).copy()
        self.wrench[3:] /= grasp.length
        self.edges = int(edges)

    def _chosen(self, states: np.ndarray) -> np.ndarray:
        of_force = states[self.grasp.owners]
        return (of_force == STICKS) | ((of_force == SLIPS) & self.grasp.normals)

    def _inverse(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """K and G⁺_K, (r, r) and (r, 6); None where the object is not held in place."""
        if chosen.sum() < 6:
            return None
        forces = self.grasp.grasp_map[:, chosen]
        stiffness = contact_stiffness(self.grasp, chosen)
        held = forces @ stiffness @ forces.T
        values = np.linalg.eigvalsh(held)
        if values[0] <= HELD_TOLERANCE * values[-1]:
            return None
        return stiffness, np.linalg.solve(held, forces @ stiffness).T

    def bound(self, states: np.ndarray) -> float:
        """What the robustness cannot exceed: half the width of a motor's range is the largest d."""
        chosen = self._chosen(states)
        found = self._inverse(chosen)
        if found is None:
            return 0.0
        motors = len(self.grasp.hand.torque_limit)
        size = np.linalg.norm(self.grasp.jacobian[chosen, :motors], axis=0)
        loaded = size > 0.0
        width = 0.5 * (self.grasp.hand.upper - self.grasp.hand.lower)[loaded] / size[loaded]
        return float(width.min(initial=np.inf) / np.linalg.norm(found[1], 2))

    def of(self, states: np.ndarray) -> float:
        """Robustness of the contacts in those states."""
        from scipy.optimize import linprog

        grasp, chosen = self.grasp, self._chosen(states)
        found = self._inverse(chosen)
        if found is None:
            return 0.0
        stiffness, inverse = found
        motors = len(grasp.hand.torque_limit)
        forces, motions = grasp.grasp_map[:, chosen], grasp.jacobian[chosen, :motors]
        changed = stiffness @ motions
        internal = _basis(changed - inverse @ (forces @ changed))
        rows, most = self._limits(states, chosen, motions)
        size = np.linalg.norm(rows, axis=1)
        counts = size > 0.0
        rows, most = rows[counts] / size[counts, None], most[counts] / size[counts]
        start = inverse @ self.wrench
        result = linprog(
            np.concatenate([np.zeros(internal.shape[1]), [-1.0]]),
            A_ub=np.hstack([rows @ internal, np.ones((len(rows), 1))]),
            b_ub=most - rows @ start,
            bounds=(None, None),
            method="highs-ds",
        )
        if result.status == 3:
            return np.inf
        if result.x is None:
            raise GraspError(f"contact_robustness: the linear program stopped ({result.message})")
        return max(0.0, float(result.x[-1])) / float(np.linalg.norm(inverse, 2))

    def _limits(
        self, states: np.ndarray, chosen: np.ndarray, motions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rows a and bounds b with a f <= b for the forces (r,) that are within all limits."""
        grasp, width = self.grasp, int(chosen.sum())
        place = np.cumsum(chosen) - 1
        rows = []
        for i, contact in enumerate(grasp.hand.contacts):
            own = place[chosen & (grasp.owners == i)]
            if states[i] == OFF:
                continue
            push = np.zeros((1, width))
            push[0, own[0]] = -1.0
            rows.append(push)
            if states[i] == STICKS:
                block = friction_rows(contact.friction, self.edges, len(own) == 4)
                cone = np.zeros((len(block), width))
                cone[:, own] = block
                rows.append(cone)
        cones = np.vstack(rows)
        hand = grasp.hand
        every = np.vstack([cones, motions.T, -motions.T])
        return every, np.concatenate([np.zeros(len(cones)), hand.upper, -hand.lower])


def friction_rows(friction: float, edges: int, soft: bool) -> np.ndarray:
    """Rows a with a f <= 0 for forces inside a contact's inscribed friction cone.

    Args:
        friction: μ.
        edges: of the cone.
        soft: whether the contact has a moment, whose force at its friction arm shares the friction
            with the tangential force: |f_t| + |f_m| <= μ f_n.

    Returns:
        shape (edges, 3), or (2 edges, 4) where soft, over the normal force, two tangential ones and
        the moment.
    """
    angle = 2.0 * np.pi * (np.arange(edges) + 0.5) / edges
    slope = friction * np.cos(np.pi / edges)
    flat = np.column_stack([np.full(edges, -slope), np.cos(angle), np.sin(angle)])
    if not soft:
        return flat
    share = np.full(edges, np.cos(np.pi / edges))
    sides = [np.column_stack([flat, sign * share]) for sign in (1.0, -1.0)]
    return np.vstack(sides)


def _basis(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal columns that span those of a matrix."""
    left, values, _ = np.linalg.svd(matrix, full_matrices=False)
    return left[:, values > HELD_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300)]
