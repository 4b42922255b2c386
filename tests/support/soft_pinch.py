"""Two soft fingers that press against each other along x, each with a motor along its normal."""

from __future__ import annotations

import numpy as np

import graspq as gq

RADIUS, FRICTION, LIMIT = 0.03, 0.5, 10.0
PAD, TORSION, SERVO = 4000.0, 0.5, 2000.0
ARM = 0.004  # of the contacts' friction, for moments about their normal [m]


def contacts(arm: float = ARM) -> list[gq.Contact]:
    """At ±RADIUS, pressing inwards; hard with arm 0."""
    return [
        gq.Contact([side * RADIUS, 0, 0], [-side, 0, 0], FRICTION, LIMIT, arm * FRICTION * LIMIT)
        for side in (1.0, -1.0)
    ]


def jacobians(driven: bool = True) -> list[np.ndarray]:
    """(6, 2) each: a motor moves its finger along the normal, or nothing."""
    found = []
    for k, side in enumerate((1.0, -1.0)):
        jacobian = np.zeros((6, 2))
        jacobian[0, k] = -side if driven else 0.0
        found.append(jacobian)
    return found


def hand(arm: float = ARM, driven: bool = True) -> gq.HandBound:
    """Contacts behind their motors."""
    return gq.HandBound(contacts(arm), jacobians(driven), [LIMIT, LIMIT])


def grasp(length: float = RADIUS, arm: float = ARM, driven: bool = True) -> gq.CompliantGrasp:
    """With springs behind them."""
    return gq.CompliantGrasp(
        hand(arm, driven), [PAD] * 2, [SERVO] * 2, length, [TORSION] * 2 if arm else None
    )


def turned(found: gq.CompliantGrasp, rotation: np.ndarray, order: list[int]) -> gq.CompliantGrasp:
    """The same grasp in other axes (3, 3), its contacts in another order."""
    both = np.kron(np.eye(2), rotation)
    made, moved = [], []
    for i in order:
        c = found.hand.contacts[i]
        made.append(
            gq.Contact(
                rotation @ c.position, rotation @ c.normal, c.friction, c.max_normal_force,
                c.max_torsion,
            )
        )  # fmt: skip
        spin = found.hand.spins[i]
        assert spin is not None
        moved.append(both @ np.vstack([found.hand.jacobians[i][0], spin]))
    count = len(order)
    motors = len(found.hand.torque_limit)
    return gq.CompliantGrasp(
        gq.HandBound(made, moved, found.hand.torque_limit),
        [PAD] * count, [SERVO] * motors, found.length, [TORSION] * count,
    )  # fmt: skip
