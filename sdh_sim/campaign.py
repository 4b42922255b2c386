"""A run of many trials: every finished one kept at once, an orderly stop, a way to go on."""

from __future__ import annotations

import contextlib
import datetime
import os
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sdh_sim import records
from sdh_sim.run_folder import Job, RunError, RunFolder, RunPlan, machine, versions
from sdh_sim.run_lock import run_lock
from sdh_sim.settings import SettingsError
from sdh_sim.stopping import Stopped, StopSignals
from sdh_sim.trial_store import TrialStore
from sdh_sim.workers import Done, Executor, TrialFunction, Work, WorkerDied, run_jobs

RERUN = ("all", "failures", "none")
EXECUTORS = ("processes", "dask")
LIVE_ROWS = 50_000  # a table up to here (10 s to write) follows the run and is made at a Ctrl-C
HOPELESS = 10  # errors before any other outcome that stop the run: something is broken for all

OnTrial = Callable[[records.Row], None]


class CampaignError(RuntimeError):
    """A run that broke off; the message says why, what is kept and how to continue.

    Attributes:
        status: exit status of the command: 2 where the user's disk is at fault, else 1.
        details: traceback of the worker, or empty.
    """

    def __init__(self, message: str, status: int = 1, details: str = "") -> None:
        super().__init__(message)
        self.status = status
        self.details = details


class Interrupted(CampaignError):
    """The user, or the system, asked the run to stop; status is 128 plus the signal's number."""


class _Refused(Exception):
    """A worker could not do its part for a reason that is not the trial's."""

    def __init__(self, job: Job, done: Done) -> None:
        where = f"trial {job.trial} ({job.settings.object}, seed {job.seed})"
        super().__init__(f"{where} failed: {done.error}")
        self.done = done


class _Hopeless(Exception):
    """Every trial so far ended as an error."""

    def __init__(self, job: Job, done: Done, count: int) -> None:
        super().__init__(f"all trials failed ({count}, each tried twice), the last: {done.error}")
        self.done = done


class _SaveFailed(Exception):
    """Finished trials could not be written; ``__cause__`` is the OSError."""

    def __init__(self, lost: int) -> None:
        super().__init__()
        self.lost = lost


@dataclass
class RunResult:
    """What a run gave.

    Attributes:
        counts: finished trials, this session's and earlier ones', by object and failure.
        sim_seconds: simulated time of this session's trials by object [s].
        wall_seconds: time that workers spent on them by object [s].
    """

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    sim_seconds: dict[str, float] = field(default_factory=dict)
    wall_seconds: dict[str, float] = field(default_factory=dict)

    def failures(self, *objects: str) -> Counter[str]:
        """Trials on these objects (none named: on all) by failure."""
        total = Counter[str]()
        for (name, failure), count in self.counts.items():
            if not objects or name in objects:
                total[failure] += count
        return total


