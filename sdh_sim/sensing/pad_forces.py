"""How hard the pads of a hand can press, by statics: motors at their rated limits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import graspq as gq
from sdh_sim.robot import HandKinematics
from sdh_sim.robot.hand_checks import pad_place

_MIDDLE = 0.5  # closing ratio


class PadForces(NamedTuple):
    """Normal forces of pads halfway through a closing.

    Attributes:
        alone: of each pad while no other bears any, equation (6), by name [N].
        together: the largest that all pads with a motor that squeezes bear at once [N].
    """

    alone: dict[str, float]
    together: float


def pad_forces(kinematics: HandKinematics, closing: str) -> PadForces:
    """How hard each pad can press at its middle, along its normal.

    Pads that no squeezing motor presses forward are left out. The same force F on the pads p loads
    motor m with F |Σ (J_pᵀ n_p)_m|, which its limit bounds.

    Args:
        kinematics: of the hand.
        closing: name of one of its closings.
    """
    hand, line = kinematics.hand, kinematics.hand.closing(closing)
    posture = kinematics.at(line.angles(_MIDDLE))
    limits = np.array([motor.rated for motor in hand.motors])
    sense = np.where(line.travel == 0.0, [m.flexes for m in hand.motors], np.sign(line.travel))
    alone: dict[str, float] = {}
    load = np.zeros(len(limits))
    for pad in hand.pads:
        middle, normal = pad_place(posture, pad)
        jacobian = posture.of_motors(posture.jacobian(pad.body, middle))
        arms = jacobian.T @ normal
        if (arms * sense)[line.squeezes].max(initial=0.0) <= 1e-9:
            continue
        alone[pad.name] = gq.max_normal_force(jacobian, normal, limits)
        load += arms
    loaded = np.abs(load) > 1e-12
    together = float((limits[loaded] / np.abs(load[loaded])).min()) if loaded.any() else 0.0
    return PadForces(alone, together)
