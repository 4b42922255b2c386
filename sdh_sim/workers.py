"""Worker processes: trials in, rows out; a worker's end or a Ctrl-C never goes unnoticed."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import connection, resource_tracker
from typing import Any

from sdh_sim import records
from sdh_sim.run_folder import Job, RunFolder
from sdh_sim.settings import TrialSettings
from sdh_sim.threads import limited_children

TrialFunction = Callable[[TrialSettings, int, bool], Any]


class Stopped(KeyboardInterrupt):
    """SIGTERM, raised where Ctrl-C would be."""


class WorkerDied(RuntimeError):
    """A worker process ended without an answer."""


@dataclass(frozen=True)
class Done:
    """What a worker sends back: a row, or the reason why there is none.

    Attributes:
        row: the finished row, or None.
        wall_seconds: time the trial took [s].
        error: one line on what went wrong. Text, because an exception that cannot be unpickled
            would break the whole pool.
        disk: the system refused a file.
        details: traceback.
    """

    row: records.Row | None
    wall_seconds: float = 0.0
    error: str = ""
    disk: bool = False
    details: str = ""


@dataclass(frozen=True)
class Work:
    """Runs one trial in a worker.

    Attributes:
        trial: what runs it, a module-level function; None is ``sdh_sim.trial.run_trial``.
        rerun: which trials leave a recording: ``all``, ``failures`` or ``none``.
        folder: where recordings go.
    """

    trial: TrialFunction | None
    rerun: str
    folder: RunFolder

    def __call__(self, job: Job) -> Done:
        try:
            return self._run(job)
        except Exception as error:
            text = f"{type(error).__name__}: {error}".splitlines()[0]
            disk = isinstance(error, OSError)
            return Done(None, error=text, disk=disk, details=traceback.format_exc())

    def _run(self, job: Job) -> Done:
        run_trial = self.trial
        if run_trial is None:
            from sdh_sim.trial import run_trial  # MuJoCo is loaded in workers only
        result = run_trial(job.settings, job.seed, self.rerun != "none")
        row = records.normalise({**result.row, "trial": job.trial})
        if (row["object"], row["seed"]) != (job.settings.object, job.seed):
            raise records.RecordError(f"the row is of {row['object']}, seed {row['seed']}")
        if self.rerun == "all" or (self.rerun == "failures" and not row["success"]):
            self._record(job, result.log)
        return Done(row, result.wall_seconds)

    def _record(self, job: Job, log: Any) -> None:
        from sdh_sim.recording import write_recording

        path = self.folder.recording(job)
        path.parent.mkdir(exist_ok=True)
        partial = path.with_name(path.name + ".tmp")
        write_recording(log, partial)
        partial.replace(path)


def run_jobs(
    jobs: Iterable[Job], workers: int, work: Callable[[Job], Done]
) -> Generator[tuple[Job, Done], None, None]:
    """Each job with its outcome, as they finish.

    Whatever ends this early (an exception here, or the caller closing it) ends the workers too;
    outcomes that were ready by then still come first where the reason arose here.

    Args:
        jobs: what to run, in this order.
        workers: number of processes.
        work: what a worker does with a job; picklable.

    Raises:
        WorkerDied: a worker process ended without an answer.
    """
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        workers, mp_context=multiprocessing.get_context("spawn"), initializer=_start_worker
    )
    waiting = iter(jobs)
    running: dict[Future[Done], Job] = {}
    finished = False

    def submit(count: int) -> None:
        with limited_children(), _interrupts_held():
            for _, job in zip(range(count), waiting, strict=False):
                running[pool.submit(work, job)] = job

    def ready() -> Iterator[tuple[Job, Done]]:
        answered = [f for f in running if f.done() and not f.cancelled() and not f.exception()]
        for future in answered:
            yield running.pop(future), future.result()

    try:
        # Twice the workers in flight keeps them busy; a queue of the whole run would only be
        # more to throw away.
        submit(2 * workers)
        while running:
            wait(running, return_when=FIRST_COMPLETED)
            yield from ready()
            for future in running:
                if future.done():
                    future.result()  # raises: whatever had a result was handed on above
            submit(2 * workers - len(running))
        finished = True
    except KeyboardInterrupt:
        yield from ready()
        raise
    except BrokenProcessPool as error:
        yield from ready()
        lost = sorted(job.trial for job in running.values())
        raise WorkerDied(
            "a worker process died (killed, out of memory, or a crash in native code) at one of "
            f"the trials {', '.join(map(str, lost))}"
        ) from error
    finally:
        pool.shutdown(wait=finished, cancel_futures=True)
        if not finished:
            for child in set(multiprocessing.active_children()) - before:
                child.terminate()
                child.join(5.0)


@contextlib.contextmanager
def stop_signals() -> Iterator[Callable[[], None]]:
    """SIGTERM stops the run as Ctrl-C does; the block gets a function that ignores both."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None  # only the main thread may touch signals
        return

    def stop(number: int, frame: object) -> None:
        raise Stopped

    def ignore() -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)

    before = signal.getsignal(signal.SIGINT), signal.signal(signal.SIGTERM, stop)
    try:
        yield ignore
    finally:
        signal.signal(signal.SIGINT, before[0])
        signal.signal(signal.SIGTERM, before[1])


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the block ends; processes started in it never see it.

    A terminal sends Ctrl-C to every process of the group: a worker that it hits while starting
    would print a traceback. Blocked signals stay blocked in children.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it unblocks SIGINT when it starts, so start it before
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_worker() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what Ctrl-C does
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    """A worker whose parent was killed would wait for work for ever."""
    connection.wait([sentinel])
    os._exit(1)
