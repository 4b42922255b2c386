"""Trials on a Dask cluster: one that is running somewhere, or one started on this machine.

Dask is the extra ``distributed``. A Dask worker does not run trials itself but in processes of its
own (``local_processes``), one per thread: a trial that kills its process ends no other trial, and
the Dask worker stays. Where a worker is lost, with its machine perhaps, Dask runs its trials
elsewhere.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import importlib.util
import logging
import multiprocessing
import queue
import threading
import time
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sdh_sim.campaign.job_result import JobResult
from sdh_sim.campaign.jobs import TrialTask
from sdh_sim.campaign.local_processes import ProcessExecutor
from sdh_sim.campaign.stop_signals import interrupts_held
from sdh_sim.errors import SettingsError, WorkerDied
from sdh_sim.runs import Job
from sdh_sim.thread_limits import limit_threads, limited_children

_CONNECT = 30.0  # [s]
_CLOSE = 5.0  # [s] that each step of closing may take
_SILENT = 60.0  # [s] without a sign of life after which a worker process is replaced
_GONE = "the Dask scheduler has gone away"
_RECOUNT = 2.0  # [s] between two looks at how many workers there are


def check_available(scheduler: str | None) -> None:
    """Raise SettingsError where Dask is not installed or the scheduler file does not exist."""
    if importlib.util.find_spec("distributed") is None:
        raise SettingsError(
            "executor: dask is not installed; install it with: pip install 'sdh-sim[distributed]'"
        )
    if scheduler is not None and "://" not in scheduler and not Path(scheduler).is_file():
        raise SettingsError(
            f"scheduler: got {scheduler!r}; give an address such as tcp://host:8786 or the file "
            "that `dask scheduler --scheduler-file` has written"
        )


class DaskExecutor:
    """An ``Executor`` on a Dask cluster.

    As many trials run as the cluster has worker threads, which may come and go.

    Args:
        workers: processes of a cluster on this machine.
        task: what runs a trial.
        scheduler: address or scheduler file of a running cluster; None starts one here.
        timeout: longest time of a trial [s].

    Raises:
        WorkerDied: the scheduler does not answer, or goes away.
    """

    def __init__(
        self, workers: int, task: TrialTask, scheduler: str | None, timeout: float
    ) -> None:
        distributed: Any = importlib.import_module("distributed")
        self._task = task
        self._timeout = timeout
        self._run = uuid.uuid4().hex
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._jobs: dict[Any, Job] = {}
        self._counted = -_RECOUNT
        self._slots = 1
        self._cluster: Any = None
        self._config = contextlib.ExitStack()
        try:
            with limited_children(), interrupts_held():
                where: dict[str, Any] = {"address": scheduler}
                if scheduler is None:
                    self._config.enter_context(_own_configuration())
                    self._cluster = _local(workers)
                    where = {"address": self._cluster}
                elif "://" not in scheduler:
                    where = {"scheduler_file": scheduler}
                self._client: Any = distributed.Client(**where, timeout=_CONNECT)
        except (OSError, TimeoutError, ValueError) as error:
            self._close_cluster()
            raise WorkerDied(f"the Dask scheduler {scheduler} does not answer: {error}") from error

    def slots(self) -> int:
        """Two jobs per worker thread, so that none waits for the next; at least 1.

        Where there is no worker, a job waits for the first.
        """
        if time.monotonic() - self._counted >= _RECOUNT:
            with _lost_scheduler_is_an_error():
                self._slots = max(1, 2 * sum(self._client.nthreads().values()))
            self._counted = time.monotonic()
        return self._slots

    def submit(self, job: Job) -> None:
        """Send the job to the scheduler."""
        with _lost_scheduler_is_an_error():
            future = self._client.submit(
                _run, self._run, self._task, self._timeout, job, pure=False
            )
        self._jobs[future] = job
        future.add_done_callback(self._ended.put)

    def wait(self, seconds: float) -> list[tuple[Job, JobResult]]:
        """What has come back; see ``Executor``."""
        ended: list[Any] = []
        try:
            ended.append(self._ended.get(timeout=max(seconds, 0.001)))
            while True:
                ended.append(self._ended.get_nowait())
        except queue.Empty:
            pass
        with _lost_scheduler_is_an_error():
            status = {future: future.status for future in ended}
            good = [future for future in ended if status[future] == "finished"]
            results = dict(zip(good, self._client.gather(good), strict=True)) if good else {}
            for future in ended:
                if status[future] in ("lost", "pending"):
                    # Its worker was lost with the result; Dask runs it again.
                    future.add_done_callback(self._ended.put)
                elif future not in results:
                    results[future] = self._failure(future)
        return [(self._jobs.pop(future), result) for future, result in results.items()]

    def _failure(self, future: Any) -> JobResult:
        if future.status != "error":
            raise WorkerDied(_GONE)
        error = future.exception()
        return JobResult(None, error=f"{type(error).__name__}: {error}".splitlines()[0])

    def close(self, finished: bool) -> None:
        """Drop what is still under way and end the trial processes."""
        if self._client.status == "running":
            with contextlib.suppress(Exception):  # it may go away just now; nothing is left to do
                self._client.cancel(list(self._jobs), force=True)
                # A stopped worker would not answer.
                end = threading.Thread(target=self._end_processes, daemon=True)
                end.start()
                end.join(_CLOSE)
        with contextlib.suppress(Exception):
            self._client.close(timeout=_CLOSE)
        self._close_cluster()

    def _end_processes(self) -> None:
        with contextlib.suppress(Exception):  # the connection may be closed just now
            self._client.run(_end_run, self._run, on_error="ignore")

    def _close_cluster(self) -> None:
        if self._cluster is not None:
            self._cluster.close(timeout=_CLOSE)
        self._config.close()


@contextlib.contextmanager
def _lost_scheduler_is_an_error() -> Iterator[None]:
    """Whatever Dask raises in the block (which differs by version) becomes a WorkerDied."""
    try:
        yield
    except (KeyboardInterrupt, WorkerDied):
        raise
    except (Exception, asyncio.CancelledError) as error:
        raise WorkerDied(f"{_GONE} ({type(error).__name__})") from error


def _own_configuration() -> Any:
    """Dask's configuration of a cluster here; workers that replace others read it again."""
    config: Any = importlib.import_module("dask.config")
    return config.set(
        {
            "distributed.worker.daemon": False,  # a daemon process may have no children
            "distributed.scheduler.worker-ttl": f"{_SILENT} s",
        }
    )


