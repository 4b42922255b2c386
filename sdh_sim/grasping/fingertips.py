"""How far the fingertips reach as the hand closes, and what therefore fits into it."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from sdh_sim.robot import Finger, Hand, HandPosture, hand_kinematics

_STEPS = 25  # of the closing ratio


class Reach(NamedTuple):
    """What the fingertips do while a preshape closes on an object.

    Attributes:
        lowest: furthest that a fingertip gets along the palm's z [m].
        widest: distance between opposite pads with the hand open [m].
    """

    lowest: float
    widest: float


@lru_cache(maxsize=256)
def fingertip_reach(hand: Hand, preshape: str, half: float) -> Reach:
    """How far the fingertips reach before the pads meet an object.

    Args:
        hand: the hand.
        preshape: name of one of its closings.
        half: half of the object's width along which the hand closes [m].
    """
    closing, kinematics = hand.closing(preshape), hand_kinematics(hand)
    tips = np.array(
        [
            [_tip(kinematics.at(closing.angles(ratio)), finger) for finger in hand.fingers]
            for ratio in np.linspace(0.0, 1.0, _STEPS + 1)
        ]
    )  # (steps + 1, fingers, 3)
    travel = tips[-1, :, :2] - tips[0, :, :2]
    inward = travel / np.linalg.norm(travel, axis=1, keepdims=True)
    # The fingers meet in the middle between the places to which they come in the end.
    middle = tips[-1, :, :2].mean(axis=0)
    gap = np.einsum("sfk,fk->sf", middle - tips[:, :, :2], inward)
    gap -= [finger.pad_ahead for finger in hand.fingers]
    before = gap >= half
    before[0] = True
    lowest = float(np.where(before, tips[:, :, 2], -np.inf).max())
    return Reach(lowest, 2.0 * float(gap[0].min()))


def _tip(posture: HandPosture, finger: Finger) -> np.ndarray:
    """The end of a finger in the palm frame (3,) [m]."""
    place, rotation = posture.link(finger.tip)
    return place + rotation @ np.array(finger.tip_position)
