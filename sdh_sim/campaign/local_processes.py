"""Worker processes on this machine, one job each: a dead process says which job it had."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
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

    def ending(self) -> str:
        """How the process ended."""
        self.process.join(5.0)
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

    def end(self) -> None:
        """Stop it now."""
        self.process.terminate()
        self.process.join(5.0)
        if self.process.is_alive():
            self.process.kill()
            self.process.join(5.0)
        self.pipe.close()


class ProcessExecutor:
    """An ``Executor`` of ``workers`` processes, which are started when first needed."""

    def __init__(self, workers: int, task: Callable[[Job], JobResult]) -> None:
        self._slots = workers
        self._task = task
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
                worker.end()
                self._count_failed_start(worker)
                continue
            worker.job = job
            self._busy[worker.pipe] = worker
            return

    def wait(self, seconds: float) -> list[tuple[Job, JobResult]]:
        """What has come back; see ``Executor``."""
        came: list[tuple[Job, JobResult]] = []
        for pipe in connection.wait(list(self._busy), seconds):
            worker = self._busy[pipe]  # pyright: ignore[reportArgumentType]
            try:
                answer = worker.pipe.recv()
            except (EOFError, OSError):
                came += self._remove(worker)
                continue
            if answer == _READY:
                worker.ready = True
                self._failed_starts = 0
                continue
            del self._busy[worker.pipe]
            self._idle.append(worker)
            assert worker.job is not None
            came.append((worker.job, answer))
            worker.job = None
        return came

    def _remove(self, worker: _Worker) -> list[tuple[Job, JobResult]]:
        """Take out a dead worker; the result of its job, or none where the job starts again."""
        del self._busy[worker.pipe]
        job, ending = worker.job, worker.ending()
        worker.end()
        assert job is not None
        if not worker.ready:
            self._count_failed_start(worker)
            self.submit(job)
            return []
        return [(job, JobResult(None, error=f"its worker process {ending}"))]

    def _count_failed_start(self, worker: _Worker) -> None:
        if worker.ready:
            return
        self._failed_starts += 1
        if self._failed_starts >= _FAILED_STARTS:
            raise WorkerDied(
                f"worker processes end before they are ready: the last {worker.ending()}; a script "
                'must start the run below `if __name__ == "__main__":`'
            )

    def close(self, finished: bool) -> None:
        """End the processes; with ``finished`` they are idle and leave by themselves."""
        for worker in [*self._idle, *self._busy.values()]:
            if finished:
                worker.pipe.close()
                worker.process.join(5.0)
            if worker.process.is_alive():
                worker.process.terminate()
        for worker in [*self._idle, *self._busy.values()]:
            worker.end()
        self._idle.clear()
        self._busy.clear()


def _serve(pipe: Connection, task: Callable[[Job], JobResult]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what Ctrl-C does
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    with contextlib.suppress(EOFError, OSError):  # the parent has closed the pipe: no more work
        pipe.send(_READY)
        while True:
            pipe.send(task(pipe.recv()))


def _end_with(sentinel: int) -> None:
    """End this process with its parent: nobody would take the result of its trial."""
    connection.wait([sentinel])
    os._exit(1)