def _local(workers: int) -> Any:
    distributed: Any = importlib.import_module("distributed")
    return distributed.LocalCluster(  # on loopback and without web pages
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,
        silence_logs=logging.CRITICAL,
    )


class _Trials:
    """The trial processes of a Dask worker, of one run at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._run = ""
        self._idle: list[ProcessExecutor] = []

    def __call__(self, run: str, task: TrialTask, timeout: float, job: Job) -> JobResult:
        limit_threads()
        with self._lock:
            if run != self._run:
                self._end_idle()
                self._run = run
            executor = self._idle.pop() if self._idle else ProcessExecutor(1, task, timeout)
        keep = False
        try:
            executor.submit(job)
            while not (came := executor.wait(1.0)):
                pass
            keep = True
        except WorkerDied as error:
            return JobResult(None, error=str(error), refused=True)
        finally:
            with self._lock:
                if keep and run == self._run:
                    self._idle.append(executor)
                else:
                    executor.close(False)
        return came[0][1]

    def end(self, run: str) -> None:
        """End the processes of a run; those at work end with their trial."""
        with self._lock:
            if run == self._run:
                self._run = ""
                self._end_idle()

    def _end_idle(self) -> None:
        for executor in self._idle:
            executor.close(True)
        self._idle.clear()


_TRIALS = _Trials()


def _run(run: str, task: TrialTask, timeout: float, job: Job) -> JobResult:
    if multiprocessing.current_process().daemon:
        error = "a Dask worker may not start processes; start it with: dask worker --no-nanny"
        return JobResult(None, error=error, refused=True)
    return _TRIALS(run, task, timeout, job)


def _end_run(run: str) -> None:
    _TRIALS.end(run)
