"""Closings: lines of postures within the joints' range, and which motors squeeze at their end."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sdh_sim.errors import SettingsError
from sdh_sim.robot import closing_between, preshape_closing
from sdh_sim.robot.sdh2_constants import PRESHAPES
from tests.support.sdh2 import MOTOR_NAMES

OPEN = np.array([0.5, -0.8, 0.6, -0.8, 0.6, -0.8, 0.6])
CLOSED = np.array([0.5, 0.2, 0.6, 0.1, 0.8, 0.2, 0.2])


def test_angles_lie_on_the_line_finger_by_finger():
    closing = closing_between(OPEN, CLOSED)
    assert closing.angles(0.0) == pytest.approx(OPEN, abs=0)
    assert closing.angles(1.0) == pytest.approx(CLOSED, abs=1e-15)
    # Fingers in the order finger 1, finger 2, thumb.
    angles = closing.angles([0.0, 0.5, 1.0])
    assert angles[[5, 6]] == pytest.approx(OPEN[[5, 6]])
    assert angles[[1, 2]] == pytest.approx(0.5 * (OPEN + CLOSED)[[1, 2]])
    assert angles[[3, 4]] == pytest.approx(CLOSED[[3, 4]])


def test_motors_that_flex_squeeze():
    flexing = closing_between(OPEN, CLOSED).squeezes
    assert [MOTOR_NAMES[k] for k in np.flatnonzero(flexing)] == [
        *("finger2_proximal", "thumb_proximal", "thumb_distal", "finger1_proximal"),
    ]
    spread = closing_between(np.zeros(7), np.array([0.5, 0.1, 0, 0, 0, 0, 0]))
    assert np.flatnonzero(spread.squeezes).tolist() == [1]  # never the spread


@pytest.mark.parametrize("preshape", PRESHAPES)
def test_a_preshape_s_own_ends_give_its_own_closing(preshape):
    # Its largest travel takes as long per radian as that of the parallel preshape.
    known = preshape_closing(preshape)
    same = closing_between(known.open, known.closed)
    ratios = [0.1, 0.5, 0.9]
    assert same.angles(ratios) == pytest.approx(known.angles(ratios), abs=1e-15)
    assert same.squeezes.tolist() == known.squeezes.tolist()
    fastest = math.radians(82) * 0.6  # 0.859 rad/s
    assert same.rate * np.abs(known.travel).max() == pytest.approx(fastest)


@pytest.mark.parametrize(
    ("open", "closed", "words"),
    [
        (OPEN, OPEN, "closed: no finger joint flexes"),
        (CLOSED, OPEN * 0 + CLOSED - 0.1, "no finger joint flexes"),
        (OPEN[:6], CLOSED, "open: got"),
        (OPEN, [*CLOSED[:6], math.nan], "closed: got"),
        (OPEN, "shut", "closed: got 'shut'"),
        (OPEN, [0.5, 2.0, 0, 0, 0, 0, 0], "got 2 for finger2_proximal; its range is -1.571 to"),
        ([-0.1, *OPEN[1:]], CLOSED, "got -0.1 for spread; its range is 0 to 1.571"),
    ],
)
def test_what_is_no_closing_is_refused(open, closed, words):
    with pytest.raises(SettingsError, match=words.replace("(", r"\(")):
        closing_between(open, closed)


def test_an_unknown_preshape_is_refused():
    with pytest.raises(SettingsError, match="got 'fist'; choose one of parallel, "):
        preshape_closing("fist")
