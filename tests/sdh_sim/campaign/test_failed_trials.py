"""Trials that raise or kill their process: tried twice, then a row with the failure error."""

from __future__ import annotations

import json

import pytest

from sdh_sim.campaign import run_campaign
from sdh_sim.errors import CampaignError
from sdh_sim.records import differing_columns, read_rows
from tests.support import trial_stand_ins as stand_ins
from tests.support.run_folders import table_bytes
from tests.support.trial_stand_ins import plan


@pytest.mark.parametrize("trial", [stand_ins.dies, stand_ins.raises])
def test_a_bad_trial_is_tried_twice_then_an_error_row(tmp_path, whole, tries, trial):
    out = tmp_path / "out"
    result = run_campaign(plan(), out, 2, trial=trial)
    wanted = {row["trial"]: row for row in read_rows(whole / "trials.parquet")}
    bad = {job.trial: job for job in plan().jobs() if job.seed % 6 == 0}
    assert bad
    rows = {row["trial"]: row for row in read_rows(out / "trials.parquet")}
    assert sorted(rows) == list(range(12))
    for number, row in rows.items():
        if number in bad:
            known = {name: value for name, value in row.items() if value is not None}
            job = bad[number]
            assert known == {
                **{"trial": number, "object": job.settings.object, "seed": job.seed},
                **{"success": False, "failure": "error"},
            }
        else:
            assert not differing_columns(row, wanted[number])
    assert result.failures()["error"] == len(bad)
    assert {path.name for path in (out / "errors").iterdir()} == {f"trial_{n:06d}.txt" for n in bad}
    for number, job in bad.items():
        text = (out / "errors" / f"trial_{number:06d}.txt").read_text()
        assert text.startswith(f"{job.settings.object}, seed {job.seed}\n")
        assert ("SIGKILL" if trial is stand_ins.dies else "Traceback") in text
    assert tries() == {job.seed: 2 if job.trial in bad else 1 for job in plan().jobs()}
    assert json.loads((out / "run.json").read_text())["sessions"][0]["state"] == "finished"


def test_a_second_try_that_works_leaves_no_trace(tmp_path, whole, tries):
    run_campaign(plan(), tmp_path / "out", 2, trial=stand_ins.flaky)
    assert table_bytes(tmp_path / "out") == table_bytes(whole)
    assert not (tmp_path / "out" / "errors").exists()
    assert {seed for seed, count in tries().items() if count == 2} == {
        job.seed for job in plan().jobs() if job.seed % 2 == 0 or job.seed % 3 == 0
    }


def test_errors_are_run_again_when_asked(tmp_path, whole):
    run_campaign(plan(), tmp_path, 1, trial=stand_ins.raises)
    before = table_bytes(tmp_path)
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == before  # they count as finished
    run_campaign(plan(), tmp_path, 1, resume=True, retry_errors=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)


def test_a_run_in_which_all_fails_stops_early_and_keeps_nothing(tmp_path, whole):
    with pytest.raises(CampaignError, match=r"all trials failed.*ImportError: no m") as caught:
        run_campaign(plan(), tmp_path, 1, trial=stand_ins.always_fails)
    assert caught.value.status == 1
    assert "Traceback" in caught.value.details
    assert read_rows(tmp_path / "trials.parquet") == []
    with pytest.raises(CampaignError, match="unknown column 'colour'"):
        run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.wrong_column)
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)
