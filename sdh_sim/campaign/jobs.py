"""Trials in, rows out: what a worker does with a job, and how jobs reach workers.

An ``Executor`` runs jobs somewhere (``local_processes``, ``dask_cluster``); ``run_jobs`` keeps it
busy and gives every job one more try.
"""

from __future__ import annotations

import contextlib
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from sdh_sim.campaign.job_result import JobResult
from sdh_sim.errors import RecordError, SettingsError
from sdh_sim.records import normalise
from sdh_sim.runs import Job, RunFolder, versions

TrialFunction = Callable[..., Any]  # settings, seed, whether to log; plan where one is given
_POLL = 1.0  # [s] how soon workers that join are noticed


@dataclass(frozen=True)
class TrialTask:
    """Runs one trial in a worker.

    Attributes:
        trial: what runs it, a module-level function; None is ``sdh_sim.trial.run_trial``.
        rerun: which trials leave a recording: ``all``, ``failures`` or ``none``.
        folder: where recordings go.
        versions: packages that a worker on another machine must have, as ``versions()`` gives
            them; None where workers share this process's installation.
    """

    trial: TrialFunction | None
    rerun: str
    folder: RunFolder
    versions: dict[str, str] | None = None

    def prepare(self) -> None:
        """Load what trials need and compile the metrics, so that no trial's time has it in it."""
        if self.trial is None and self._other_versions() is None:
            with contextlib.suppress(Exception):  # what fails here fails in a trial, which tells
                import sdh_sim.trial  # noqa: F401 - loaded for the trials
                from sdh_sim.metrics import warm_up

                warm_up()

    def __call__(self, job: Job) -> JobResult:
        if (other := self._other_versions()) is not None:
            return JobResult(None, error=other, refused=True)
        try:
            run_trial = self.trial
            if run_trial is None:
                from sdh_sim.trial import run_trial  # MuJoCo is loaded in workers only
            result = run_trial(job.settings, job.seed, self.rerun != "none", **given_plan(job))
            row = normalise({**result.row, **job.labels})
            if (row["object"], row["seed"]) != (job.settings.object, job.seed):
                raise RecordError(f"the row is of {row['object']}, seed {row['seed']}")
        except SettingsError as error:  # an object's folder has changed, or is not on this machine
            return JobResult(None, error=str(error), refused=True)
        except Exception as error:
            return JobResult(None, error=_first_line(error), details=traceback.format_exc())
        wanted = self.rerun == "all" or (self.rerun == "failures" and not row["success"])
        if wanted and row["failure"] != "infeasible":  # nothing has moved there
            try:
                self._record(job, result.log)
            except Exception as error:
                refused = isinstance(error, OSError)
                details = traceback.format_exc()
                return JobResult(None, error=_first_line(error), refused=refused, details=details)
        return JobResult(row, result.wall_seconds, getattr(result, "diverged", None))

    def _record(self, job: Job, log: Any) -> None:
        from sdh_sim.viewing.recording import write_recording

        path = self.folder.recording(job)
        path.parent.mkdir(exist_ok=True)
        partial = path.with_name(path.name + ".tmp")
        write_recording(log, partial)
        partial.replace(path)

    def _other_versions(self) -> str | None:
        if self.versions is None or self.versions == (here := versions()):
            return None
        names = [n for n in self.versions if self.versions[n] != here.get(n)]
        them = ", ".join(f"{n} {here.get(n, 'none')} (not {self.versions[n]})" for n in names)
        return f"a worker has {them}; install the same versions on every machine"


def _first_line(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0]


def given_plan(job: Job) -> dict[str, Any]:
    """The argument ``plan`` of a trial whose grasp comes from a file; nothing where it is random.

    Raises:
        SettingsError: no such object.
    """
    if job.grasp is None:
        return {}
    from sdh_sim.grasping import plan_of
    from sdh_sim.objects import object_info

    obj = object_info(job.settings.object, job.settings.folder)
    return {"plan": plan_of(job.grasp, obj)}


class Executor(Protocol):
    """Runs jobs; what it was given comes back once each, in any order."""

    def slots(self) -> int:
        """Jobs that it can work at now, at least 1."""
        ...

    def submit(self, job: Job) -> None:
        """Start a job."""
        ...

    def wait(self, seconds: float) -> list[tuple[Job, JobResult]]:
        """What has come back; waits for the first, but no longer than ``seconds``.

        A job whose worker died, or did not end it in time, comes back without a row.
        """
        ...

    def close(self, finished: bool) -> None:
        """End the workers, in the middle of their jobs unless ``finished``."""
        ...


def run_jobs(
    jobs: Iterable[Job], executor: Executor
) -> Generator[list[tuple[Job, JobResult]], None, None]:
    """The jobs with their results, some at a time, as they finish.

    A job without a row is tried once more. The next jobs are on their way before results are
    handed on: at most twice ``executor.slots()`` trials are neither waiting nor handed on.

    Whatever ends this early (an exception here, or the caller closing it) ends the workers too;
    results that were ready by then still come first on a Ctrl-C.

    Raises:
        WorkerDied: processes end as soon as they start.
    """
    waiting = iter(jobs)
    again: deque[Job] = deque()
    tried: set[int] = set()
    running = 0
    finished = False

    def fill() -> None:
        nonlocal running
        free = executor.slots() - running
        while free > 0:
            job = again.popleft() if again else next(waiting, None)
            if job is None:
                return
            executor.submit(job)
            running += 1
            free -= 1

    def collect(seconds: float) -> list[tuple[Job, JobResult]]:
        nonlocal running
        ended: list[tuple[Job, JobResult]] = []
        for job, result in executor.wait(seconds):
            running -= 1
            if result.row is not None or result.refused or job.trial in tried:
                tried.discard(job.trial)
                ended.append((job, result))
            else:
                tried.add(job.trial)
                again.append(job)
        return ended

    try:
        fill()
        while running:
            ended = collect(_POLL)
            fill()
            if ended:
                yield ended
        finished = True
    except KeyboardInterrupt:
        yield collect(0.0)
        raise
    finally:
        executor.close(finished)
