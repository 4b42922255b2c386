"""Runs that go on or are replaced: to the same bytes, or refused with nothing changed."""

from __future__ import annotations

import json

import pyarrow.parquet as pq
import pytest

from sdh_sim.campaign import run_campaign
from sdh_sim.errors import RunError, SettingsError
from sdh_sim.records import read_rows, write_rows
from sdh_sim.runs import RunFolder
from tests.support import trial_stand_ins as stand_ins
from tests.support.run_folders import drop_rows, table_bytes, write_finished_run
from tests.support.trial_stand_ins import plan


def test_resume_runs_what_is_missing_to_the_same_bytes(tmp_path, whole):
    run_campaign(plan(), tmp_path, 1, trial=stand_ins.quick)
    drop_rows(tmp_path, [0, 2, 11])
    there, seen = [], []
    run_campaign(
        *(plan(), tmp_path, 2),
        resume=True,
        trial=stand_ins.uneven,
        on_start=lambda result: there.append(result.counts.total()),
        on_trial=seen.append,
    )
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert there == [3]
    assert sorted(row["trial"] for row in seen) == [1, 3, 4, 5, 6, 7, 8, 9, 10]
    sessions = json.loads((tmp_path / "run.json").read_text())["sessions"]
    assert [session["state"] for session in sessions] == ["finished", "finished"]


def test_resume_with_more_trials_is_the_bigger_run(tmp_path, whole):
    write_finished_run(plan(3), tmp_path)
    seen = []
    run_campaign(plan(6), tmp_path, 1, resume=True, trial=stand_ins.quick, on_trial=seen.append)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert [row["trial"] for row in seen] == [3, 4, 5, 9, 10, 11]
    assert RunFolder(tmp_path).read_plan().trials == 6


def test_resume_takes_the_table_and_run_json_of_an_earlier_version(tmp_path, whole):
    write_finished_run(plan(), tmp_path)
    drop_rows(tmp_path, [0, 2, 11])
    table, info = tmp_path / "trials.parquet", tmp_path / "run.json"
    pq.write_table(pq.read_table(table).drop_columns(["grasp_name", "plan_opening"]), table)
    data = json.loads(info.read_text())
    del data["settings"]["grasp_set"]
    info.write_text(json.dumps(data))
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)


def test_resume_without_a_run_starts_one(tmp_path, whole):
    run_campaign(plan(), tmp_path / "new", 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path / "new") == table_bytes(whole)


def test_resume_after_a_kill_before_the_first_table(tmp_path, whole):
    write_finished_run(plan(), tmp_path)
    (tmp_path / "trials.parquet").unlink()
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (plan(seed=1), r"seed \(run: 0, asked: 1\)"),
        (plan(objects=("box",)), r"objects \(run: box oval_bottle, asked: box\)"),
        (plan(torque_limit=(1.0, 2.0)), r"torque_limit \(run: 1.6401 1.0934, asked: 1.0 2.0\)"),
        (plan(sensor="ideal"), r"sensor \(run: dsa, asked: ideal\)"),
        (plan(trials=5), "--trials 5 would drop some: give 6 or more"),
    ],
)
def test_resume_refuses_other_settings_by_name(whole, other, words):
    before = table_bytes(whole), (whole / "run.json").read_bytes()
    with pytest.raises(RunError, match=words):
        run_campaign(other, whole, 1, resume=True, trial=stand_ins.quick)
    assert (table_bytes(whole), (whole / "run.json").read_bytes()) == before


def test_a_run_is_not_replaced_unasked(whole):
    before = table_bytes(whole)
    with pytest.raises(RunError, match=r"--resume.*--overwrite"):
        run_campaign(plan(seed=3), whole, 1, trial=stand_ins.quick)
    assert table_bytes(whole) == before


def test_overwrite_deletes_a_runs_own_files_only(tmp_path, whole):
    write_finished_run(plan(seed=3), tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / "box-000001.rrd").write_text("a run's")
    (tmp_path / "recordings" / "best.rrd").write_text("mine")
    (tmp_path / "errors").mkdir()
    for number in ("000001", "1234567"):
        (tmp_path / "errors" / f"trial_{number}.txt").write_text("a run's")
    run_campaign(plan(), tmp_path, 1, overwrite=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert [path.name for path in (tmp_path / "recordings").iterdir()] == ["best.rrd"]
    assert not (tmp_path / "errors").exists()


def test_overwrite_with_bad_arguments_deletes_nothing(tmp_path):
    write_finished_run(plan(1), tmp_path)
    before = table_bytes(tmp_path)
    for bad in ({"workers": 0}, {"rerun": "some"}, {"resume": True}):
        arguments = {"workers": 1, "trial": stand_ins.quick, "overwrite": True, **bad}
        with pytest.raises(SettingsError):
            run_campaign(plan(1), tmp_path, **arguments)
    assert table_bytes(tmp_path) == before


def test_a_trial_of_another_run_in_the_table_is_refused(tmp_path):
    write_finished_run(plan(2), tmp_path)
    row = {**stand_ins.make_row("box", 12345), "trial": 3}
    rows = read_rows(tmp_path / "trials.parquet")[:3]
    write_rows([*rows, row], tmp_path / "trials.parquet")
    with pytest.raises(RunError, match="seed 12345"):
        run_campaign(plan(2), tmp_path, 1, resume=True, trial=stand_ins.quick)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "damaged"),
        ("[]", "damaged"),
        ("[" * 100000, "damaged"),
        ('{"format": 99}', "not the settings of a run that this version knows"),
        ('{"format": 1}', "lacks 'objects'"),
        (
            '{"format": 1, "objects": "box", "settings": {}, "trials": 1, "seed": 0}',
            "list of names",
        ),
        ('{"format": 1, "objects": ["box"], "settings": 3, "trials": 1, "seed": 0}', "damaged"),
        ('{"format": 1, "objects": ["box"], "settings": {}, "trials": -1, "seed": 0}', "trials"),
        (
            '{"format": 1, "objects": ["box"], "settings": {"spin": 1}, "trials": 1, "seed": 0}',
            "unknown setting 'spin'",
        ),
        (
            '{"format": 1, "objects": ["box"], "settings": {"torque_limit": [NaN, 1]}, '
            '"trials": 1, "seed": 0}',
            "not JSON",
        ),
        (
            '{"format": 1, "objects": ["box"], "settings": {"torque_limit": [0, 1]}, '
            '"trials": 1, "seed": 0}',
            "torque_limit",
        ),
        (
            '{"format": 1, "objects": ["box"], "settings": {"pads": {}}, "trials": 1, "seed": 0}',
            "pads",
        ),
    ],
)
def test_damaged_run_json(tmp_path, text, words):
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(RunError, match=words) as caught:
        RunFolder(tmp_path).read_plan()
    assert "\n" not in str(caught.value)
    with pytest.raises(RunError):
        run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert (tmp_path / "run.json").read_text() == text


def test_a_damaged_run_can_be_replaced(tmp_path):
    (tmp_path / "run.json").write_text("{")
    (tmp_path / "trials.parquet").write_text("no table")
    run_campaign(plan(1), tmp_path, 1, overwrite=True, trial=stand_ins.quick)
    assert RunFolder(tmp_path).read_plan() == plan(1)
    assert len(read_rows(tmp_path / "trials.parquet")) == 2
