"""Another hand from the command line: lifted, stored, looked at, compared apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sdh_sim.analysis.trial_tables import hand_of
from sdh_sim.cli import main
from sdh_sim.cli.app import one_by_one
from sdh_sim.metrics import evaluate, grasp_of
from sdh_sim.records import read_rows
from tests.support.command_line import fails
from tests.support.repository import ROOT


@pytest.fixture(scope="module")
def jaw(tmp_path_factory) -> Path:
    """A run of the parallel jaw."""
    out = tmp_path_factory.mktemp("hands") / "jaw"
    line = ["lift", "--hand", "parallel_jaw", "--torque-limit", "40", "--object", "box"]
    assert main([*line, "--trials", "2", "--seed", "1", "--workers", "1", "--out", str(out)]) == 0
    return out


def test_rows_have_the_hand_s_shapes(jaw):
    rows = read_rows(jaw / "trials.parquet")
    assert len(rows) == 2
    for row in rows:
        assert row["hand"] == "parallel_jaw"
        assert row["torque_limit_nm"].tolist() == [40.0]
        assert row["peak_torque_nm"] == pytest.approx([40.0], abs=1e-9)
        assert row["tactile_pad"].shape == (2, 14, 6)
        assert row["tactile_proximal"] is None
        assert row["failure"] != "no_contact"


def test_both_pads_press_with_half_the_motor_s_force(jaw):
    # By virtual work; what the pads do not feel is on the fingers' own surfaces.
    for row in read_rows(jaw / "trials.parquet"):
        both = row["sensed_force_n"] + row["unsensed_force_n"]
        assert both == pytest.approx(40.0, rel=0.2)


def test_a_stored_grasp_of_the_jaw_gives_its_metrics_again(jaw):
    row = read_rows(jaw / "trials.parquet")[0]
    grasp = grasp_of(row, "all")
    assert grasp is not None
    assert [p.pad for p in grasp.contacts] == ["left_pad", "right_pad"]
    assert grasp.contacts[0].jacobian.shape == (6, 1)
    values = evaluate(grasp)
    for name in ("q_linf", "q_l1", "q_capability"):
        assert values[name] == pytest.approx(row[name], rel=1e-6)


def test_with_one_motor_the_capability_is_the_sum_bound_in_the_limit(jaw):
    # Both pads share one force, so that their largest forces add up to one pad's: L1. It is less
    # where friction at one pad has to be borne by the other's normal force too.
    for row in read_rows(jaw / "trials.parquet"):
        assert row["q_capability"] <= row["q_l1"] * (1 + 1e-9)
        assert row["q_capability"] > 0.5 * row["q_l1"]
        assert row["q_l1"] <= row["q_linf"] <= 2.0 * row["q_l1"] * (1 + 1e-9)


def test_hands_are_compared_apart(jaw, tmp_path, capsys):
    sdh2 = tmp_path / "sdh2"
    assert main(["lift", "--object", "box", "--trials", "1", "--workers", "1", "--out",
                 str(sdh2)]) == 0  # fmt: skip
    assert [hand_of(run / "trials.parquet") for run in (jaw, sdh2)] == [
        "parallel_jaw",
        "schunk_sdh2",
    ]
    capsys.readouterr()
    words = fails(capsys, "compare", jaw, sdh2)
    assert "trials of different hands (parallel_jaw, schunk_sdh2)" in words
    assert main(["compare", str(jaw), str(sdh2), "--by-hand", "--no-report"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "parallel_jaw box" in printed
    assert "schunk_sdh2 box" in printed


def test_a_run_of_the_jaw_is_shown(jaw, tmp_path):
    recording, picture = tmp_path / "t.rrd", tmp_path / "t.png"
    assert main(["show", str(jaw), "--trial", "0", "--save", str(recording)]) == 0
    assert recording.stat().st_size > 50_000
    assert main(["show", str(jaw), "--trial", "0", "--png", str(picture)]) == 0
    from PIL import Image

    assert np.asarray(Image.open(picture)).std() > 10.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--hand", "nobody"], "--hand: got 'nobody'; choose one of parallel_jaw, schunk_sdh2"),
        (["--hand", "a b"], "--hand: got 'a b'"),
        (["--hand", "parallel_jaw", "--torque-limit", "1", "2"],
         "--torque-limit: got 2 for the hand parallel_jaw; give 1: grip"),
        (["--hand", "parallel_jaw", "--pads", "distal"],
         "--pads: got 'distal'; the hand parallel_jaw has all, pad"),
        (["--torque-limit", "1"], "--torque-limit: got (1.0,); give two torques"),
        (["--hand", "parallel_jaw", "--torque-limit", "5000"], "at most 1000"),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_hand_is_refused_before_anything_is_written(
    options, words, tmp_path, capsys
):
    out = tmp_path / "out"
    assert words in fails(capsys, "lift", "--object", "box", "--out", out, *options)
    assert not out.exists()


def test_files_of_grasps_are_for_the_sdh2(jaw, tmp_path, capsys):
    out = tmp_path / "g.csv"
    assert "has the hand parallel_jaw; files of grasps are for" in fails(
        capsys, "grasps", jaw, "--out", out
    )
    given = ROOT / "docs" / "examples" / "box_grasps.csv"
    line = ("lift", "--hand", "parallel_jaw", "--object", "box", "--grasps", given)
    assert "files have grasps of schunk_sdh2" in fails(capsys, *line, "--out", tmp_path / "run")
    assert not out.exists()
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("lift --x 2.1 1.4 --out o 3", "lift --x 2.1 --x 1.4 --out o 3"),
        ("lift --x 60", "lift --x 60"),
        ("--x 1 --x 2 -3", "--x 1 --x 2 --x -3"),
        ("--x --out 5", "--x --out 5"),
        ("--x=1 2", "--x=1 2"),
        ("lift 1 2", "lift 1 2"),
    ],
)
def test_an_option_with_several_numbers_is_given_again_for_each(given, expected):
    assert one_by_one(given.split(), "--x") == expected.split()
