"""What carries the hand: the arm, or a floating base where there is none."""

from __future__ import annotations

from functools import lru_cache

import mujoco

from sdh_sim.robot.arm import ArmKinematics, arm_spec, cell_spec
from sdh_sim.robot.floating_base import FloatingBase, add_floating_base
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.palm_motion import PalmMotion

NO_ARM = "none"  # among the settings' kinds of arm


def carrier_spec(arm: str) -> mujoco.MjSpec:
    """Table and what carries the hand, of one of the settings' kinds of arm."""
    if arm != NO_ARM:
        return arm_spec()
    spec = cell_spec()
    add_floating_base(spec)
    return spec


def palm_motion_of(arm: str, hand: Hand) -> PalmMotion:
    """Motion of what carries a hand, of one of the settings' kinds of arm; built once."""
    return _motion(arm == NO_ARM, hand)


@lru_cache(maxsize=8)
def _motion(floating: bool, hand: Hand) -> PalmMotion:
    return FloatingBase(hand) if floating else ArmKinematics(hand)
