"""Many trials: order, resume, stops and deaths, with stand-in trials in real worker processes."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import types
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from sdh_sim import records
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.campaign.jobs import Work
from sdh_sim.errors import CampaignError, RunError, SettingsError
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import RunPlan, trial_seed
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT
from tests.support.trial_stand_ins import OBJECTS, plan


def table_bytes(out: Path) -> bytes:
    return (out / "trials.parquet").read_bytes()


def made(run: RunPlan, out: Path) -> None:
    """A finished run without the time that workers take to start."""
    rows = [stand_ins.make_row(j.settings.object, j.seed) | {"trial": j.trial} for j in run.jobs()]
    records.write_rows(rows, out / "trials.parquet")
    RunFolder(out).write_info(run, [{"state": "finished"}])


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """An uninterrupted run by one worker."""
    out = tmp_path_factory.mktemp("whole")
    run_campaign(plan(), out, 1, trial=stand_ins.quick)
    return out


def test_seed_rule_and_numbering():
    entropy = [7, zlib.crc32(b"oval_bottle"), 2]
    state = np.random.SeedSequence(entropy).generate_state(1, np.uint64)[0]
    wanted = int(state) // 2
    assert trial_seed(7, "oval_bottle", 2) == wanted
    job = plan(trials=5, seed=7).job(7)
    assert (job.trial, job.index, job.seed) == (7, 2, wanted)
    assert job.settings.object == "oval_bottle"
    assert trial_seed(7, "box", 2) != wanted != trial_seed(8, "oval_bottle", 2)
    assert all(0 <= job.seed < 2**63 for job in plan(200).jobs())


def test_rows_are_the_plans_trials_in_order(whole):
    rows = records.read_rows(whole / "trials.parquet")
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
    assert records.read_rows(tmp_path / "trials.parquet")[0]["contacts"] == 1
    assert "OPENBLAS_NUM_THREADS" not in os.environ


def drop_rows(out: Path, keep: list[int]) -> None:
    rows = records.read_rows(out / "trials.parquet")
    records.write_rows([row for row in rows if row["trial"] in keep], out / "trials.parquet")


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
    made(plan(3), tmp_path)
    seen = []
    run_campaign(plan(6), tmp_path, 1, resume=True, trial=stand_ins.quick, on_trial=seen.append)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert [row["trial"] for row in seen] == [3, 4, 5, 9, 10, 11]
    assert RunFolder(tmp_path).read_plan().trials == 6


def test_resume_without_a_run_starts_one(tmp_path, whole):
    run_campaign(plan(), tmp_path / "new", 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path / "new") == table_bytes(whole)


def test_resume_after_a_kill_before_the_first_table(tmp_path, whole):
    made(plan(), tmp_path)
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
    made(plan(seed=3), tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / "box-000001.rrd").write_text("a run's")
    (tmp_path / "recordings" / "best.rrd").write_text("mine")
    run_campaign(plan(), tmp_path, 1, overwrite=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert [path.name for path in (tmp_path / "recordings").iterdir()] == ["best.rrd"]


def test_overwrite_with_bad_arguments_deletes_nothing(tmp_path):
    made(plan(1), tmp_path)
    before = table_bytes(tmp_path)
    for bad in ({"workers": 0}, {"rerun": "some"}, {"resume": True}):
        arguments = {"workers": 1, "trial": stand_ins.quick, "overwrite": True, **bad}
        with pytest.raises(SettingsError):
            run_campaign(plan(1), tmp_path, **arguments)
    assert table_bytes(tmp_path) == before


@pytest.mark.parametrize("bad", [0, -1, 1.5, True, "2", 10**9])
def test_bad_numbers_of_trials(bad):
    with pytest.raises(SettingsError, match="trials: got"):
        dataclasses.replace(plan(), trials=bad)


@pytest.mark.parametrize("bad", [-1, 0.5, 2**63])
def test_bad_seeds(bad):
    with pytest.raises(SettingsError, match="seed: got"):
        dataclasses.replace(plan(), seed=bad)


def test_objects_twice_or_none():
    for objects in ((), ("box", "box")):
        with pytest.raises(SettingsError, match="give each object once"):
            dataclasses.replace(plan(), objects=objects)


def test_a_trial_of_another_run_in_the_table_is_refused(tmp_path):
    made(plan(2), tmp_path)
    row = {**stand_ins.make_row("box", 12345), "trial": 3}
    rows = records.read_rows(tmp_path / "trials.parquet")[:3]
    records.write_rows([*rows, row], tmp_path / "trials.parquet")
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
    assert len(records.read_rows(tmp_path / "trials.parquet")) == 2


@pytest.fixture
def tries(tmp_path, monkeypatch) -> Callable[[], dict[int, int]]:
    """How often each seed was tried, as the stand-ins noted it."""
    folder = tmp_path / "tries"
    folder.mkdir()
    monkeypatch.setenv("STAND_IN_TRIES", str(folder))
    return lambda: {int(path.name): path.stat().st_size for path in folder.iterdir()}


@pytest.mark.parametrize("trial", [stand_ins.dies, stand_ins.raises])
def test_a_bad_trial_is_tried_twice_then_an_error_row(tmp_path, whole, tries, trial):
    out = tmp_path / "out"
    result = run_campaign(plan(), out, 2, trial=trial)
    wanted = {row["trial"]: row for row in records.read_rows(whole / "trials.parquet")}
    bad = {job.trial: job for job in plan().jobs() if job.seed % 6 == 0}
    assert bad
    rows = {row["trial"]: row for row in records.read_rows(out / "trials.parquet")}
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
            assert not records.differing_columns(row, wanted[number])
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


def test_a_run_without_hope_stops_early_and_keeps_nothing(tmp_path, whole):
    with pytest.raises(CampaignError, match=r"all trials failed.*ImportError: no m") as caught:
        run_campaign(plan(), tmp_path, 1, trial=stand_ins.hopeless)
    assert caught.value.status == 1
    assert "Traceback" in caught.value.details
    assert records.read_rows(tmp_path / "trials.parquet") == []
    with pytest.raises(CampaignError, match="unknown column 'colour'"):
        run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.wrong_column)
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)


def test_the_state_of_a_diverged_trial_is_kept(tmp_path):
    run_campaign(plan(3), tmp_path, 1, trial=stand_ins.diverges)
    rows = records.read_rows(tmp_path / "trials.parquet")
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
    rows = records.read_rows(tmp_path / "trials.parquet")
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
    monkeypatch.setitem(sys.modules, "sdh_sim.recording", module)
    folder = RunFolder(tmp_path)
    work = Work(stand_ins.quick, rerun, folder)
    wanted = set()
    for job in plan(6).jobs():
        done = work(job)
        assert done.row is not None
        if rerun == "all" or (rerun == "failures" and not done.row["success"]):
            wanted.add(f"{job.settings.object}-{job.index:06d}.rrd")
    assert {path.name for path in tmp_path.glob("recordings/*")} == wanted
    assert (len(wanted) == 0) == (rerun == "none")


def test_a_recording_that_cannot_be_written_is_the_disks_fault(tmp_path, monkeypatch):
    def refuse(log, path):
        raise OSError(28, "No space left on device")

    module = types.ModuleType("recording")
    module.__dict__["write_recording"] = refuse
    monkeypatch.setitem(sys.modules, "sdh_sim.recording", module)
    done = Work(stand_ins.quick, "all", RunFolder(tmp_path))(plan().job(0))
    assert done.row is None
    assert done.refused
    assert done.error == "OSError: [Errno 28] No space left on device"


def test_an_exception_in_the_callback_keeps_the_trials_and_ends_the_workers(tmp_path):
    def boom(row):
        raise LookupError("boom")

    start = time.monotonic()
    with pytest.raises(LookupError, match="boom"):
        run_campaign(plan(30), tmp_path, 2, trial=stand_ins.endless, on_trial=boom)
    assert time.monotonic() - start < 30
    assert len(records.read_rows(tmp_path / "trials.parquet")) == 1


_RUN = """
import resource, sys
sys.path.insert(0, "tests")
import trial_stand_ins as stand_ins
from trial_stand_ins import plan
def on_trial(row):
    print(row["trial"], flush=True)
    if len(sys.argv) > 5:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[5]), int(sys.argv[5])))
