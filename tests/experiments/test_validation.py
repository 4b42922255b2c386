"""The validation's short form passes, and each of its checks fails on physics that is wrong."""

import csv
import math
import subprocess
import sys

import pytest

from experiments.validation import __main__ as validation
from experiments.validation.result_rows import Result, Row, threshold
from experiments.validation.rigs import Spoil, settings_for
from tests.support.repository import ROOT

# For every check, a falsification of the model that it must notice.
WRONG = {
    "pad_onset": Spoil(friction=1.05),
    "clamp_drop": Spoil(friction=0.95),
    "torsion_onset": Spoil(friction=1.1),
    "torsion_overload": Spoil(friction=1.02),
    "friction_creep": Spoil(impratio=1.1),
    "single_finger": Spoil(torque=1.1),
    "two_pads": Spoil(torque=0.9),
    "tactile_total": Spoil(torque=1.05),
    "whole_grasp": Spoil(gravity=0.5),
    "plate": Spoil(stiffness=1.05),
    "ball": Spoil(stiffness=1.3),
    "modulus": Spoil(torque=1.05),
    "recoil": Spoil(stiffness=1.3),
    "release": Spoil(gravity=1.01),
    "numerics": Spoil(stiffness=0.02),
    "turning_base": Spoil(stiffness=1.3),
    "carry": Spoil(implicit=True),
    "sensor_creep": Spoil(creep=1.2),
    "jaw_force": Spoil(torque=1.01),
    "jaw_torsion": Spoil(friction=1.1),
    "jaw_creep": Spoil(impratio=1.1),
    "jaw_step": Spoil(torque=1.01),
}


def test_every_check_has_a_falsification():
    assert set(WRONG) == set(validation.CHECKS)


@pytest.mark.parametrize("name", list(validation.CHECKS))
def test_a_check_notices_wrong_physics(name):
    result = validation.CHECKS[name][1](True, WRONG[name])
    assert not result.passed


def test_short_form_passes_and_leaves_table_and_pictures(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "experiments.validation", "--short", "--out", str(tmp_path)],
        cwd=ROOT, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FAIL" not in done.stdout
    for title, _ in validation.CHECKS.values():
        assert title in done.stdout
    with (tmp_path / "validation.csv").open(encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert {line["check"] for line in lines} == set(validation.CHECKS)
    for line in lines:
        assert line["reason"]
        assert math.isfinite(float(line["simulated"]))
    pictures = {path.stem for path in tmp_path.glob("*.png")}
    assert {"pad_onset", "clamp_drop", "torsion_onset", "ball", "single_finger"} <= pictures


def test_the_fast_preset_passes_with_its_own_time_step(monkeypatch):
    seen = []
    name, check = validation.CHECKS["plate"]

    def watched(short, spoil):
        seen.append(settings_for().timestep)
        return check(short, spoil)

    monkeypatch.setitem(validation.CHECKS, "plate", (name, watched))
    assert validation.main(["--short", "--preset", "fast", "--only", "plate"]) == 0
    assert validation.main(["--short", "--only", "plate"]) == 0
    assert seen == [0.004, 0.002]


def test_a_failing_line_is_shown_and_gives_exit_status_1(monkeypatch, capsys):
    def broken(short, spoil):
        return Result((Row("nothing", "N", 1.0, 1.2, 0.1, "made up"),))

    monkeypatch.setitem(validation.CHECKS, "plate", ("Broken on purpose", broken))
    assert validation.main(["--short", "--only", "plate"]) == 1
    shown = capsys.readouterr().out
    assert "FAIL" in shown
    assert "+20.0 %" in shown
    assert "0 of 1 lines pass" in shown


def test_a_noted_line_decides_nothing(monkeypatch, capsys):
    def odd(short, spoil):
        known = [Row("known", "N", 1.0, 1.2, bound, "", judged=False) for bound in (0.1, 0.3)]
        return Result(tuple(known))

    monkeypatch.setitem(validation.CHECKS, "plate", ("Odd", odd))
    assert validation.main(["--short", "--only", "plate", "--reasons"]) == 0
    assert "0 of 0 lines pass; 2 noted, 1 of them beyond" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("predicted", "simulated", "scale", "deviation", "passed"),
    [
        (2.0, 2.1, None, 0.05, True),
        (2.0, 2.3, None, 0.15, False),
        (-2.0, -2.3, None, -0.15, False),
        (0.0, 0.5, 10.0, 0.05, True),
        (0.0, 0.5, None, math.nan, False),  # nothing to measure against is no pass
        (2.0, math.nan, None, math.nan, False),
    ],
)
def test_rows_judge_by_their_scale(predicted, simulated, scale, deviation, passed):
    row = Row("x", "N", predicted, simulated, 0.1, "", scale)
    assert row.deviation == pytest.approx(deviation, nan_ok=True)
    assert row.passed is passed


def test_threshold_finds_the_change_or_says_that_there_is_none():
    assert threshold(lambda x: x > 0.3141, 0.1, 1.0, 1e-5) == pytest.approx(0.3141, abs=1e-5)
    assert math.isnan(threshold(lambda x: x > 3.0, 0.1, 1.0))
    assert math.isnan(threshold(lambda x: x > 0.01, 0.1, 1.0))
