"""Trials on Dask: the same rows as without, whatever process dies; loopback only."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import queue
import signal
import subprocess
import sys
import time
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from sdh_sim.campaign import run_campaign
from sdh_sim.campaign.dask_cluster import DaskExecutor
from sdh_sim.campaign.job_result import JobResult
from sdh_sim.campaign.jobs import TrialTask
from sdh_sim.errors import CampaignError, SettingsError, WorkerDied
from sdh_sim.runs import RunFolder, versions
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT
from tests.support.run_folders import table_bytes
from tests.support.trial_stand_ins import plan

needs_dask = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None,
    reason="the extra 'distributed' is not installed: pip install 'sdh-sim[distributed]'",
)


def test_without_the_extra_its_name_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SettingsError, match=r"pip install 'sdh-sim\[distributed\]'"):
        run_campaign(plan(), tmp_path / "out", 1, executor="dask", trial=stand_ins.quick)
    assert not (tmp_path / "out").exists()


def test_a_worker_with_other_versions_stops_the_run(tmp_path):
    job = plan().job(0)
    folder = RunFolder(tmp_path)
    assert TrialTask(stand_ins.quick, "none", folder, versions())(job).row is not None
    result = TrialTask(stand_ins.quick, "none", folder, {**versions(), "mujoco": "3.0"})(job)
    assert result.row is None
    assert result.refused
    assert f"mujoco {versions()['mujoco']} (not 3.0)" in result.error


@pytest.fixture(scope="module")
def wanted(tmp_path_factory) -> Path:
    """What the trials give in worker processes; two of the twelve kill theirs."""
    out = tmp_path_factory.mktemp("wanted")
    result = run_campaign(plan(), out, 2, trial=stand_ins.dies)
    assert result.failures()["error"] == 2
    return out


@needs_dask
def test_a_cluster_here_gives_the_same_bytes_and_tracebacks(tmp_path, wanted):
    heard: set[str] = set()

    def listen(row) -> None:
        if not heard:
            heard.update(listening(os.getpid()))

    result = run_campaign(
        *(plan(), tmp_path, 2),
        executor="dask",
        trial=stand_ins.dies,
        on_trial=listen,
    )
    assert heard == {"127.0.0.1"}
    assert table_bytes(tmp_path) == table_bytes(wanted)
    assert result.failures()["error"] == 2
    for path in (wanted / "errors").iterdir():
        assert (tmp_path / "errors" / path.name).read_text() == path.read_text()
    assert json.loads((tmp_path / "run.json").read_text())["sessions"][0]["executor"] == "dask"


class Cluster:
    """A scheduler and two workers as a user starts them, on loopback."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "scheduler.json"
        self.log = open(folder / "log", "wb")  # noqa: SIM115 - closed by end
        self.scheduler = self._start("scheduler", "--port", "0")
        self.workers = [self._start("worker", "--no-nanny", "--nthreads", "1") for _ in range(2)]

    def _start(self, name: str, *options: str) -> subprocess.Popen[bytes]:
        where = ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0"]
        where += ["--scheduler-file", str(self.file)]
        return subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{name}", *where, *options],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            cwd=self.file.parent,
            stdout=self.log,
            stderr=self.log,
        )

    def end(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()
        self.log.close()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory) -> Iterator[Cluster]:
    cluster = Cluster(tmp_path_factory.mktemp("cluster"))
    with contextlib.ExitStack() as stack:
        stack.callback(cluster.end)
        deadline = time.monotonic() + 30.0
        while not cluster.file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        yield cluster


def listening(*pids: int) -> set[str]:
    """Addresses on which these processes and their children accept connections."""
    psutil = pytest.importorskip("psutil", reason="psutil comes with the extra 'distributed'")
    found = [psutil.Process(pid) for pid in pids]
    found += [child for process in found for child in process.children(recursive=True)]
    sockets = []
    for process in found:
        with contextlib.suppress(psutil.NoSuchProcess):  # one that a trial has just killed
            sockets += process.net_connections("inet")
    return {s.laddr.ip for s in sockets if s.status == psutil.CONN_LISTEN}


@needs_dask
def test_a_killed_worker_of_a_real_cluster_costs_nothing(tmp_path, cluster, wanted):
    rows: list[int] = []

    def on_trial(row) -> None:
        rows.append(row["trial"])
        if len(rows) == 3:
            pids = [process.pid for process in (cluster.scheduler, *cluster.workers)]
            assert listening(*pids) == {"127.0.0.1"}
            cluster.workers[0].send_signal(signal.SIGKILL)

    run_campaign(
        *(plan(), tmp_path, 2),
        executor="dask",
        scheduler=str(cluster.file),
        trial=stand_ins.dies_slowly,
        on_trial=on_trial,
    )
    assert sorted(rows) == list(range(12))
    assert cluster.workers[0].wait(timeout=5) == -signal.SIGKILL
    assert cluster.workers[1].poll() is None
    assert table_bytes(tmp_path) == table_bytes(wanted)


class Future:
    """A future of Dask's, as far as the executor looks."""

    def __init__(self, status: str) -> None:
        self.status = status
        self.callbacks: list = []

    def add_done_callback(self, call) -> None:
        self.callbacks.append(call)


def test_a_result_that_was_lost_with_its_worker_is_waited_for_again():
    kept, lost, cancelled = (Future(status) for status in ("finished", "lost", "cancelled"))
    executor: Any = object.__new__(DaskExecutor)
    executor._client = types.SimpleNamespace(
        gather=lambda futures: [JobResult(None)] * len(futures)
    )
    executor._jobs = dict(zip((kept, lost, cancelled), plan().jobs(), strict=False))
    executor._ended = queue.SimpleQueue()
    executor._ended.put(kept)
    executor._ended.put(lost)
    ((job, _),) = executor.wait(0.1)
    assert job.trial == 0
    assert list(executor._jobs) == [lost, cancelled]
    lost.status = "finished"
    lost.callbacks[0](lost)
    ((job, _),) = executor.wait(0.1)
    assert job.trial == 1
    executor._ended.put(cancelled)
    with pytest.raises(WorkerDied, match="has gone away"):
        executor.wait(0.1)


@needs_dask
def test_a_lost_scheduler_ends_the_run_with_everything_kept(tmp_path, cluster, wanted):
    def on_trial(row) -> None:
        cluster.scheduler.send_signal(signal.SIGKILL)

    address = json.loads(cluster.file.read_text())["address"]
    with pytest.raises(CampaignError, match=r"Dask scheduler .*gone.* of 12 trials are kept"):
        run_campaign(
            *(plan(), tmp_path, 2),
            executor="dask",
            scheduler=address,
            trial=stand_ins.dies_slowly,
            on_trial=on_trial,
        )
    assert len(list(RunFolder(tmp_path).finished(plan()))) >= 1
    run_campaign(plan(), tmp_path, 2, resume=True, trial=stand_ins.dies)
    assert table_bytes(tmp_path) == table_bytes(wanted)


@needs_dask
def test_a_scheduler_that_is_not_there(tmp_path, monkeypatch):
    options = {"executor": "dask", "trial": stand_ins.quick}
    with pytest.raises(SettingsError, match=r"scheduler: got 'none.json'; give an address"):
        run_campaign(plan(), tmp_path, 1, scheduler="none.json", **options)
    monkeypatch.setattr("sdh_sim.campaign.dask_cluster._CONNECT", 1.0)
    with pytest.raises(CampaignError, match=r"tcp://127.0.0.1:9 does not answer"):
        run_campaign(plan(), tmp_path, 1, scheduler="tcp://127.0.0.1:9", **options)
