"""Verdicts at the edges of their thresholds, and what counts as motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sdh_sim.trial import Motion, classify
from sdh_sim.trial.outcome import moved_between

NO_COM = np.zeros(3)
HOME = np.array([0.1, -0.2, 0.3, 1.0, 0, 0, 0])


def turned(angle: float, axis: tuple[float, float, float], at=(0.0, 0.0, 0.0)) -> np.ndarray:
    half = 0.5 * angle
    return np.array([*at, math.cos(half), *(math.sin(half) * np.array(axis))])


@pytest.mark.parametrize(
    ("fell", "moved", "rotation", "verdict"),
    [
        (False, 0.0, 0.0, "none"),
        (False, 10.0, 10.0, "none"),  # within 10 mm and 10 degrees: the edge is inside
        (False, np.nextafter(10.0, 11.0), 0.0, "slipped"),
        (False, 0.0, np.nextafter(10.0, 11.0), "rotated"),
        (False, 11.0, 11.0, "slipped"),
        (True, 0.0, 0.0, "dropped"),
        (True, 50.0, 50.0, "dropped"),
        (False, math.nan, 0.0, "unstable_simulation"),
        (False, 0.0, math.nan, "unstable_simulation"),
        (True, math.nan, math.nan, "unstable_simulation"),
        (False, math.inf, 0.0, "unstable_simulation"),
    ],
)
def test_verdicts(fell, moved, rotation, verdict):
    assert classify(Motion(moved, rotation, fell)) == verdict


def test_no_motion():
    assert moved_between(HOME, HOME, np.array([0.01, 0.02, 0.03])) == pytest.approx(
        (0.0, 0.0), abs=1e-5
    )


def test_translation_is_in_millimetres_and_does_not_turn():
    now = HOME.copy()
    now[:3] += (0.003, -0.004, 0.012)  # 3, 4, 12: 13
    assert moved_between(HOME, now, np.array([0.5, 0, 0])) == pytest.approx((13.0, 0.0), abs=1e-5)


@pytest.mark.parametrize("degrees", [1.0, 10.0, 90.0, 179.0])
def test_rotation_about_the_centre_of_mass_moves_nothing(degrees):
    com = np.array([0.02, -0.01, 0.05])
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    angle = math.radians(degrees)
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    # The frame's origin goes round the centre of mass, which stays.
    before = turned(0.0, (0, 0, 1), at=(0.3, 0.1, 0.2))
    now = turned(angle, tuple(axis), at=before[:3] + com - rotation @ com)
    moved, angle_seen = moved_between(before, now, com)
    assert moved == pytest.approx(0.0, abs=1e-9)
    assert angle_seen == pytest.approx(degrees, abs=1e-5)


def test_rotation_about_the_frame_moves_the_centre_of_mass_by_the_chord():
    # 100 mm from the axis, 60 degrees: a chord of 100 mm.
    now = turned(math.radians(60), (0, 0, 1))
    moved, angle = moved_between(turned(0.0, (0, 0, 1)), now, np.array([0.1, 0, 0]))
    assert moved == pytest.approx(100.0)
    assert angle == pytest.approx(60.0)


def test_relative_turn_between_two_oblique_poses():
    # About the same axis from 70 to 95 degrees: 25 between them.
    axis = (0.6, 0.0, 0.8)
    before, now = turned(math.radians(70), axis), turned(math.radians(95), axis)
    assert moved_between(before, now, NO_COM) == pytest.approx((0.0, 25.0), abs=1e-6)


def test_a_quaternion_and_its_negative_are_the_same_pose():
    now = turned(math.radians(30), (0, 1, 0))
    now[3:] *= -1.0
    assert moved_between(turned(0.0, (0, 1, 0)), now, NO_COM)[1] == pytest.approx(30.0)


def test_a_lost_number_is_not_a_small_motion():
    now = HOME.copy()
    now[1] = math.nan
    assert math.isnan(moved_between(HOME, now, NO_COM)[0])
