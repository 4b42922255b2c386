"""One motor that moves several fingers: closing, squeezing and the arc, on the parallel jaw."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.grasping.finger_control import SQUEEZE_DEMAND, SQUEEZE_TIME, FingerControl
from sdh_sim.robot import built_in_hand

JAW = built_in_hand("parallel_jaw")
LIMIT, KP, DAMPING = 40.0, 5e3, 60.0
TICK = 0.01


def control(ratio: float = 0.0) -> FingerControl:
    return FingerControl(
        JAW, JAW.closing("parallel"), ratio,
        np.array([LIMIT]), np.array([KP]), np.array([DAMPING]),
    )  # fmt: skip


def test_fingers_on_one_motor_are_joined():
    assert JAW.joined_fingers.all()
    sdh = built_in_hand("schunk_sdh2")
    assert sdh.joined_fingers.tolist() == np.eye(3, dtype=bool).tolist()


def test_the_motor_follows_one_ratio_whatever_the_number_of_fingers():
    closing = JAW.closing("parallel")
    assert closing.angles([0.5, 0.5]) == pytest.approx([0.035])
    assert closing.angles(0.25) == pytest.approx([0.0175])


def test_the_object_stops_both_fingers_at_once():
    fingers = control()
    for _ in range(20):
        fingers.close(np.array([3.0]), TICK)  # moving freely takes 60 N s/m x 50 mm/s
    assert not fingers.stalled.any()
    fingers.close(np.array([20.0]), TICK)
    assert fingers.stalled.all()
    assert fingers.closed


def test_the_squeeze_goes_on_while_the_object_moves_with_the_jaws():
    # The first pad pushes the object by 3 mm before the second meets it. In the end the reference
    # is ahead of where the jaws are held by what 1.25 times the limit takes.
    fingers = control(0.4)
    place, reference = 0.028, np.zeros(1)
    for tick in range(round(1.5 * SQUEEZE_TIME / TICK)):
        place = min(0.031, 0.028 + 1e-4 * tick)
        reference = fingers.squeeze(np.array([place]), TICK)
        assert reference[0] > place
    assert fingers.settled
    assert reference[0] == pytest.approx(0.031 + SQUEEZE_DEMAND * LIMIT / KP)
