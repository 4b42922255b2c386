"""The study of the table in the grasp, on a real run and on a table made by hand."""

from __future__ import annotations

import pyarrow as pa
import pytest

from experiments import release
from sdh_sim.cli import main


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory):
    out = tmp_path_factory.mktemp("release") / "run"
    lift = ["lift", "--object", "box", "--trials", "4", "--seed", "20261129", "--workers", "1"]
    more = ["--grasps", "precision", "--pads", "distal", "--lift-off", "--settle", "metrics"]
    assert main([*lift, *more, "--out", str(out)]) == 0
    return out


def test_the_study_prints_and_draws(run, capsys):
    release.main([str(run)])
    printed = capsys.readouterr().out
    for text in ("at lift-off", "where it settles", "settling", "left the table"):
        assert text in printed
    assert (run / "release" / "release.svg").stat().st_size > 5000


def test_a_run_without_both_options_is_refused(tmp_path, capsys):
    out = tmp_path / "run"
    lift = ["lift", "--object", "box", "--trials", "1", "--lift-off", "--workers", "1"]
    assert main([*lift, "--out", str(out)]) == 0
    capsys.readouterr()
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
