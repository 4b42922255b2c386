"""Trials on a Dask cluster: one that is running somewhere, or two processes here for a test.

Dask is the extra ``distributed``.
"""

from __future__ import annotations

import importlib
import importlib.util
import logging
import queue
import threading
import time
from pathlib import Path
from typing import Any

from sdh_sim.run_folder import Job
from sdh_sim.settings import SettingsError
from sdh_sim.stopping import interrupts_held
from sdh_sim.threads import limit_threads, limited_children
from sdh_sim.workers import Done, Work, WorkerDied

_CONNECT = 30.0  # [s]
_RECOUNT = 2.0  # [s] between two looks at how many workers there are


def check(scheduler: str | None) -> None:
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
    """An ``Executor`` on a Dask cluster; each worker needs one thread.

    As many trials are under way as the cluster has workers, which may come and go.

    Raises:
        WorkerDied: the scheduler does not answer, or goes away.
        SettingsError: a worker has several threads.
    """

    def __init__(self, workers: int, work: Work, scheduler: str | None) -> None:
        distributed: Any = importlib.import_module("distributed")
        self._work = work
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._jobs: dict[Any, Job] = {}
        self._counted = -_RECOUNT
        self._slots = 1
        self._cluster: Any = None
        self._own = scheduler is None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            with limited_children(), interrupts_held():
                where = {"address": scheduler}
                if scheduler is None:
                    self._cluster = _local(workers)
                    where = {"address": self._cluster}
                elif "://" not in scheduler:
                    where = {"scheduler_file": scheduler}
                self._client: Any = distributed.Client(**where, timeout=_CONNECT)
        except (OSError, TimeoutError, ValueError) as error:
            self._close_cluster()
            raise WorkerDied(f"the Dask scheduler {scheduler} does not answer: {error}") from error

    def slots(self) -> int:
        """Workers of the cluster now, at least 1: with none, the next job waits for one."""
        if time.monotonic() - self._counted >= _RECOUNT:
            threads = self._client.nthreads()
            for address, count in threads.items():
                if count > 1:
                    raise SettingsError(
                        f"scheduler: its worker {address} has {count} threads, which trials cannot "
                        "share; start workers with: dask worker --nthreads 1 --nworkers auto"
                    )
            self._slots = max(1, len(threads))
            self._counted = time.monotonic()
        return self._slots

    def submit(self, job: Job) -> None:
        """Send the job to the scheduler."""
        future = self._client.submit(_run, self._work, job, pure=False)
        self._jobs[future] = job
        future.add_done_callback(self._ended.put)

    def wait(self, seconds: float) -> list[tuple[Job, Done]]:
        """What has come back; see ``Executor``."""
        ended: list[Any] = []
        try:
            ended.append(self._ended.get(timeout=max(seconds, 0.001)))
            while True:
                ended.append(self._ended.get_nowait())
        except queue.Empty:
            pass
        answers = self._client.gather([f for f in ended if f.status == "finished"], errors="skip")
        answers = iter(answers)
        return [
            (self._jobs.pop(f), next(answers) if f.status == "finished" else self._fate(f))
            for f in ended
        ]

    def _fate(self, future: Any) -> Done:
        if future.status != "error":
            raise WorkerDied("the Dask scheduler has gone away")
        error = future.exception()
        if type(error).__name__ == "KilledWorker":
            # A scheduler of ours gives up at once; another has had tries of its own.
            return Done(None, error="its worker process died", final=not self._own)
        return Done(None, error=f"{type(error).__name__}: {error}".splitlines()[0])

    def close(self, finished: bool) -> None:
        """Drop what is still under way; end the processes where they are ours."""
        if not finished:
            self._client.cancel(list(self._jobs), force=True)
        self._client.close()
        self._close_cluster()

    def _close_cluster(self) -> None:
        if self._cluster is not None:
            self._cluster.close(timeout=5.0)


def _local(workers: int) -> Any:
    distributed: Any = importlib.import_module("distributed")
    config: Any = importlib.import_module("dask.config")
    # Only loopback, no web pages; a dead process costs one try (``run_jobs`` makes the second).
    with config.set({"distributed.scheduler.allowed-failures": 0}):
        return distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address=None,
            silence_logs=logging.CRITICAL,
        )


_ONE = threading.Lock()


def _run(work: Work, job: Job) -> Done:
    limit_threads()
    with _ONE:  # trials share a model per process
        return work(job)
