"""Users' metrics in whole runs: the table, the comparison, the command line."""

from __future__ import annotations

import functools
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from sdh_sim import records
from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.study import read_study
from sdh_sim.analysis.trial_tables import user_metrics as stated
from sdh_sim.campaign import run_campaign
from sdh_sim.cli import lift as cli_lift
from sdh_sim.cli.app import main
from sdh_sim.errors import RunError
from sdh_sim.records import FAILURES, METRIC_ERROR, added_columns
from sdh_sim.runs import RunFolder, RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import UserMetric
from tests.support import trial_stand_ins as stand_ins
from tests.support.metric_files import find, metric_file, plan_with, with_metrics


@pytest.fixture
def file(tmp_path) -> Path:
    return metric_file(tmp_path)


def test_the_table_is_the_same_however_it_came_about(tmp_path, file):
    first, second = tmp_path / "first", tmp_path / "second"
    run_campaign(plan_with(file, 20), first, 1, trial=with_metrics)
    run_campaign(plan_with(file, 7), second, 2, trial=with_metrics, save_every=0.0)
    run_campaign(plan_with(file, 20), second, 2, trial=with_metrics, resume=True)
    table = first / "trials.parquet"
    assert table.read_bytes() == (second / "trials.parquet").read_bytes()
    schema = pq.read_schema(table)
    assert schema.names == [
        *(c.name for c in records.COLUMNS),
        *("metric_raises", "metric_thumb", METRIC_ERROR),
    ]
    assert schema.field("metric_thumb").metadata[b"threshold"] == b"3.0"
    rows = records.read_rows(table)
    assert {row["failure"] for row in rows} > {"error", "none"}
    for row in rows:
        q = row["q_linf"]
        wanted = None if q is None or row["seed"] % 5 == 1 else q + 1
        assert row["metric_thumb"] == wanted
    with pytest.raises(RunError, match=r"other settings: metrics \(run: raises .*, asked: none\)"):
        run_campaign(
            RunPlan(("box", "oval_bottle"), TrialSettings("box"), 20, 0), first, resume=True
        )


