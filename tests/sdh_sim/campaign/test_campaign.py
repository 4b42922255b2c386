"""Many trials, with stand-in trials in real worker processes: order, bytes, what is kept."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import types

import numpy as np
import pytest

from sdh_sim.campaign import run_campaign
from sdh_sim.campaign.jobs import TrialTask
from sdh_sim.errors import RunError
from sdh_sim.records import read_rows
from sdh_sim.runs import RunFolder
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT
from tests.support.run_folders import lines, table_bytes
from tests.support.trial_stand_ins import OBJECTS, plan


def test_rows_are_the_plans_trials_in_order(whole):
    rows = read_rows(whole / "trials.parquet")
    jobs = list(plan().jobs())
    assert [row["trial"] for row in rows] == list(range(12))
    assert [(row["object"], row["seed"]) for row in rows] == [
        (job.settings.object, job.seed) for job in jobs
    ]


def test_two_workers_give_the_same_bytes(tmp_path, whole):
    seen = []
    run_campaign(plan(), tmp_path, 2, trial=stand_ins.uneven, on_trial=seen.append)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert sorted(row["trial"] for row in seen) == list(range(12))


def test_more_workers_than_trials(tmp_path):
    result = run_campaign(plan(1, ("box",)), tmp_path, 5, trial=stand_ins.quick)
    assert result.counts.total() == 1
    info = json.loads((tmp_path / "run.json").read_text())
    assert info["sessions"][0]["workers"] == 1


def test_run_json_says_how_to_repeat(whole):
    info = json.loads((whole / "run.json").read_text())
    assert (info["seed"], info["trials"], info["objects"]) == (0, 6, list(OBJECTS))
    assert info["settings"]["torque_limit"] == [1.6401, 1.0934]
    (session,) = info["sessions"]
    assert session["state"] == "finished"
    assert session["trials"] == 12
    assert session["trial_wall_seconds"] == {"box": 3.0, "oval_bottle": 3.0}
    assert {"python", "numpy", "scipy", "mujoco", "sdh-sim"} <= set(session["versions"])
    assert RunFolder(whole).read_plan() == plan()


def test_speed_sums_are_this_sessions(tmp_path):
    result = run_campaign(plan(2), tmp_path, 1, trial=stand_ins.quick)
    assert result.sim_seconds == {"box": 8.0, "oval_bottle": 8.0}
    assert result.wall_seconds == {"box": 1.0, "oval_bottle": 1.0}
    assert run_campaign(plan(2), tmp_path, 1, resume=True, trial=stand_ins.quick).sim_seconds == {}


def test_workers_compute_with_one_thread(tmp_path, monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    run_campaign(plan(1, ("box",)), tmp_path, 1, trial=stand_ins.threads)
    assert read_rows(tmp_path / "trials.parquet")[0]["contacts"] == 1
    assert "OPENBLAS_NUM_THREADS" not in os.environ


def test_the_state_of_a_diverged_trial_is_kept(tmp_path):
    run_campaign(plan(3), tmp_path, 1, trial=stand_ins.diverges)
    rows = read_rows(tmp_path / "trials.parquet")
    bad = {row["trial"]: row for row in rows if row["seed"] % 3 == 0}
    assert len(rows) == 6
    assert bad
    names = {f"trial_{number:06d}.npz" for number in bad}
    assert {path.name for path in (tmp_path / "unstable").iterdir()} == names
    for number, row in bad.items():
        with np.load(tmp_path / "unstable" / f"trial_{number:06d}.npz") as state:
            np.testing.assert_array_equal(state["qpos"], [1.0, np.nan])
            assert state["time"] == 0.25
            assert (str(state["object"]), int(state["seed"])) == (row["object"], row["seed"])
    # In a bigger run trials have other numbers; so have their files, after a kill half-way too.
    folder = RunFolder(tmp_path)
    folder.renumber_files(plan(4))
    first, *_ = sorted((tmp_path / "unstable").iterdir())
    first.rename(first.with_name(first.name.replace("trial", "moved")))
    run_campaign(plan(5), tmp_path, 1, resume=True, trial=stand_ins.diverges)
    rows = read_rows(tmp_path / "trials.parquet")
    names = {f"trial_{row['trial']:06d}.npz" for row in rows if row["seed"] % 3 == 0}
    assert {path.name for path in (tmp_path / "unstable").iterdir()} == names
    for row in rows:
        if row["seed"] % 3 == 0:
            with np.load(tmp_path / "unstable" / f"trial_{row['trial']:06d}.npz") as state:
                assert int(state["seed"]) == row["seed"]


@pytest.mark.parametrize("rerun", ["all", "failures", "none"])
def test_recordings_are_of_the_trials_asked_for(tmp_path, monkeypatch, rerun):
    # The worker's side, in this process: the recording itself has tests of its own.
    module = types.ModuleType("recording")
    module.__dict__["write_recording"] = lambda log, path: path.write_text("recording")
    monkeypatch.setitem(sys.modules, "sdh_sim.viewing.recording", module)
    folder = RunFolder(tmp_path)
    task = TrialTask(stand_ins.quick, rerun, folder)
    wanted = set()
    for job in plan(6).jobs():
        result = task(job)
        assert result.row is not None
        if rerun == "all" or (rerun == "failures" and not result.row["success"]):
            wanted.add(f"{job.settings.object}-{job.index:06d}.rrd")
    assert {path.name for path in tmp_path.glob("recordings/*")} == wanted
    assert (len(wanted) == 0) == (rerun == "none")


def test_a_recording_that_cannot_be_written_is_the_disks_fault(tmp_path, monkeypatch):
    def refuse(log, path):
        raise OSError(28, "No space left on device")

    module = types.ModuleType("recording")
    module.__dict__["write_recording"] = refuse
    monkeypatch.setitem(sys.modules, "sdh_sim.viewing.recording", module)
    result = TrialTask(stand_ins.quick, "all", RunFolder(tmp_path))(plan().job(0))
    assert result.row is None
    assert result.refused
    assert result.error == "OSError: [Errno 28] No space left on device"


def test_an_exception_in_the_callback_keeps_the_trials_and_ends_the_workers(tmp_path):
    def boom(row):
        raise LookupError("boom")

    start = time.monotonic()
    with pytest.raises(LookupError, match="boom"):
        run_campaign(plan(30), tmp_path, 2, trial=stand_ins.endless, on_trial=boom)
    assert time.monotonic() - start < 30
    assert len(read_rows(tmp_path / "trials.parquet")) == 1


def test_two_runs_into_one_folder_are_refused(tmp_path, start, whole):
    process = start(tmp_path, 6, "endless")
    lines(process, 1)
    holder = rf"another run is writing into .*\(process {process.pid} on \S+, since "
    for resume, overwrite in ((True, False), (False, True), (False, False)):
        with pytest.raises(RunError, match=holder):
            run_campaign(
                *(plan(), tmp_path, 1),
                resume=resume,
                overwrite=overwrite,
                trial=stand_ins.quick,
            )
    process.kill()
    process.communicate(timeout=20)
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)


def test_a_script_without_a_main_guard_is_told_so(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        f"import sys\nsys.path.insert(0, {str(ROOT)!r})\n"
        "from sdh_sim.campaign.campaign import run_campaign\n"
        "from tests.support import trial_stand_ins\n"
        "run_campaign(\n"
        f"    trial_stand_ins.plan(1), {str(tmp_path / 'out')!r}, trial=trial_stand_ins.quick\n"
        ")\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert 'must start the run below `if __name__ == "__main__":`' in done.stderr.splitlines()[-1]