from sdh_sim.campaign import run_campaign, CampaignError
try:
    run_campaign(
        plan(int(sys.argv[2])), sys.argv[1], 2, resume=True, save_every=float(sys.argv[4]),
        trial=getattr(stand_ins, sys.argv[3]), on_trial=on_trial,
    )
except CampaignError as error:
    print(error, file=sys.stderr)
    sys.exit(error.status)
"""


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts runs in processes of their own; what a failing test leaves of them is ended."""
    started: list[subprocess.Popen[str]] = []

    def run(
        out: Path, trials: int, trial: str, save_every: float = 0.0, file_size: int | None = None
    ) -> subprocess.Popen[str]:
        # A group of its own: Ctrl-C in a terminal reaches the workers as well. A shell's
        # background job ignores SIGINT, and children inherit that.
        process = subprocess.Popen(
            [sys.executable, "-c", _RUN, str(out), str(trials), trial, str(save_every)]
            + ([] if file_size is None else [str(file_size)]),
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        started.append(process)
        return process

    yield run
    for process in started:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def lines(process: subprocess.Popen[str], count: int) -> list[str]:
    assert process.stdout is not None
    return [process.stdout.readline().strip() for _ in range(count)]


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_keeps_what_is_finished(tmp_path, start, number, status):
    process = start(tmp_path, 60, "slow", save_every=1000.0)
    done = lines(process, 5)
    os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert process.returncode == status
    kept = records.read_rows(tmp_path / "trials.parquet")
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
        records.read_rows(tmp_path / "trials.parquet")
    run_campaign(plan(), tmp_path, 1, resume=True, trial=stand_ins.quick)
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert not (tmp_path / "shards").exists()
    sessions = json.loads((tmp_path / "run.json").read_text())["sessions"]
    assert sessions[0]["state"] == "killed"
    assert sessions[-1]["state"] == "finished"


_FULL = """
import os, subprocess, sys
sys.path.insert(0, "tests")
import trial_stand_ins as stand_ins
from trial_stand_ins import plan
from sdh_sim.campaign import run_campaign, CampaignError
from sdh_sim.run_folder import RunFolder

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


def test_a_script_without_a_main_guard_is_told_so(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        f"import sys\nsys.path[:0] = [{str(ROOT)!r}, {str(ROOT / 'tests')!r}]\n"
        "import trial_stand_ins\nfrom trial_stand_ins import plan\n"
        "from sdh_sim.campaign import run_campaign\n"
        f"run_campaign(plan(1), {str(tmp_path / 'out')!r}, 1, trial=trial_stand_ins.quick)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert 'must start the run below `if __name__ == "__main__":`' in done.stderr.splitlines()[-1]
