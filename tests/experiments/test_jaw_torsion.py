"""The study of weights beside the pinch line, against a pinch worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

import graspq as gq
from experiments import jaw_torsion
from sdh_sim.objects import object_info
from sdh_sim.sensing import PadContact, PerceivedGrasp
from tests.support import sdh2

ARM = 0.01
WEIGHT = np.array([0.0, 0.0, -2.0])


def contact(side: float) -> gq.Contact:
    """A pad at x = ±20 mm with friction 0.5, 10 N and taxels on a circle of 10 mm."""
    angles = np.radians(np.arange(0, 360, 30))
    patch = np.column_stack((0 * angles, ARM * np.cos(angles), ARM * np.sin(angles)))
    centre = np.array([0.02 * side, 0.0, 0.0])
    normal = np.array([-side, 0.0, 0.0])
    return gq.Contact(centre, normal, 0.5, 10.0, 0.5 * 10.0 * ARM, patch + centre)


@pytest.fixture
def pinch() -> jaw_torsion.Pinch:
    return jaw_torsion.pinch_of(contact(-1.0), contact(1.0))


@pytest.mark.parametrize(
    ("point", "distance", "load"),
    [
        ((0.0, 0.0, 0.0), 0.0, 2.5),  # friction bears 0.5 · 10 N of 2 N
        ((0.01, 0.0, 0.03), 0.0, 2.5),  # along the line and above it
        ((0.0, 0.01, 0.0), 1.0, 2.5 / math.sqrt(2)),
        ((0.0, -0.03, 0.01), 3.0, 2.5 / math.sqrt(10)),
    ],
)
def test_the_ellipse_of_shear_and_torsion(pinch, point, distance, load):
    assert pinch.arm == pytest.approx(ARM)
    assert pinch.distance(np.array(point), WEIGHT) == pytest.approx(distance)
    assert pinch.ellipse(np.array(point), WEIGHT) == pytest.approx(load)


def test_weight_along_the_pinch_line_needs_no_friction(pinch):
    askew = np.array([1.6, 0.0, -1.2])
    assert pinch.ellipse(np.zeros(3), askew) == pytest.approx(5.0 / 1.2)
    assert pinch.distance(pinch.beside(2.0, askew), askew) == pytest.approx(2.0)


def test_l1_moves_both_pressures_under_the_weight(pinch):
    pads = [PadContact("pad", contact(side), np.zeros((6, 7))) for side in (-1.0, 1.0)]
    nothing = sdh2.snapshot(
        np.zeros((3, 14, 6)), np.zeros((3, 13, 6)), np.zeros(7), np.zeros(7), np.zeros(7),
        np.zeros(7),
    )  # fmt: skip
    task = np.zeros((6, 1))
    grasp = PerceivedGrasp(nothing, object_info("box"), np.ones(7), tuple(pads), task)
    # A taxel of either pad is at one arm beside the line: the weight costs no torsion there.
    at_one, at_four = (pinch.beside(distance, WEIGHT) for distance in (1.0, 4.0))
    assert jaw_torsion.l1(grasp, at_one, WEIGHT) == pytest.approx(2.5, rel=0.04)
    # Shear from -1 to 1 arms: forces (1 + 4) / 2 and (1 - 4) / 2 times the weight, 4 in all.
    assert jaw_torsion.l1(grasp, at_four, WEIGHT) == pytest.approx(2.5 / 4, rel=0.04)


def test_the_study_runs(capsys):
    jaw_torsion.main(["--draws", "1", "--seed", "12", "--speed", "8"])
    printed = capsys.readouterr().out
    assert "of 4 grasps are by pads alone" in printed
    assert "beside the pinch line" in printed
    assert "own weight" in printed


@pytest.mark.parametrize("arguments", [["--draws", "0"], ["--speed", "0"], ["--timestep", "1"]])
def test_options_out_of_range_are_refused_in_one_line(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        jaw_torsion.main(arguments)
    assert stop.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
