"""The folder of a run: what was asked for (``run.json``), what came out (``trials.parquet``)."""

from __future__ import annotations

import io
import json
import re
import shlex
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sdh_sim.atomic_files import write_atomic
from sdh_sim.errors import RunError, SettingsError, one_line
from sdh_sim.records import TrialRow
from sdh_sim.runs.finished_trials import (
    FinishedTrials,
    TrialNumbers,
    read_finished,
    write_finished,
)
from sdh_sim.runs.plan import SEED_RULE, Job, RunPlan
from sdh_sim.runs.shards import shard_files

FORMAT = 1


class RunFolder:
    """Where a run lives on disk.

    Attributes:
        path: the folder.
        table: its ``trials.parquet``.
        info: its ``run.json``.
        shards: folder of trials finished since the table was written; gone when all are in it.
        recordings: folder of the rerun recordings, present only where some were asked for.
        unstable: folder of the states in which simulations diverged, if any did.
        errors: folder of the tracebacks of trials that ended as ``error``, if any did.
        lock: file that a run locks while it writes here.
        reserve: room on the disk for the last trials of a run that fills it.
    """

    def __init__(self, path: str | Path) -> None:
        if not str(path).strip():
            raise RunError(
                "the name of the run folder is empty; give --out a path such as runs/box"
            )
        self.path = Path(path)
        self.table = self.path / "trials.parquet"
        self.info = self.path / "run.json"
        self.shards = self.path / "shards"
        self.recordings = self.path / "recordings"
        self.unstable = self.path / "unstable"
        self.errors = self.path / "errors"
        self.lock = self.path / "run.lock"
        self.reserve = self.path / "run.reserve"

    @property
    def resume_command(self) -> str:
        """The command line that continues this run."""
        return f"sdh-sim lift --resume --out {shlex.quote(str(self.path))}"

    def recording(self, job: Job) -> Path:
        """File of a trial's recording; named so that it stays right when the run is extended."""
        return self.recordings / f"{job.settings.object}-{job.index:06d}.rrd"

    def holds_run(self) -> bool:
        """Whether a run's files are there, readable or not."""
        return self.table.exists() or self.info.exists() or bool(shard_files(self.shards))

    def make(self) -> None:
        """Make the folder itself; raises RunError where it cannot be."""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise self.write_error(error) from error

    def clear(self, overwrite: bool = False) -> None:
        """Make the folder ready for a new run; ``overwrite`` deletes an older run's own files.

        Raises:
            RunError: it holds a run and ``overwrite`` is not set, or it cannot be written.
        """
        if self.holds_run() and not overwrite:
            raise RunError(
                f"{self.path} already holds a run; continue it with --resume, replace it with "
                "--overwrite, or choose another --out"
            )
        try:
            if overwrite:
                self._delete_run()
        except OSError as error:
            raise self.write_error(error) from error

    def _delete_run(self) -> None:
        # The settings go last: a crash between two leaves a run of fewer trials, not trials
        # without their settings.
        number = "[0-9]" * 6
        own = [*shard_files(self.shards), *self.shards.glob("*.arrow.tmp")]
        own += [self.table, self.table.with_name(self.table.name + ".tmp")]
        own += self.recordings.glob(f"*-{number}.rrd")
        own += _of_trials(self.unstable, "trial", "npz") + _of_trials(self.errors, "trial", "txt")
        own += [self.reserve, self.info, self.info.with_name(self.info.name + ".tmp")]
        for path in own:
            path.unlink(missing_ok=True)
        for folder in (self.shards, self.recordings, self.unstable, self.errors):
            if folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()

    def write_error(self, error: OSError) -> RunError:
        """The one line for a folder that the disk or the system refuses."""
        reason = error.strerror or type(error).__name__
        if isinstance(error, FileExistsError):
            reason = "it is a file, not a folder"
        return RunError(
            f"cannot write to {self.path}: {reason}; choose another --out, or make it writable "
            "with room to spare"
        )

    def read_info(self) -> dict[str, Any]:
        """The content of ``run.json``; raises RunError where it is missing or damaged."""
        try:
            if not self.path.is_dir():
                raise RunError(f"{self.path} is not a folder; give the --out of an earlier lift")
            data = json.loads(self.info.read_text(encoding="utf-8"))
            json.dumps(data, allow_nan=False)  # what cannot be written again is damage too
        except RunError:
            raise
        except FileNotFoundError as error:
            raise RunError(f"{self.path} holds no run: it has no run.json") from error
        except (OSError, ValueError, RecursionError) as error:
            raise self._damaged(error) from error
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise self._damaged("it is not the settings of a run that this version knows")
        return data

    def read_plan(self) -> RunPlan:
        """The plan kept in ``run.json``; raises RunError where it cannot be used."""
        data = self.read_info()
        try:
            return RunPlan.from_dict(data)
        except KeyError as error:
            raise self._damaged(f"it lacks {error.args[0]!r}") from error
        except (SettingsError, TypeError, AttributeError) as error:
            raise self._damaged(error) from error

    def _damaged(self, why: object) -> RunError:
        reason = one_line(why) or "unreadable"
        return RunError(
            f"{self.info} is damaged ({reason}); repair it from a copy, or start again with "
            "--overwrite or another --out"
        )

    def finished(self, plan: RunPlan) -> Iterator[TrialRow]:
        """Finished trials in the order of their numbers in ``plan``, in the table or not yet.

        The plan may have more trials than when they ran. A few thousand rows at most are in memory.

        Raises:
            RunError: the table is damaged, or holds trials that the plan does not make.
        """
        return read_finished(self.table, shard_files(self.shards), plan)

    def whole_table(self, scratch: Path) -> Path:
        """A table of every finished trial: the run's, or a copy with its shards in a folder.

        Raises:
            RunError: as ``finished``.
            OSError: the copy could not be written.
        """
        shards = shard_files(self.shards)
        if not shards:
            return self.table
        path = scratch / self.table.name
        write_finished(self.table, shards, self.read_plan(), path)
        return path

    def read_rows(self, plan: RunPlan) -> dict[int, TrialRow]:
        """All of ``finished`` by number."""
        return {row["trial"]: row for row in self.finished(plan)}

    def open_finished(self, plan: RunPlan, retry_errors: bool = False) -> FinishedTrials:
        """The finished trials, to add to; raises as ``finished`` does, and OSError."""
        return FinishedTrials(self.table, self.shards, plan, retry_errors)

    def write_error_file(self, job: Job, text: str) -> None:
        """Keep the traceback of a trial that ended as ``error``; raises OSError."""
        self.errors.mkdir(exist_ok=True)
        head = f"{job.settings.object}, seed {job.seed}\n\n"
        write_atomic(self.errors / f"trial_{job.trial:06d}.txt", (head + text).encode())

    def write_state(self, job: Job, state: dict[str, np.ndarray]) -> None:
        """Keep the state in which a simulation diverged, with object and seed; raises OSError."""
        self.unstable.mkdir(exist_ok=True)
        buffer = io.BytesIO()
        of = {"object": np.array(job.settings.object), "seed": np.array(job.seed)}
        np.savez_compressed(buffer, allow_pickle=False, **{**state, **of})
        write_atomic(self.unstable / f"trial_{job.trial:06d}.npz", buffer.getvalue())

    def renumber_files(self, plan: RunPlan) -> None:
        """Name states and tracebacks by the numbers that ``plan`` gives their trials.

        Each file says which trial it is of, so that a call after a kill in the middle finds its
        way.
        """
        numbers = TrialNumbers(plan)
        for folder, suffix in ((self.unstable, "npz"), (self.errors, "txt")):
            for path in _of_trials(folder, "trial", suffix):
                of = _trial_of(path)
                number = numbers.find(*of, int(path.stem[6:])) if of else None
                if number is not None and path.name != f"trial_{number:06d}.{suffix}":
                    path.replace(path.with_name(f"moved_{number:06d}.{suffix}"))
            for path in _of_trials(folder, "moved", suffix):
                path.replace(path.with_name(path.name.replace("moved", "trial")))

    def write_info(self, plan: RunPlan, sessions: list[dict[str, Any]]) -> None:
        """Keep the plan and the history of who ran it where; raises OSError."""
        data = {"format": FORMAT, **plan.to_dict(), "seed_rule": SEED_RULE, "sessions": sessions}
        text = json.dumps(data, indent=2, allow_nan=False) + "\n"
        write_atomic(self.info, text.encode())


def _of_trials(folder: Path, start: str, suffix: str) -> list[Path]:
    """Files named by a trial's number; from a million on it has more than six digits."""
    name = re.compile(rf"{start}_\d{{6,}}\.{suffix}")
    return [path for path in folder.glob(f"{start}_*") if name.fullmatch(path.name)]


def _trial_of(path: Path) -> tuple[str, int] | None:
    """Object and seed of a file that ``write_state`` or ``write_error_file`` made."""
    try:
        if path.suffix == ".npz":
            with np.load(path, allow_pickle=False) as state:
                return str(state["object"]), int(state["seed"])
        with open(path, encoding="utf-8", errors="replace") as file:
            found = re.match(r"(\S+), seed (\d+)$", file.readline().rstrip("\n"))
        return (found[1], int(found[2])) if found else None
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return None  # not written here, or damaged: it keeps its name