def default_workers() -> int:
    """One worker per core that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_campaign(
    plan: RunPlan,
    out: str | Path,
    workers: int = 1,
    *,
    resume: bool = False,
    overwrite: bool = False,
    retry_errors: bool = False,
    rerun: str = "none",
    executor: str = "processes",
    scheduler: str | None = None,
    on_start: Callable[[RunResult], None] | None = None,
    on_trial: OnTrial | None = None,
    command: str = "",
    save_every: float = 5.0,
    trial: TrialFunction | None = None,
) -> RunResult:
    """Run the trials that the folder lacks and keep each as soon as it has finished.

    The table's bytes depend on the plan alone: not on where trials run or how many at a time, nor
    on interruptions. A trial that raises, or whose process dies, is run once more and then is a
    row with the failure ``error``, its traceback in ``errors/``; the run goes on.

    Worker processes import the calling script anew: it must start the run below ``if __name__ ==
    "__main__":``, as Python's multiprocessing asks.

    Args:
        plan: what to run; with ``resume`` it may ask for more trials than the run had.
        out: folder of the run.
        workers: number of processes; a cluster (``scheduler``) has its own.
        resume: continue the run in ``out`` (a folder without a run starts one).
        overwrite: replace the run in ``out``.
        retry_errors: with ``resume``, run trials that ended as ``error`` again.
        rerun: which trials leave a rerun recording: ``all``, ``failures`` or ``none``.
        executor: what runs trials: ``processes``, or ``dask`` (the extra ``distributed``).
        scheduler: for ``dask``: address of a running scheduler, or its scheduler file; None starts
            a scheduler and ``workers`` processes on this machine.
        on_start: called once with what earlier sessions finished.
        on_trial: called with each row of this session when it is on the disk.
        command: command line to keep in ``run.json``.
        save_every: shortest time between two writes of the table while the run goes on [s].
        trial: what runs one trial: ``sdh_sim.trial.run_trial``, or a module-level stand-in.

    Raises:
        RunError, SettingsError: the folder or an argument cannot be used; nothing was changed.
        Interrupted: Ctrl-C or SIGTERM; finished trials are kept.
        CampaignError: the disk refused, no worker starts or every trial fails; finished trials
            are kept.
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise SettingsError(f"workers: got {workers!r}; give a whole number of at least 1")
    if rerun not in RERUN:
        raise SettingsError(f"rerun: got {rerun!r}; choose one of {', '.join(RERUN)}")
    if executor not in EXECUTORS:
        raise SettingsError(f"executor: got {executor!r}; choose one of {', '.join(EXECUTORS)}")
    if scheduler is not None and executor != "dask":
        raise SettingsError(f"scheduler: got {scheduler!r}; it needs --executor dask")
    if resume and overwrite:
        raise SettingsError("--resume and --overwrite exclude each other; give one of them")
    if retry_errors and not resume:
        raise SettingsError("--retry-errors continues a run; give --resume with it")
    if executor == "dask":
        from sdh_sim import cluster  # raises SettingsError where the extra is missing

        cluster.check(scheduler)
    folder = RunFolder(out)
    folder.make()
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(run_lock(folder.lock))
        except OSError as error:
            raise folder.write_error(error) from error
        keeper = _open(plan, folder, resume, overwrite, retry_errors)
        if on_start is not None:
            on_start(keeper.result)
        todo = plan.total - keeper.store.kept
        workers = min(workers, max(todo, 1))
        keeper.begin(command, workers, rerun, executor)
        stop = stack.enter_context(StopSignals())
        broken_by: BaseException | None = None
        try:
            if todo:
                work = Work(trial, rerun, folder, versions() if scheduler is not None else None)
                runs = _executor(executor, workers, work, scheduler)
                jobs = (plan.job(int(n)) for n in _missing(keeper.store))
                with contextlib.closing(run_jobs(jobs, runs)) as outcomes:
                    for batch in outcomes:
                        with stop.held():
                            rows = keeper.add(batch)
                        if on_trial is not None:
                            for row in rows:
                                on_trial(row)
                        keeper.save_if_due(save_every)
                keeper.check_hope()
        except BaseException as error:
            broken_by = error
        stop.ignore_further()
        keeper.close(broken_by)
    return keeper.result


def _missing(store: TrialStore) -> Iterator[int]:
    # Looked up as they are needed: a list of a million numbers would be the largest thing here.
    return (number for number in range(len(store.done)) if not store.done[number])


def _executor(name: str, workers: int, work: Work, scheduler: str | None) -> Executor:
    if name == "dask":
        from sdh_sim.cluster import DaskExecutor

        return DaskExecutor(workers, work, scheduler)
    from sdh_sim.processes import ProcessExecutor

    return ProcessExecutor(workers, work)


def _open(
    plan: RunPlan, folder: RunFolder, resume: bool, overwrite: bool, retry_errors: bool
) -> _Keeper:
    sessions: list[dict[str, Any]] = []
    if resume and folder.holds_run():
        stored = folder.read_plan()
        if changes := plan.changes_from(stored):
            raise RunError(
                f"{folder.path} was run with other settings: {'; '.join(changes)}; resume with the "
                "run's own (leave the option out), or choose another --out"
            )
        if plan.trials < stored.trials:
            raise RunError(
                f"{folder.path} is a run of {stored.trials} trials per object; --trials "
                f"{plan.trials} would drop some: give {stored.trials} or more"
            )
        history = folder.read_info().get("sessions")
        sessions = history if isinstance(history, list) else []
    else:
        folder.clear(overwrite)
    try:
        folder.renumber_files(plan)
        store = folder.open_store(plan, retry_errors)
    except OSError as error:
        raise folder.write_error(error) from error
    return _Keeper(plan, folder, sessions, store)


