"""A run of many trials: worker processes, a table saved as it grows, an orderly stop."""

from __future__ import annotations

import contextlib
import datetime
import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sdh_sim import records
from sdh_sim.run_folder import Job, RunError, RunFolder, RunPlan, machine, versions
from sdh_sim.settings import SettingsError
from sdh_sim.workers import Done, Stopped, TrialFunction, Work, WorkerDied, run_jobs, stop_signals

RERUN = ("all", "failures", "none")

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


class _TrialFailed(Exception):
    """A worker sent an error in place of a row."""

    def __init__(self, job: Job, done: Done) -> None:
        where = f"trial {job.trial} ({job.settings.object}, seed {job.seed})"
        super().__init__(f"{where} failed: {done.error}")
        self.done = done


class _SaveFailed(Exception):
    """The table could not be written; ``__cause__`` is the OSError."""


@dataclass
class RunResult:
    """What a run gave.

    Attributes:
        rows: every finished trial, this session's and earlier ones', by trial number.
        sim_seconds: simulated time of this session's trials by object [s].
        wall_seconds: time that workers spent on them by object [s].
    """

    rows: dict[int, records.Row] = field(default_factory=dict)
    sim_seconds: dict[str, float] = field(default_factory=dict)
    wall_seconds: dict[str, float] = field(default_factory=dict)


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
    rerun: str = "none",
    on_trial: OnTrial | None = None,
    command: str = "",
    save_every: float = 5.0,
    trial: TrialFunction | None = None,
) -> RunResult:
    """Run the trials that the folder lacks, in ``workers`` processes, and keep them there.

    The table's bytes depend on the plan alone: not on the number of workers, nor on interruptions.
    Workers import the calling script anew: it must start the run below ``if __name__ ==
    "__main__":``, as Python's multiprocessing asks.

    Args:
        plan: what to run; with ``resume`` it may ask for more trials than the run had.
        out: folder of the run.
        workers: number of processes.
        resume: continue the run in ``out`` (a folder without a run starts one).
        overwrite: replace the run in ``out``.
        rerun: which trials leave a rerun recording: ``all``, ``failures`` or ``none``.
        on_trial: called with each finished row, earlier sessions' first.
        command: command line to keep in ``run.json``.
        save_every: shortest time between two writes of the table [s].
        trial: what runs one trial: ``sdh_sim.trial.run_trial``, or a module-level stand-in.

    Raises:
        RunError, SettingsError: the folder or an argument cannot be used; nothing was changed.
        Interrupted: Ctrl-C or SIGTERM; finished trials are kept.
        CampaignError: a worker died or a trial raised; finished trials are kept.
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise SettingsError(f"workers: got {workers!r}; give a whole number of at least 1")
    if rerun not in RERUN:
        raise SettingsError(f"rerun: got {rerun!r}; choose one of {', '.join(RERUN)}")
    if resume and overwrite:
        raise SettingsError("--resume and --overwrite exclude each other; give one of them")
    keeper = _open(plan, RunFolder(out), resume, overwrite)
    rows = keeper.result.rows
    if on_trial is not None:
        for number in sorted(rows):
            on_trial(rows[number])
    finished = frozenset(rows)
    jobs = (job for job in plan.jobs() if job.trial not in finished)
    workers = min(workers, max(plan.total - len(finished), 1))
    keeper.begin(command, workers, rerun)
    work = Work(trial, rerun, keeper.folder)
    broken_by: BaseException | None = None
    with stop_signals() as ignore_further:
        try:
            with contextlib.closing(run_jobs(jobs, workers, work)) as outcomes:
                for job, done in outcomes:
                    row = keeper.add(job, done)
                    if on_trial is not None:
                        on_trial(row)
                    keeper.save_if_due(save_every)
        except BaseException as error:
            broken_by = error
        ignore_further()
        keeper.close(broken_by)
    return keeper.result


def _open(plan: RunPlan, folder: RunFolder, resume: bool, overwrite: bool) -> _Keeper:
    sessions: list[dict[str, Any]] = []
    rows: dict[int, records.Row] = {}
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
        rows = folder.read_rows(plan)
        history = folder.read_info().get("sessions")
        sessions = history if isinstance(history, list) else []
    else:
        folder.create(overwrite)
    return _Keeper(plan, folder, sessions, RunResult(rows=rows))


class _Keeper:
    """Owns the finished rows and what of them is on disk."""

    def __init__(
        self, plan: RunPlan, folder: RunFolder, sessions: list[dict[str, Any]], result: RunResult
    ) -> None:
        self.plan = plan
        self.folder = folder
        self.result = result
        self._sessions = sessions
        self._session: dict[str, Any] = {}
        self._saved = len(result.rows)
        self._save_seconds = 0.0
        self._started = self._last_save = time.monotonic()

    def begin(self, command: str, workers: int, rerun: str) -> None:
        """Open this session in run.json and write the table, which proves that both can be."""
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        self._session = {
            "started": now,
            "command": command,
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
            self._write_table()
        except OSError as error:
            raise self.folder.write_error(error) from error

    def add(self, job: Job, done: Done) -> records.Row:
        """Keep a finished trial; raises _TrialFailed where the worker sent an error."""
        if done.row is None:
            raise _TrialFailed(job, done)
        result, name = self.result, job.settings.object
        result.rows[job.trial] = done.row
        for sums, seconds in (
            (result.sim_seconds, done.row["sim_seconds"] or 0.0),
            (result.wall_seconds, done.wall_seconds),
        ):
            sums[name] = sums.get(name, 0.0) + seconds
        return done.row

    def save_if_due(self, every: float) -> None:
        """Write the table when it is time; a big table is written less often."""
        if time.monotonic() - self._last_save >= max(every, 20.0 * self._save_seconds):
            try:
                self._write_table()
            except OSError as error:
                raise _SaveFailed from error

    def _write_table(self) -> None:
        start = time.monotonic()
        records.write_rows(self.result.rows.values(), self.folder.table)
        self._saved = len(self.result.rows)
        self._last_save = time.monotonic()
        self._save_seconds = self._last_save - start

    def close(self, cause: BaseException | None) -> None:
        """Save everything and turn the cause of an early end into the error to raise."""
        if cause is None:
            state = "finished"
        else:
            state = "interrupted" if isinstance(cause, KeyboardInterrupt) else "broken off"
        self._session.update(
            state=state,
            trials=len(self.result.rows),
            wall_seconds=round(time.monotonic() - self._started, 3),
            trial_wall_seconds={k: round(v, 3) for k, v in self.result.wall_seconds.items()},
        )
        refused = cause.__cause__ if isinstance(cause, _SaveFailed) else None
        try:
            self._write_table()
            self.folder.write_info(self.plan, self._sessions)
        except OSError as error:
            refused = error
        if isinstance(refused, OSError):
            lost = len(self.result.rows) - self._saved
            raise CampaignError(
                f"cannot write to {self.folder.path}: {refused.strerror or refused}; {self._kept()}"
                f"{f', {lost} finished later are lost' if lost else ''}; make room, then continue "
                f"with: {self.folder.resume_command}",
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
        if isinstance(cause, _TrialFailed):
            status = 2 if cause.done.disk else 1
            return CampaignError(f"{cause}; {way_on}", status, cause.done.details)
        return cause

    def _kept(self) -> str:
        return f"{self._saved} of {self.plan.total} trials are kept in {self.folder.table}"