def test_rows_of_other_metrics_are_refused(tmp_path, file):
    row = records.normalise(
        {**stand_ins.make_row("box", 1), "trial": 0, "metric_thumb": 1.0, "metric_new": 2.0}
    )
    with pytest.raises(records.RecordError, match="'metric_new', which this table has not"):
        records.write_rows([row], tmp_path / "t", added_columns(find(file, "thumb")))
    with pytest.raises(records.RecordError, match="unknown column 'metric_Big'"):
        records.normalise({**stand_ins.make_row("box", 1), "trial": 0, "metric_Big": 1.0})
    with pytest.raises(records.RecordError, match="column 'metric_thumb' got 'x'"):
        records.normalise({**stand_ins.make_row("box", 1), "trial": 0, "metric_thumb": "x"})


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A run, not to be changed."""
    folder = tmp_path_factory.mktemp("metrics")
    run_campaign(plan_with(metric_file(folder), 30), folder / "run", 1, trial=with_metrics)
    return folder / "run"


@pytest.fixture
def run(finished, tmp_path) -> Path:
    return Path(shutil.copytree(finished, tmp_path / "run"))


def test_compare_shows_metrics_beside_q(run, capsys):
    study = read_study([run / "trials.parquet"], compare.METRICS, 50)
    assert study.metrics == ("q_linf", "q_l1", "metric_raises", "metric_thumb")
    rows = [r for r in records.read_rows(run / "trials.parquet") if r["failure"] in FAILURES[:5]]
    have = [r for r in rows if r["metric_thumb"] is not None]
    thumb = study.findings["overall", "metric_thumb"].comparison
    assert thumb.threshold == 3.0
    assert thumb.has_boundary
    assert (thumb.n, thumb.missing) == (len(have), len(rows) - len(have))
    assert thumb.missing > 0
    assert thumb.tp == sum(r["metric_thumb"] > 3.0 and r["success"] for r in have)
    assert thumb.fn == sum(r["metric_thumb"] <= 3.0 and r["success"] for r in have)
    scores = np.array([r["metric_thumb"] for r in have])
    success = np.array([r["success"] for r in have])
    assert thumb.auc == compare.auc(scores, success)
    assert not study.findings["overall", "metric_raises"].comparison.has_boundary

    assert main(["compare", str(run)]) == 0
    out = capsys.readouterr().out
    assert re.search(r"thumb +\d+ \(", out)
    assert re.search(r"raises +- +- +- +0\.\d\d \(", out)
    assert "thumb: success is predicted above 3." in out
    assert "raises states no threshold" in out
    assert f"{thumb.missing} trials without thumb are left out" in out
    assert "thumb" in (run / "report" / "index.html").read_text()
    assert "metric_thumb" in (run / "report" / "summary.csv").read_text()


def test_tables_that_disagree_on_a_threshold_state_none(tmp_path, file):
    (thumb,) = find(file, "thumb")
    row = {**stand_ins.make_row("box", 1), "trial": 0, "metric_thumb": 1.0}
    paths = [tmp_path / f"{k}.parquet" for k in range(3)]
    for path, threshold in zip(paths, (3.0, 4.0, None), strict=True):
        other = UserMetric(thumb.name, thumb.target, thumb.sha256, threshold)
        records.write_rows([row], path, added_columns([other]))
    assert stated(paths[:1]) == {"metric_thumb": 3.0}
    assert stated(paths[:2]) == {"metric_thumb": None}
    assert stated(paths) == {"metric_thumb": None}
    plain_path = tmp_path / "plain.parquet"
    records.write_rows([{**stand_ins.make_row("box", 1), "trial": 0}], plain_path)
    assert stated([paths[0], plain_path]) == {}


def test_code_that_a_folder_names_is_not_run(tmp_path, run, capsys):
    marker = tmp_path / "ran"
    evil = tmp_path / "evil.py"
    evil.write_text(f"open({str(marker)!r}, 'w').close()\ndef thumb(grasp): return 1.0\n")
    info = json.loads((run / "run.json").read_text())
    for metric in info["settings"]["metrics"]:
        metric["target"] = f"{evil}:{metric['name']}"
    (run / "run.json").write_text(json.dumps(info))
    plan = RunFolder(run).read_plan()
    number = next(r["trial"] for r in records.read_rows(run / "trials.parquet"))
    assert main(["show", str(run), "--trial", str(number), "--save", str(tmp_path / "t.rrd")]) == 0
    assert main(["compare", str(run), "--no-report"]) == 0
    capsys.readouterr()
    assert main(["lift", "--resume", "--trials", "31", "--out", str(run)]) == 2
    assert "name the code yourself with --metric" in capsys.readouterr().err
    with pytest.raises(Exception, match="is known from a file alone"):
        run_campaign(RunPlan(plan.objects, plan.settings, 31, plan.seed), run, resume=True)
    assert not marker.exists()


def test_lift_warns_and_goes_on(tmp_path, file, monkeypatch, capsys):
    monkeypatch.setattr(
        cli_lift, "run_campaign", functools.partial(run_campaign, trial=with_metrics)
    )
    out = tmp_path / "out"
    given = ["--metric", f"{file}:thumb", "--metric", f"{file}:raises"]
    lift = ["lift", "--object", "box", "--workers", "1", "--out", str(out)]
    assert main([*lift, "--trials", "10", *given]) == 0
    notes = [r[METRIC_ERROR] or "" for r in records.read_rows(out / "trials.parquet")]
    failed = sum("thumb" in note for note in notes)
    assert failed > 0
    warning = f"warning: metric thumb failed in {failed} of 10 trials, the first time with Value"
    assert warning in capsys.readouterr().err
    assert main(["lift", "--resume", "--trials", "12", "--out", str(out), *given]) == 0
    assert main([*lift[:-1], str(tmp_path / "x"), "--metric", "duck"]) == 2
    assert "--metric: got 'duck'; there is no entry point" in capsys.readouterr().err
