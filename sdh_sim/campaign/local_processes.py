"""Worker processes on this machine, one job each: a dead process says which job it had.

Nothing waits for a process for ever. A trial's time runs while its process works at it, from when
the process is ready: not in a queue, not while a process starts, loads the packages and compiles
the metrics (``_START`` bounds that). It is added up in short steps, so that a run which was
stopped as a whole, by Ctrl-Z or a sleeping machine, goes on as if no time had passed.
"""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable
from multiprocessing import connection
from multiprocessing.connection import Connection
from typing import Any

from sdh_sim.campaign.job_result import JobResult
from sdh_sim.campaign.stop_signals import interrupts_held
from sdh_sim.errors import WorkerDied
from sdh_sim.runs import Job
from sdh_sim.thread_limits import limited_children

_READY = "ready"
_FAILED_STARTS = 3  # in a row; one may be bad luck
_START = 900.0  # [s] that a process may take until it is ready
_STEP = 5.0  # [s] that count at most between two looks at a process
_END = 5.0  # [s] that a process has to end by itself when asked to


class _Worker:
    """A process, our end of its pipe, and what it is working at."""

    def __init__(self, task: Callable[[Job], JobResult]) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process: Any = context.Process(target=_serve, args=(theirs, task), daemon=True)
        with limited_children(), interrupts_held():
            self.process.start()
        theirs.close()  # the end of the process is then the end of the pipe
        self.job: Job | None = None
        self.ready = False
        self.start_clock()

    def start_clock(self) -> None:
        """The time of a start, or of a job, begins now."""
        self._spent, self._looked = 0.0, time.monotonic()

    def spent(self) -> float:
        """Time since then [s], as far as it counts."""
        now = time.monotonic()
        self._spent += min(now - self._looked, _STEP)
        self._looked = now
        return self._spent

    def ending(self) -> str:
        """How the process ended."""
        self.process.join(_END)
        code = self.process.exitcode
        if code is None:
            return "closed its pipe"
        if code >= 0:
            return f"ended with status {code}"
        with contextlib.suppress(ValueError):
            name = signal.Signals(-code).name
            hint = " (out of memory?)" if name == "SIGKILL" else ""
            return f"was ended by {name}{hint}"
        return f"was ended by signal {-code}"

    def kill(self) -> None:
        """End it now, whatever it does; a stopped process takes no other signal."""
        self.process.kill()
        self.process.join(_END)
        self.pipe.close()


def _end(workers: Iterable[_Worker], finished: bool) -> None:
    """End processes, those that do not end by themselves too.

    Args:
        workers: the processes.
        finished: they are idle, and leave when their pipe is closed.
    """
    workers = list(workers)
    if finished:
        for worker in workers:
            worker.pipe.close()
        _join(workers)
    for worker in workers:
        if worker.process.is_alive():
            worker.process.terminate()
    _join(workers)
    for worker in workers:
        worker.kill()


def _join(workers: list[_Worker]) -> None:
    """Wait for all of them together."""
    deadline = time.monotonic() + _END
    for worker in workers:
        worker.process.join(max(deadline - time.monotonic(), 0.0))


class ProcessExecutor:
    """An ``Executor`` of processes, which are started when first needed.

    Args:
        workers: number of processes.
        task: what runs a trial; where it has a method ``prepare``, a process calls that first.
        timeout: longest time of a trial [s].
    """

    def __init__(
        self, workers: int, task: Callable[[Job], JobResult], timeout: float = math.inf
    ) -> None:
        self._slots = workers
        self._task = task
        self._timeout = timeout
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, _Worker] = {}
        self._failed_starts = 0

    def slots(self) -> int:
        """The number of processes."""
        return self._slots

    def submit(self, job: Job) -> None:
        """Hand the job to an idle process, or to a new one."""
        while True:
            worker = self._idle.pop() if self._idle else _Worker(self._task)
            try:
                worker.pipe.send(job)
            except OSError:  # it died idle
                if not worker.ready:
                    self._count_failed_start(worker.ending())
                worker.kill()
                continue
            worker.job = job
            if worker.ready:
                worker.start_clock()
            self._busy[worker.pipe] = worker
            return

    def wait(self, seconds: float) -> list[tuple[Job, JobResult]]:
        """What has come back; see ``Executor``."""
        came: list[tuple[Job, JobResult]] = []
        for pipe in connection.wait(list(self._busy), min(seconds, self._timeout)):
            worker = self._busy[pipe]  # pyright: ignore[reportArgumentType]
            try:
                answer = worker.pipe.recv()
            except (EOFError, OSError):
                came += self._remove(worker)
                continue
            if answer == _READY:
                worker.ready = True
                worker.start_clock()
                self._failed_starts = 0
                continue
            del self._busy[worker.pipe]
            self._idle.append(worker)
            assert worker.job is not None
            came.append((worker.job, answer))
            worker.job = None
        for worker in list(self._busy.values()):
            if worker.spent() > (self._timeout if worker.ready else _START):
                came += self._remove(worker, overdue=True)
        return came

    def _remove(self, worker: _Worker, overdue: bool = False) -> list[tuple[Job, JobResult]]:
        """Take out a dead or overdue worker; the result of its job, or none: it starts again."""
        del self._busy[worker.pipe]
        job = worker.job
        ending = f"was not ready after {_START:g} s" if overdue else worker.ending()
        worker.kill()
        assert job is not None
        if not worker.ready:
            self._count_failed_start(ending)
            self.submit(job)
            return []
        error = f"its worker process {ending}"
        if overdue:
            error = f"it did not end within {self._timeout:g} s (--trial-timeout)"
        return [(job, JobResult(None, error=error))]

    def _count_failed_start(self, ending: str) -> None:
        self._failed_starts += 1
        if self._failed_starts >= _FAILED_STARTS:
            raise WorkerDied(
                f"worker processes end before they are ready: the last {ending}; a script "
                'must start the run below `if __name__ == "__main__":`'
            )

    def close(self, finished: bool) -> None:
        """End the processes; with ``finished`` they are idle and leave by themselves."""
        _end([*self._idle, *self._busy.values()], finished)
        self._idle.clear()
        self._busy.clear()


def _serve(pipe: Connection, task: Callable[[Job], JobResult]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what Ctrl-C does
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    with contextlib.suppress(EOFError, OSError):  # the parent has closed the pipe: no more work
        prepare = getattr(task, "prepare", None)
        if prepare is not None:
            prepare()
        pipe.send(_READY)
        while True:
            pipe.send(task(pipe.recv()))


def _end_with(sentinel: int) -> None:
    """End this process with its parent: nobody would take the result of its trial."""
    connection.wait([sentinel])
    os._exit(1)
