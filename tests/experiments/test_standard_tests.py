"""Standard load protocols: closed forms on the hands of the models, and what a file may say."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from experiments.standard_tests import __main__ as command
from experiments.standard_tests import slip_resistance
from experiments.standard_tests.album import Album
from experiments.standard_tests.contact_forces import force_between_halves
from experiments.standard_tests.cylinder_grasp import styles, take
from experiments.standard_tests.finger_strength import (
    find_place,
    finger_strength,
    postures,
    press,
)
from experiments.standard_tests.grasp_strength import pinch_limit
from experiments.standard_tests.load_objects import CELL, pipe_mass, write_objects
from experiments.standard_tests.measured import check_conditions, read_measured
from experiments.standard_tests.result_lines import Line, csv_of
from experiments.standard_tests.slip_resistance import pull
from experiments.standard_tests.specimen import specimens
from experiments.standard_tests.touch_sensitivity import least_pressure, touch_sensitivity
from sdh_sim.errors import SettingsError
from sdh_sim.objects import object_info, object_names, user_object
from tests.support.hand_folders import write_hand
from tests.support.repository import ROOT

ACROSS = np.array([1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    return write_objects(tmp_path_factory.mktemp("objects"))


@pytest.fixture(scope="module")
def sdh2():
    return specimens(None, "yield")[0]


def test_the_cylinders_are_objects_of_a_user(folders):
    found = user_object(folders["pipe_60"])
    info = object_info(found.name, found.reference)
    assert info.extents_m == pytest.approx((0.0603, 0.0603, 0.2), abs=1e-4)
    assert info.mass_kg == pytest.approx(5.44 * 0.2, rel=0.01)  # 5.44 kg/m of such a pipe
    assert pipe_mass("pipe_89") == pytest.approx(11.29 * 0.2, rel=0.01)
    assert "pipe_60" not in object_names()


def test_a_straight_finger_presses_with_its_limit_over_its_length(folders, sdh2):
    rig = sdh2.rig(folders[CELL])
    angles = postures(sdh2.hand)["straight"]
    place = find_place(rig, 2, angles)
    lever = 0.155 - 0.005  # proximal axis to where the button is, 5 mm before the end [m]
    assert abs(place.levers[3]) == pytest.approx(lever, abs=5e-4)
    assert abs(place.levers[4]) == pytest.approx(lever - 0.0865, abs=5e-4)
    force = press(rig, angles, place, 2.1 / lever * place.levers)
    assert force == pytest.approx(2.1 / lever, rel=0.02)


def test_a_pinch_presses_with_the_weaker_side(folders, sdh2):
    held = take(sdh2, folders["pipe_60"], styles(sdh2.hand, 0.03015)[0], 0)
    assert not isinstance(held, str)
    force = force_between_halves(held.found, held.centre, ACROSS)
    assert force == pytest.approx(pinch_limit(sdh2, held), rel=0.03)
    height = held.centre[2] - 0.091  # of the thumb's proximal axis [m]
    assert force == pytest.approx(2.1 / height, rel=0.08)
    assert force == pytest.approx(force_between_halves(held.found, held.centre, -ACROSS), rel=1e-3)


def test_locked_gears_let_the_stronger_side_press(folders):
    locked = specimens(None, "lock")[0]
    held = take(locked, folders["pipe_60"], styles(locked.hand, 0.03015)[0], 0)
    assert not isinstance(held, str)
    force = force_between_halves(held.found, held.centre, ACROSS)
    assert force == pytest.approx(pinch_limit(locked, held), rel=0.1)
    assert force > 1.7 * 2.1 / (held.centre[2] - 0.091)  # two fingers against one that bears them


def test_a_jaw_presses_with_half_its_force_and_slips_at_friction_times_both(folders, monkeypatch):
    monkeypatch.setattr(slip_resistance, "SPEED", 0.02)
    jaw = specimens("parallel_jaw", "yield")[0]
    (style,) = styles(jaw.hand, 0.03015)
    held = take(jaw, folders["pipe_60"], style, 0)
    assert not isinstance(held, str)
    force = force_between_halves(held.found, held.centre, ACROSS)
    assert force == pytest.approx(50.0, rel=0.01)
    assert pull(held).peak == pytest.approx(0.6 * 100.0, rel=0.05)


@pytest.mark.parametrize("drive", ["yield", "lock"])
def test_a_users_hand_on_a_tendon_presses_with_its_motor(folders, tmp_path, drive):
    own = specimens(str(write_hand(tmp_path / "gripper")), drive)[0]
    lines = finger_strength(own, folders[CELL], Album(False))
    assert len(lines) == 4  # two jaws, straight and bent
    for line in lines:  # the tendon is as long as both jaws' mean way, so one jaw takes all of it
        assert line.closed == pytest.approx(60.0, rel=1e-3)
        assert line.simulated == pytest.approx(60.0, rel=0.03)


def test_a_slow_finger_reads_at_its_dead_zone(folders, sdh2):
    lines = touch_sensitivity(sdh2, folders[CELL], 0, Album(False))
    assert [line.agrees for line in lines] == [True, None, None]
    forces = [line.simulated for line in lines]
    assert forces == sorted(forces)
    assert least_pressure() == pytest.approx(7.7e3, rel=0.01)  # 3.6 kPa, 2.14 times for creep [Pa]


MEASURED = """hand: the hand of a test
values:
  finger_strength:
    thumb, straight, whole finger: 12.8 N
