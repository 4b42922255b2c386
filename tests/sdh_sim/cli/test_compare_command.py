"""``compare``: its tables and CSV, what it says of runs that are not whole, what it refuses."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from sdh_sim.cli.app import main
from sdh_sim.records import read_rows, read_table, write_rows
from sdh_sim.runs.shards import ShardWriter
from tests.support.command_line import fails
from tests.support.repository import ROOT


@pytest.fixture
def mixed(tmp_path) -> Path:
    """A table whose comparison was worked out by hand."""
    values = [
        ("box", "none", 2.0, 1.2),
        ("box", "none", 0.9, 0.4),
        ("box", "slipped", 1.2, 0.3),
        ("box", "dropped", 0.5, 0.2),
        ("box", "no_contact", None, None),
        ("box", "unstable_simulation", 7.0, 7.0),
        ("oval_bottle", "none", 1.5, 0.7),
    ]
    rows = [
        {"trial": i, "object": o, "seed": i, "success": f == "none", "failure": f}
        | {"q_linf": a, "q_l1": b}
        for i, (o, f, a, b) in enumerate(values)
    ]
    write_rows(rows, tmp_path / "mixed.parquet")
    return tmp_path / "mixed.parquet"


def test_compare_prints_and_writes_the_numbers(mixed, tmp_path, capsys):
    target = tmp_path / "new" / "numbers.csv"
    assert main(["compare", str(mixed), "--csv", str(target)]) == 0
    printed = capsys.readouterr().out
    (box,) = (line for line in printed.splitlines() if line.strip().startswith("box"))
    # 5 trials: accuracy 3/5, TPR 1/2, FPR 1/3, AUC 5/6
    assert re.split(r"\s{2,}", box.strip())[:4] == ["box", "5", "40 %", "q* L∞"]
    assert re.findall(r"([\d.]+) \(", box) == ["60", "50", "33", "0.83"]
    (bottle,) = (line for line in printed.splitlines() if line.strip().startswith("oval"))
    assert bottle.split()[-2:] == ["-", "-"]
    assert "1 trials without q* count as q* = 0" in printed
    assert "1 trials left out" in printed
    # Without the one that never touched: L∞ is right on 2 of 4, L1 on 3 of 4.
    assert (
        "In 1 of 5 trials (box) the hand did not touch the object (no_contact). Without them 4 "
        "remain, and the accuracy is q* L∞ 50 (15–85) %, q* L1 75 (30–95) %."
    ) in printed
    assert "warning: box: trials without contact carry the accuracy" in printed
    assert "-: undefined" in printed
    with open(target, newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["object"] for row in table] == [
        name for name in ("box", "oval_bottle", "overall") for _ in range(2)
    ]
    assert float(table[0]["auc"]) == pytest.approx(5 / 6)
    assert table[2]["auc"] == table[2]["false_positive_rate"] == ""
    assert (table[4]["n"], table[4]["unstable_excluded"]) == ("6", "1")
    assert (table[0]["no_contact"], table[0]["accuracy_touching"]) == ("1", "0.5")


def test_compare_joins_runs_and_says_what_is_unfinished(run, mixed, tmp_path, capsys):
    rows = read_rows(run / "trials.parquet")
    write_rows(rows[:2], run / "trials.parquet")
    assert main(["compare", str(run), str(mixed)]) == 0
    printed = capsys.readouterr().out
    assert f"{run} is unfinished: 2 of 3 trials (sdh-sim lift --resume --out {run})." in printed
    (overall,) = (line for line in printed.splitlines() if line.strip().startswith("overall"))
    stable = sum(row["failure"] != "unstable_simulation" for row in rows[:2])
    assert overall.split()[1] == str(6 + stable)


def test_compare_counts_what_a_killed_run_left_in_shards(run, capsys):
    rows = read_rows(run / "trials.parquet")
    write_rows(rows[:1], run / "trials.parquet")
    ShardWriter(run / "shards").append(rows[1:])
    before = (run / "trials.parquet").read_bytes()
    assert main(["compare", str(run), "--no-report"]) == 0
    assert "3 trials left out" in capsys.readouterr().out  # the stand-ins' are all unstable
    assert (run / "trials.parquet").read_bytes() == before  # a run that goes on is left alone
    (shard,) = (run / "shards").iterdir()
    shard.write_bytes(shard.read_bytes()[:-8])
    assert "damaged" in fails(capsys, "compare", run)


def test_a_copied_run_is_noticed(run, tmp_path, capsys):
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    assert "3 trials of" in fails(capsys, "compare", run, copy, "--no-report")
    # A table alone is known by its trials and their outcomes.
    bare = tmp_path / "bare.parquet"
    shutil.copy(run / "trials.parquet", bare)
    assert "would count double" in fails(capsys, "compare", run, bare, "--no-report")


def test_runs_of_other_settings_are_joined_with_a_word(run, tmp_path, capsys):
    other = tmp_path / "other"
    shutil.copytree(run, other)
    plan = json.loads((other / "run.json").read_text())
    plan["settings"]["position_error"] = 0.001
    (other / "run.json").write_text(json.dumps(plan))
    assert main(["compare", str(run), str(other), "--no-report"]) == 0
    printed = capsys.readouterr().out
    assert "were run with other settings (position_error 0.0 and 0.001)" in printed
    assert f"3 trials of {other} have object and seed of trials of {run}" in printed


def test_a_metric_that_one_run_lacks_is_left_out_with_a_word(run, mixed, tmp_path, capsys):
    table = read_table(mixed)
    without = table.drop_columns(["q_held"])
    pq.write_table(without, tmp_path / "older.parquet")
    assert main(["compare", str(run), str(tmp_path / "older.parquet"), "--all"]) == 0
    printed = capsys.readouterr().out
    assert re.search(rf"Only {run} has .*q_held.*: left out", printed)
    assert "q* held" not in printed


def test_every_row_says_its_n(tmp_path, capsys):
    ends = ("none", "slipped")
    rows = [
        {"trial": i, "object": "box", "seed": i, "success": i % 2 == 0, "failure": ends[i % 2]}
        | {"q_linf": 1.0 + i, "q_l1": 1.0, "volume_linf": None if i < 3 else 1.0 * i}
        for i in range(12)
    ]
    write_rows(rows, tmp_path / "some.parquet")
    assert main(["compare", str(tmp_path / "some.parquet"), "--all"]) == 0
    printed = capsys.readouterr().out
    (volume,) = (line for line in printed.splitlines() if re.match(r"\s+9 .*V L∞", line))
    assert volume.split()[:2] == ["9", "44"]
    assert "3 trials without V L∞ are left out of its lines." in printed


def test_compare_refuses(run, tmp_path, capsys):
    assert "does not exist" in fails(capsys, "compare", tmp_path / "none")
    (tmp_path / "empty").mkdir()
    assert "holds no run: it has no trials.parquet" in fails(capsys, "compare", tmp_path / "empty")
    assert "is given twice" in fails(capsys, "compare", run, tmp_path / "run" / ".")
    assert "--csv" in fails(capsys, "compare", run, "--csv", run / "run.json" / "x.csv")
    assert "--csv" in fails(capsys, "compare", run, "--csv", run)
    assert "runs" in fails(capsys, "compare").lower()
    write_rows([], run / "trials.parquet")
    assert "no finished trial" in fails(capsys, "compare", run)


def test_a_closed_pipe_is_quiet(run):
    done = subprocess.run(
        f"{sys.executable} -m sdh_sim compare {run} | true",
        shell=True,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
