"""Nothing hangs: a trial that does not end costs one more try and is then an error."""

from __future__ import annotations

import importlib.util
import os
import signal
import time

import pytest

from sdh_sim.campaign import local_processes, run_campaign
from sdh_sim.campaign.jobs import run_jobs
from sdh_sim.campaign.local_processes import ProcessExecutor
from sdh_sim.errors import SettingsError, WorkerDied
from sdh_sim.records import differing_columns, read_rows
from sdh_sim.run_options import RunOptions
from tests.support import trial_stand_ins as stand_ins
from tests.support.run_folders import table_bytes
from tests.support.trial_stand_ins import plan

DASK = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None,
    reason="the extra 'distributed' is not installed: pip install 'sdh-sim[distributed]'",
)
EXECUTORS = ["processes", pytest.param("dask", marks=DASK)]


@pytest.mark.parametrize("executor", EXECUTORS)
def test_what_hangs_costs_one_more_try_and_what_always_hangs_is_an_error(
    tmp_path, whole, tries, executor
):
    out = tmp_path / "out"
    run_campaign(plan(), out, 2, trial=stand_ins.hangs, executor=executor, trial_timeout=1.0)
    bad = {job.trial: job for job in plan().jobs() if job.seed % 6 == 0}
    stopped = {job.seed for job in plan().jobs() if job.seed % 6 == 2}
    assert bad
    assert stopped
    twice = stopped | {job.seed for job in bad.values()}
    assert tries() == {job.seed: 2 if job.seed in twice else 1 for job in plan().jobs()}
    wanted = read_rows(whole / "trials.parquet")
    for row, other in zip(read_rows(out / "trials.parquet"), wanted, strict=True):
        if row["trial"] in bad:
            assert (row["failure"], row["q_linf"]) == ("error", None)
        else:
            assert not differing_columns(row, other)
    assert {path.name for path in (out / "errors").iterdir()} == {f"trial_{n:06d}.txt" for n in bad}
    for number, job in bad.items():
        text = (out / "errors" / f"trial_{number:06d}.txt").read_text()
        assert text == (
            f"{job.settings.object}, seed {job.seed}\n\n"
            "it did not end within 1 s (--trial-timeout)\n"
        )


@DASK
def test_a_stopped_dask_worker_is_replaced(tmp_path, whole, monkeypatch):
    psutil = pytest.importorskip("psutil", reason="psutil comes with the extra 'distributed'")
    monkeypatch.setattr("sdh_sim.campaign.dask_cluster._SILENT", 2.0)
    monkeypatch.setattr("distributed.scheduler.heartbeat_interval", lambda workers: 0.2)
    stopped: list[int] = []

    def stop(row) -> None:
        if not stopped:
            # Dask's own processes alone have children: those that run trials.
            workers = [p for p in psutil.Process().children() if p.children()]
            stopped.extend(p.pid for p in workers)
            for pid in stopped:
                os.kill(pid, signal.SIGSTOP)

    run_campaign(plan(), tmp_path, 1, trial=stand_ins.slow, executor="dask", on_trial=stop)
    assert stopped
    assert table_bytes(tmp_path) == table_bytes(whole)
    assert not any(psutil.pid_exists(pid) for pid in stopped)


class Slow:
    """A task whose process takes a while to be ready, or never is."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def prepare(self) -> None:
        time.sleep(self.seconds)

    def __call__(self, job):
        return stand_ins.as_result(job)


def test_the_start_of_a_process_is_no_part_of_a_trials_time():
    executor = ProcessExecutor(1, Slow(1.5), timeout=0.5)
    results = [pair for batch in run_jobs(plan(2).jobs(), executor) for pair in batch]
    assert all(result.row is not None for _, result in results)
    assert len(results) == 4


def test_a_process_that_is_never_ready_does_not_hold_the_run_up(monkeypatch):
    monkeypatch.setattr(local_processes, "_START", 1.0)
    executor = ProcessExecutor(1, Slow(3600))
    with pytest.raises(WorkerDied, match="end before they are ready: the last was not ready after"):
        list(run_jobs(plan(1).jobs(), executor))


def test_a_run_that_was_stopped_as_a_whole_loses_no_trial(monkeypatch):
    executor = ProcessExecutor(1, stand_ins.as_slow_result, timeout=8.0)
    clock = [0.0]
    monkeypatch.setattr(local_processes, "time", type("Clock", (), {"monotonic": lambda: clock[0]}))
    executor.submit(plan().job(0))
    while not next(iter(executor._busy.values())).ready:
        executor.wait(0.01)
    clock[0] += 3600.0  # between two looks
    assert executor.wait(0.0) == []
    clock[0] += 3600.0
    ((_, result),) = executor.wait(0.0)
    assert result.error == "it did not end within 8 s (--trial-timeout)"
    executor.close(True)


def test_processes_that_stand_still_are_ended_together(monkeypatch):
    monkeypatch.setattr(local_processes, "_END", 1.0)
    executor = ProcessExecutor(3, stand_ins.as_slow_result)
    for number in range(3):
        executor.submit(plan().job(number))
    workers = list(executor._busy.values())
    while not all(worker.ready for worker in workers):
        executor.wait(0.1)
    for worker in workers:
        os.kill(worker.process.pid, signal.SIGSTOP)
    begin = time.monotonic()
    executor.close(False)
    assert not any(worker.process.is_alive() for worker in workers)
    assert time.monotonic() - begin < 2.5


@pytest.mark.parametrize("value", [0.5, -1.0, float("nan")])
def test_a_limit_is_a_second_or_more(value):
    with pytest.raises(SettingsError, match="trial_timeout: got"):
        RunOptions(trial_timeout=value)
    assert RunOptions(trial_timeout=float("inf")).trial_timeout > 1e9