"""


def test_measured_values_are_read(tmp_path):
    path = tmp_path / "measured.yaml"
    path.write_text(MEASURED)
    name, found = read_measured(path)
    assert name == "the hand of a test"
    key = ("finger_strength", "thumb, straight, whole finger")
    assert found == {key: 12.8}
    line = Line(*key[:1], "hand", key[1], 14.0, 13.9)
    table = csv_of([line], found).splitlines()
    assert table[1].split(",")[-2] == "12.8"
    assert len(table) == 2
    check_conditions(path, found, [key])
    with pytest.raises(SettingsError, match=r"unknown condition 'thumb, .*nearest is 'thumb, b"):
        check_conditions(path, found, [(key[0], "thumb, bent, whole finger")])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("colour: red\n", "unknown key 'colour'; known are hand, values"),
        ("hand: [1]\nvalues: {}\n", "hand: got"),
        ("hand: x\n", "values: got None; give conditions under finger_strength"),
        ("values:\n  grip: {}\n", "unknown protocol 'grip'; known are finger_strength"),
        ("values:\n  finger_strength: 3 N\n", "finger_strength: got '3 N'; give conditions"),
        ("values:\n  finger_strength:\n    a: 3\n", "a: got '3'; give a number and its unit, as"),
        ("values:\n  finger_strength:\n    a: 3 kg\n", "a: got the unit 'kg'; give N"),
        ("values:\n  finger_strength:\n    a: much N\n", "a: got 'much'; give a number of at leas"),
        ("values:\n  finger_strength:\n    a: -3 N\n", "a: got '-3'; give a number of at least 0"),
        ("values:\n  finger_strength:\n    a: .inf N\n", "a: got '.inf'; give a number"),
        ("- 1\n", "expected the keys hand and values"),
        ("a: [\n", "is not YAML"),
    ],
)
def test_a_file_of_measured_values_is_refused_in_one_line(
    tmp_path, capsys, monkeypatch, text, words
):
    path = tmp_path / "measured.yaml"
    path.write_text(text)
    monkeypatch.setattr(sys, "argv", ["standard_tests/__main__.py"])
    with pytest.raises(SystemExit) as ended:
        command.main(["--measured", str(path), "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(f"standard_tests: --measured: {path}: ")
    assert words in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--hand", "nowhere"], "hand: got 'nowhere'; choose one of"),
        (["--hand", "./nowhere"], "nowhere"),
        (["--measured", "nowhere.yaml"], "--measured: nowhere.yaml: No such file or directory"),
        (["--seed", "-1"], "--seed must be at least 0, got -1"),
    ],
)
def test_options_that_cannot_be_used_are_one_line(tmp_path, capsys, monkeypatch, options, words):
    monkeypatch.setattr(sys, "argv", ["standard_tests/__main__.py"])
    with pytest.raises(SystemExit) as ended:
        command.main([*options, "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_the_page_says_what_the_tests_find():
    page = (ROOT / "docs" / "standard_tests.md").read_text(encoding="utf-8")
    for line in ("14.0", "SP 1227", "WK83863", "--measured"):
        assert line in page


def test_lines_without_a_closed_form_agree_with_nothing():
    assert Line("grasp_strength", "hand", "wrap", math.nan, 3.0, 0.05).agrees is None
    assert Line("grasp_strength", "hand", "pinch", 3.0, 3.3, 0.05).agrees is False