class _Keeper:
    """Owns what of the run is on disk."""

    def __init__(
        self, plan: RunPlan, folder: RunFolder, sessions: list[dict[str, Any]], store: TrialStore
    ) -> None:
        self.plan = plan
        self.folder = folder
        self.store = store
        self.result = RunResult(counts=store.counts)
        self._sessions = sessions
        self._session: dict[str, Any] = {}
        self._errors: list[tuple[Job, Done]] = []
        self._started = self._last_save = time.monotonic()

    def begin(self, command: str, workers: int, rerun: str, executor: str) -> None:
        """Open this session in run.json; write a first table, which proves that both can be."""
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        self._session = {
            "started": now,
            "command": command,
            "executor": executor,
            "workers": workers,
            "rerun": rerun,
            "versions": versions(),
            **machine(),
            "state": "running",
        }
        for earlier in self._sessions:
            if isinstance(earlier, dict) and earlier.get("state") == "running":
                earlier["state"] = "killed"  # it had no chance to say so itself
        self._sessions.append(self._session)
        try:
            self.folder.write_info(self.plan, self._sessions)
            if self.store.kept <= LIVE_ROWS:
                self.store.compact()
        except OSError as error:
            raise self.folder.write_error(error) from error

    def add(self, batch: list[tuple[Job, Done]]) -> list[records.Row]:
        """Keep finished trials; they are on the disk when this returns.

        Errors wait in memory until a trial ends otherwise: a run in which something is broken for
        all keeps no rows, and runs all its trials again when it is mended.
        """
        good = [(job, done) for job, done in batch if done.row is not None]
        refused = [(job, done) for job, done in batch if done.refused]
        self._errors += [(j, d) for j, d in batch if d.row is None and not d.refused]
        rows: list[records.Row] = []
        try:
            if good or any(failure != "error" for _, failure in self.store.counts):
                for job, done in self._errors:
                    self.folder.write_error_file(job, done.details or done.error + "\n")
                rows += [_error_row(job) for job, _ in self._errors]
                self._errors = []
            for job, done in good:
                if done.diverged is not None:
                    self.folder.write_state(job, done.diverged)
                assert done.row is not None
                rows.append(done.row)
            if rows:
                self.store.append(rows)
        except OSError as error:
            raise _SaveFailed(len(batch)) from error
        for job, done in good:
            self._count(job, done)
        if refused:
            raise _Refused(*refused[0])
        if len(self._errors) >= HOPELESS:
            self.check_hope()
        return rows

    def _count(self, job: Job, done: Done) -> None:
        result, name = self.result, job.settings.object
        assert done.row is not None
        for sums, seconds in (
            (result.sim_seconds, done.row["sim_seconds"] or 0.0),
            (result.wall_seconds, done.wall_seconds),
        ):
            sums[name] = sums.get(name, 0.0) + seconds

    def check_hope(self) -> None:
        """Raise where every trial so far ended as an error."""
        if self._errors:
            raise _Hopeless(*self._errors[-1], len(self._errors))

    def save_if_due(self, every: float) -> None:
        """Bring the table up to date each time the run has doubled."""
        new = self.store.in_shards
        if self.store.kept <= LIVE_ROWS and 2 * new >= self.store.kept:
            if time.monotonic() - self._last_save < every:
                return
            try:
                self.store.compact()
            except OSError as error:
                raise _SaveFailed(0) from error
            self._last_save = time.monotonic()

    def close(self, cause: BaseException | None) -> None:
        """Bring all into the table and turn the cause of an early end into the error to raise."""
        if cause is None:
            state = "finished"
        else:
            state = "interrupted" if isinstance(cause, KeyboardInterrupt) else "broken off"
        self._session.update(
            state=state,
            trials=self.store.kept,
            wall_seconds=round(time.monotonic() - self._started, 3),
            trial_wall_seconds={k: round(v, 3) for k, v in self.result.wall_seconds.items()},
        )
        lost, refused = 0, None
        if isinstance(cause, _SaveFailed):
            lost, refused = cause.lost, cause.__cause__
        try:
            if refused is None and (cause is None or self.store.kept <= LIVE_ROWS):
                self.store.compact()
            self.folder.write_info(self.plan, self._sessions)
        except OSError as error:
            refused = refused or error
        if isinstance(refused, OSError):
            raise CampaignError(
                f"cannot write to {self.folder.path}: {refused.strerror or refused}; {self._kept()}"
                f"{f', the last {lost} are lost' if lost else ''}; make room, then continue with: "
                f"{self.folder.resume_command}",
                status=2,
            ) from refused
        if cause is not None:
            raise self._explain(cause) from cause

    def _explain(self, cause: BaseException) -> BaseException:
        way_on = f"{self._kept()}; continue with: {self.folder.resume_command}"
        if isinstance(cause, KeyboardInterrupt):
            number = signal.SIGTERM if isinstance(cause, Stopped) else signal.SIGINT
            return Interrupted(f"interrupted: {way_on}", status=128 + number)
        if isinstance(cause, WorkerDied):
            return CampaignError(f"{cause}; {way_on}")
        if isinstance(cause, _Hopeless):
            return CampaignError(f"{cause}; {way_on}", 1, cause.done.details)
        if isinstance(cause, _Refused):
            return CampaignError(f"{cause}; {way_on}", 2, cause.done.details)
        return cause

    def _kept(self) -> str:
        where = self.folder.path if self.store.in_shards else self.folder.table
        return f"{self.store.kept} of {self.plan.total} trials are kept in {where}"


def _error_row(job: Job) -> records.Row:
    return records.normalise(
        {
            "trial": job.trial,
            "object": job.settings.object,
            "seed": job.seed,
            "success": False,
            "failure": "error",
        }
    )
