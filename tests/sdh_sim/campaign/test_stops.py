"""Runs that are stopped, killed or run out of disk: every finished trial is kept."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from sdh_sim.campaign import run_campaign
from sdh_sim.records import read_rows
from sdh_sim.runs import RunFolder
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT
from tests.support.run_folders import lines, table_bytes
from tests.support.trial_stand_ins import plan


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_keeps_what_is_finished(tmp_path, start, number, status):
    process = start(tmp_path, 60, "slow", save_every=1000.0)
    done = lines(process, 5)
    os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert process.returncode == status
    kept = read_rows(tmp_path / "trials.parquet")
    done += out.split()
    assert {row["trial"] for row in kept} >= {int(trial) for trial in done if trial}
    assert err == (
        f"interrupted: {len(kept)} of 120 trials are kept in {tmp_path}/trials.parquet; "
        f"continue with: sdh-sim lift --resume --out {tmp_path}\n"
    )
    state = json.loads((tmp_path / "run.json").read_text())["sessions"][0]["state"]
    assert state == "interrupted"


def test_an_interrupt_while_workers_start_is_quiet(tmp_path, start):
    process = start(tmp_path, 60, "slow")
    while not (tmp_path / "trials.parquet").exists():
        time.sleep(0.01)
    time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err.startswith("interrupted: ")
    assert err.count("\n") == 1


def test_an_interrupt_ends_trials_that_hang(tmp_path, start):
    process = start(tmp_path, 60, "endless")
    lines(process, 1)
    time.sleep(0.5)
    os.killpg(process.pid, signal.SIGINT)
    process.communicate(timeout=20)
    assert process.returncode == 130


def test_kill_at_any_moment_then_resume_gives_the_same_bytes(tmp_path, start, whole):
    rng = np.random.default_rng(2)
    for attempt in range(3):
        process = start(tmp_path, 6, "slow", save_every=0.0 if attempt % 2 else 1000.0)
        lines(process, int(rng.integers(1, 3)))
        time.sleep(float(rng.uniform(0, 0.05)))
        os.kill(process.pid, signal.SIGKILL)
        process.communicate(timeout=20)  # ends only when the orphaned workers are gone too
        read_rows(tmp_path / "trials.parquet")
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert not (tmp_path / "shards").exists()
    sessions = json.loads((tmp_path / "run.json").read_text())["sessions"]
    assert sessions[0]["state"] == "killed"
    assert sessions[-1]["state"] == "finished"


def test_a_kill_loses_trials_in_flight_only(tmp_path, start, tries):
    out = tmp_path / "out"
    process = start(out, 60, "noted", save_every=1000.0)
    announced = [int(line) for line in lines(process, 11)]
    os.kill(process.pid, signal.SIGKILL)
    rest, _ = process.communicate(timeout=20)
    announced += [int(line) for line in rest.split()]
    kept = {row["trial"] for row in RunFolder(out).finished(plan(60))}
    assert kept >= set(announced)
    assert len(tries()) - len(kept) <= 4  # one with each worker, one on its way from each


_FULL = """
import os, subprocess, sys
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.errors import CampaignError
from sdh_sim.runs.folder import RunFolder
from tests.support import trial_stand_ins as stand_ins
from tests.support.trial_stand_ins import plan

def disk(options):
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", sys.argv[1]], check=True)

if __name__ == "__main__":
    disk("size=1200k")
    out = os.path.join(sys.argv[1], "run")
    try:
        run_campaign(plan(20), out, 2, trial=stand_ins.noted)
    except CampaignError as error:
        print(error.status, error)
    print(len(list(RunFolder(out).finished(plan(20)))))
    disk("remount,size=20m")
    seen = []
    run_campaign(plan(20), out, 2, trial=stand_ins.noted, resume=True, on_trial=seen.append)
    print(len(seen))
"""


def test_a_full_disk_keeps_every_finished_trial(tmp_path, tries):
    # A small disk of its own, in a mount namespace: the process does not get out of it.
    own = ["unshare", "--map-root-user", "--mount"]
    if shutil.which("unshare") is None or subprocess.run([*own, "true"], check=False).returncode:
        pytest.skip("this machine lets no process mount a disk for itself")
    disk = tmp_path / "disk"
    disk.mkdir()
    (tmp_path / "full.py").write_text(_FULL)
    done = subprocess.run(
        [*own, sys.executable, str(tmp_path / "full.py"), str(disk)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    said, kept, rest = done.stdout.splitlines()
    assert said == (
        f"2 cannot write to {disk}/run: No space left on device; {kept} of 40 trials are kept in "
        f"{disk}/run; make room, then continue with: sdh-sim lift --resume --out {disk}/run"
    )
    assert 0 < int(kept) == 40 - int(rest)
    again = sum(count > 1 for count in tries().values())
    assert again <= 2  # those in flight when the disk was full


def test_a_table_that_cannot_be_written_loses_no_trial(tmp_path, start, whole):
    # From the first row on no file may grow past a size that shards stay below.
    process = start(tmp_path, 6, "quick", save_every=1000.0, file_size=50_000)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert err == (
        f"cannot write to {tmp_path}: File too large; 12 of 12 trials are kept in {tmp_path}; "
        f"make room, then continue with: sdh-sim lift --resume --out {tmp_path}\n"
    )
    assert not list(tmp_path.rglob("*.tmp"))
    seen = []
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick, on_trial=seen.append)
    assert seen == []
    assert table_bytes(tmp_path) == table_bytes(whole)


def test_a_disk_too_full_for_a_shard_keeps_those_before(tmp_path, start):
    process = start(tmp_path, 6, "growing", save_every=1000.0, file_size=24_000)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 2
    kept = list(RunFolder(tmp_path).finished(plan()))
    assert 0 < len(kept) < 12
    assert f"File too large; {len(kept)} of 12 trials are kept in {tmp_path}, the last " in err
    assert err.count("\n") == 1
