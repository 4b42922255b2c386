"""The study of the table in the grasp, on a real trial and on a table made by hand."""

from __future__ import annotations

from dataclasses import replace

import pyarrow as pa
import pytest

from experiments import release
from sdh_sim.records import LIFT_OFF
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial
from tests.support.run_folders import write_run_of

SETTINGS = TrialSettings("box", grasps="precision", pads="distal", lift_off=True, settle="metrics")


@pytest.fixture(scope="module")
def row():
    """A grasp that holds, and has left the table."""
    found = run_trial(SETTINGS, 3).row
    assert found["success"], "take another seed"
    assert found[LIFT_OFF + "on_table"] is False
    return {name: value for name, value in found.items() if value is not None}


def test_the_study_prints_and_draws(row, tmp_path, capsys):
    fell = {"success": False, "failure": "dropped"}
    stayed = {**fell, LIFT_OFF + "on_table": True}
    rows = [row, row, {**row, **fell}, {**row, **stayed}]
    run = write_run_of(rows, SETTINGS, tmp_path / "run")
    release.main([str(run)])
    printed = capsys.readouterr().out
    for text in ("at lift-off", "where it settles", "settling", "left the table"):
        assert text in printed
    assert (run / "release" / "release.svg").stat().st_size > 5000


def test_a_run_without_both_options_is_refused(row, tmp_path, capsys):
    one = replace(SETTINGS, settle="none")
    lifted = {name: value for name, value in row.items() if "settled" not in name}
    out = write_run_of([lifted], one, tmp_path / "run")
    with pytest.raises(SystemExit):
        release.main([str(out)])
    assert "--settle metrics" in capsys.readouterr().err


def test_the_verdict_ranks_by_what_it_says_and_then_by_motion():
    table = pa.table(
        {
            "success": [True, True, False, False],
            "failure": ["none", "none", "dropped", "unstable_simulation"],
            "settled": pa.array([True, False, False, True], pa.bool_()),
            "settled_displacement_mm": [3.0, 11.0, 20.0, 0.0],
            "settled_rotation_deg": [1.0, 1.0, 1.0, 0.0],
        }
    )
    found = release.of_settling(table)
    assert (found.n, found.tp, found.fn, found.tn, found.auc) == (3, 1, 1, 1, 1.0)
