"""One session of a run: it keeps rows and history on disk and reports an early end as an error."""

from __future__ import annotations

import contextlib
import datetime
import signal
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from sdh_sim.campaign.job_result import JobResult
from sdh_sim.campaign.stop_signals import Stopped
from sdh_sim.errors import CampaignError, Interrupted, WorkerDied
from sdh_sim.records import TrialRow, normalise
from sdh_sim.run_options import RunOptions
from sdh_sim.runs import FinishedTrials, Job, RunFolder, RunPlan, machine, versions

ROWS_KEPT_CURRENT = 50_000  # a longer table (10 s to write) is written at the end of the run alone
ALL_FAILED = 10  # errors before any other outcome that stop the run: something is broken for all
_RESERVE = 1 << 20  # [bytes] more than the rows of one moment and run.json take


class _Refused(Exception):
    """A worker could not do its part for a reason that is not the trial's."""

    def __init__(self, job: Job, result: JobResult) -> None:
        where = f"trial {job.trial} ({job.settings.object}, seed {job.seed})"
        super().__init__(f"{where} failed: {result.error}")
        self.details = result.details


class _AllFailed(Exception):
    """Every trial so far ended as an error."""

    def __init__(self, last: JobResult, count: int) -> None:
        super().__init__(f"all trials failed ({count}, each tried twice), the last: {last.error}")
        self.details = last.details


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


class RunSession:
    """The part of a run between one start and its end; it alone writes into the run's folder.

    Args:
        plan, folder: of the run.
        history: earlier sessions as they stand in run.json.
        finished: trials that are on disk.

    Attributes:
        result: counts of all sessions, times of this one.
    """

    def __init__(
        self,
        plan: RunPlan,
        folder: RunFolder,
        history: list[dict[str, Any]],
        finished: FinishedTrials,
    ) -> None:
        self.plan = plan
        self.folder = folder
        self.finished = finished
        self.result = RunResult(counts=finished.counts)
        self._history = history
        self._entry: dict[str, Any] = {}
        self._errors: list[tuple[Job, JobResult]] = []
        self._started = self._last_save = time.monotonic()

    def begin(self, options: RunOptions, workers: int) -> None:
        """Enter this session in run.json and write a first table: a full disk shows at once.

        Args:
            options: of the run.
            workers: those that there are trials for.
        """
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        self._entry = {
            "started": now,
            "command": options.command,
            "executor": options.executor,
            "workers": workers,
            "rerun": options.rerun,
            "versions": versions(),
            **machine(),
            "state": "running",
        }
        for earlier in self._history:
            if isinstance(earlier, dict) and earlier.get("state") == "running":
                earlier["state"] = "killed"  # it could not write that itself
        self._history.append(self._entry)
        try:
            self.folder.write_info(self.plan, self._history)
            self.folder.reserve.write_bytes(bytes(_RESERVE))
            if self.finished.kept <= ROWS_KEPT_CURRENT:
                self.finished.compact()
        except OSError as error:
            raise self.folder.write_error(error) from error

    def add(self, batch: list[tuple[Job, JobResult]]) -> list[TrialRow]:
        """Keep finished trials; they are on the disk when this returns.

        Errors wait in memory until a trial ends otherwise: a run in which all trials fail keeps no
        rows, and runs all of them again once the fault is corrected.
        """
        good = [(job, result) for job, result in batch if result.row is not None]
        refused = [(job, result) for job, result in batch if result.refused]
        self._errors += [(j, r) for j, r in batch if r.row is None and not r.refused]
        rows = [result.row for _, result in good if result.row is not None]
        bad: list[tuple[Job, JobResult]] = []
        if good or any(failure != "error" for _, failure in self.finished.counts):
            bad, self._errors = self._errors, []
            rows += [_error_row(job) for job, _ in bad]
        try:
            for job, result in bad:
                self.folder.write_error_file(job, result.details or result.error + "\n")
            for job, result in good:
                if result.diverged is not None:
                    self.folder.write_state(job, result.diverged)
            self.finished.append(rows)
        except OSError as error:
            self._save_in_reserve(rows, error)
        for job, result in good:
            self._count(job, result)
        if refused:
            raise _Refused(*refused[0])
        if len(self._errors) >= ALL_FAILED:
            self.check_all_failed()
        return rows

    def _save_in_reserve(self, rows: list[TrialRow], refused: OSError) -> None:
        """A full disk takes the last rows in the room kept for them; then the run stops."""
        lost = 0
        try:
            self.folder.reserve.unlink(missing_ok=True)
            self.finished.append(rows)
        except OSError:
            lost = len(rows)
        raise _SaveFailed(lost) from refused

    def _count(self, job: Job, result: JobResult) -> None:
        name = job.settings.object
        assert result.row is not None
        for sums, seconds in (
            (self.result.sim_seconds, result.row["sim_seconds"] or 0.0),
            (self.result.wall_seconds, result.wall_seconds),
        ):
            sums[name] = sums.get(name, 0.0) + seconds

    def check_all_failed(self) -> None:
        """Raise where every trial so far ended as an error."""
        if self._errors:
            _, last = self._errors[-1]
            raise _AllFailed(last, len(self._errors))

    def save_if_due(self, every: float) -> None:
        """Bring the table up to date each time the run has doubled."""
        new = self.finished.in_shards
        if self.finished.kept <= ROWS_KEPT_CURRENT and 2 * new >= self.finished.kept:
            if time.monotonic() - self._last_save < every:
                return
            try:
                self.finished.compact()
            except OSError as error:
                raise _SaveFailed(0) from error
            self._last_save = time.monotonic()

    def close(self, cause: BaseException | None) -> None:
        """Bring all rows into the table; raise the error that tells of an early end.

        Args:
            cause: what ended the run early, or None.
        """
        if cause is None:
            state = "finished"
        else:
            state = "interrupted" if isinstance(cause, KeyboardInterrupt) else "broken off"
        self._entry.update(
            state=state,
            trials=self.finished.kept,
            wall_seconds=round(time.monotonic() - self._started, 3),
            trial_wall_seconds={k: round(v, 3) for k, v in self.result.wall_seconds.items()},
        )
        with contextlib.suppress(OSError):
            self.folder.reserve.unlink(missing_ok=True)
        lost, refused = 0, None
        if isinstance(cause, _SaveFailed):
            lost, refused = cause.lost, cause.__cause__
        try:
            if refused is None and (cause is None or self.finished.kept <= ROWS_KEPT_CURRENT):
                self.finished.compact()
            self.folder.write_info(self.plan, self._history)
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
        if isinstance(cause, _AllFailed):
            return CampaignError(f"{cause}; {way_on}", 1, cause.details)
        if isinstance(cause, _Refused):
            return CampaignError(f"{cause}; {way_on}", 2, cause.details)
        return cause

    def _kept(self) -> str:
        where = self.folder.path if self.finished.in_shards else self.folder.table
        return f"{self.finished.kept} of {self.plan.total} trials are kept in {where}"


def _error_row(job: Job) -> TrialRow:
    return normalise(
        {
            **job.labels,
            "object": job.settings.object,
            "seed": job.seed,
            "success": False,
            "failure": "error",
        }
    )
