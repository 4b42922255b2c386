"""What a run that goes on owns on disk: its rows, its history, and the words for its end."""

from __future__ import annotations

import contextlib
import datetime
import signal
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from sdh_sim import records
from sdh_sim.campaign.jobs import Done
from sdh_sim.campaign.stop_signals import Stopped
from sdh_sim.errors import CampaignError, Interrupted, WorkerDied
from sdh_sim.runs.environment import machine, versions
from sdh_sim.runs.finished_trials import TrialStore
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import Job, RunPlan

LIVE_ROWS = 50_000  # a table up to here (10 s to write) follows the run and is made at a Ctrl-C
HOPELESS = 10  # errors before any other outcome that stop the run: something is broken for all
_RESERVE = 1 << 20  # [bytes] more than the rows of one moment and run.json take


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


class Keeper:
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
            self.folder.reserve.write_bytes(bytes(_RESERVE))
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
        rows = [done.row for _, done in good if done.row is not None]
        bad: list[tuple[Job, Done]] = []
        if good or any(failure != "error" for _, failure in self.store.counts):
            bad, self._errors = self._errors, []
            rows += [_error_row(job) for job, _ in bad]
        try:
            for job, done in bad:
                self.folder.write_error_file(job, done.details or done.error + "\n")
            for job, done in good:
                if done.diverged is not None:
                    self.folder.write_state(job, done.diverged)
            self.store.append(rows)
        except OSError as error:
            self._save_in_reserve(rows, error)
        for job, done in good:
            self._count(job, done)
        if refused:
            raise _Refused(*refused[0])
        if len(self._errors) >= HOPELESS:
            self.check_hope()
        return rows

    def _save_in_reserve(self, rows: list[records.Row], refused: OSError) -> None:
        """A full disk takes the last rows in the room kept for them; then the run stops."""
        lost = 0
        try:
            self.folder.reserve.unlink(missing_ok=True)
            self.store.append(rows)
        except OSError:
            lost = len(rows)
        raise _SaveFailed(lost) from refused

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
        with contextlib.suppress(OSError):
            self.folder.reserve.unlink(missing_ok=True)
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
