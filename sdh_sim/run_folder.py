"""The folder of a run: what was asked for (``run.json``) beside what came out (``trials.parquet``).

A run is decided by its plan: objects, settings, trials per object, seed. The plan alone gives
every trial's number and seed, so that an interrupted run continues to the same table.
"""

from __future__ import annotations

import dataclasses
import importlib.metadata
import json
import platform
import shlex
import sys
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sdh_sim import records
from sdh_sim.atomic import write_atomic
from sdh_sim.settings import SettingsError, TrialSettings

FORMAT = 1
MAX_TRIALS = 1_000_000
SEED_RULE = (
    "numpy SeedSequence([seed, crc32(object name), index within the object])"
    ".generate_state(1, uint64)[0] >> 1"
)
_PACKAGES = ("sdh-sim", "mujoco", "numpy", "scipy", "mink", "osqp", "pyarrow", "rerun-sdk")


class RunError(ValueError):
    """A run folder or plan that cannot be used; the message is one line with a way out."""


def trial_seed(run_seed: int, object_name: str, index: int) -> int:
    """Seed of an object's trial ``index``; the same whatever other objects the run has."""
    entropy = [run_seed, zlib.crc32(object_name.encode()), index]
    return int(np.random.SeedSequence(entropy).generate_state(1, np.uint64)[0] >> np.uint64(1))


@dataclass(frozen=True)
class Job:
    """One trial to run: its number in the run, number within its object, seed and settings."""

    trial: int
    index: int
    seed: int
    settings: TrialSettings


@dataclass(frozen=True)
class RunPlan:
    """What a run is asked to do.

    Attributes:
        objects: names of the objects, in the order of the table.
        settings: settings of every trial (its ``object`` is replaced by each name in turn).
        trials: trials per object.
        seed: seed of the run, not negative.

    Raises:
        SettingsError: a number out of range, no object, or one object twice.
    """

    objects: tuple[str, ...]
    settings: TrialSettings
    trials: int
    seed: int

    def __post_init__(self) -> None:
        _whole("trials", self.trials, 1, MAX_TRIALS)
        _whole("seed", self.seed, 0, 2**63 - 1)
        if not self.objects or len(set(self.objects)) != len(self.objects):
            raise SettingsError(f"objects: got {list(self.objects)}; give each object once")

    @property
    def total(self) -> int:
        """Number of trials of the whole run."""
        return self.trials * len(self.objects)

    def job(self, trial: int) -> Job:
        """The trial of that number: object k has the numbers k n … k n + n - 1."""
        if not 0 <= trial < self.total:
            raise RunError(f"trial {trial} is not in the run; it has trials 0 to {self.total - 1}")
        which, index = divmod(trial, self.trials)
        name = self.objects[which]
        settings = dataclasses.replace(self.settings, object=name)
        return Job(trial, index, trial_seed(self.seed, name, index), settings)

    def jobs(self) -> Iterator[Job]:
        """Every trial of the run in the order of their numbers."""
        return (self.job(trial) for trial in range(self.total))

    def changes_from(self, stored: RunPlan) -> list[str]:
        """What differs from another plan, by name; more trials are no change."""
        mine, theirs = self.to_dict(), stored.to_dict()
        flat = [{**plan.pop("settings"), **plan} for plan in (mine, theirs)]
        return [
            f"{name} (run: {_show(flat[1].get(name))}, asked: {_show(flat[0][name])})"
            for name in flat[0]
            if name != "trials" and flat[0][name] != flat[1].get(name)
        ]

    def to_dict(self) -> dict[str, Any]:
        """The plan as plain JSON values."""
        settings = self.settings.to_dict()
        settings.pop("object")
        return {
            "objects": list(self.objects),
            "trials": self.trials,
            "seed": self.seed,
            "settings": settings,
        }

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> RunPlan:
        """The plan that ``to_dict`` gave; raises SettingsError or KeyError, TypeError."""
        names = data["objects"]
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise SettingsError(f"objects: got {names!r}; expected a list of names")
        objects = tuple(names)
        first = objects[0] if objects else ""
        settings = TrialSettings.from_dict({**data["settings"], "object": first})
        return cls(objects, settings, data["trials"], data["seed"])


def _whole(name: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SettingsError(f"{name}: got {value!r}; allowed is a whole number {low} to {high}")


def _show(value: object) -> str:
    if isinstance(value, list):
        return " ".join(str(v) for v in value)
    return str(value)


class RunFolder:
    """Where a run lives on disk.

    Attributes:
        path: the folder.
        table: its ``trials.parquet``.
        info: its ``run.json``.
        recordings: folder of the rerun recordings, present only where some were asked for.
    """

    def __init__(self, path: str | Path) -> None:
        if not str(path).strip():
            raise RunError(
                "the name of the run folder is empty; give --out a path such as runs/box"
            )
        self.path = Path(path)
        self.table = self.path / "trials.parquet"
        self.info = self.path / "run.json"
        self.recordings = self.path / "recordings"

    @property
    def resume_command(self) -> str:
        """The command line that continues this run."""
        return f"sdh-sim lift --resume --out {shlex.quote(str(self.path))}"

    def recording(self, job: Job) -> Path:
        """File of a trial's recording; named so that it stays right when the run is extended."""
        return self.recordings / f"{job.settings.object}-{job.index:06d}.rrd"

    def holds_run(self) -> bool:
        """Whether a run's files are there, readable or not."""
        return self.table.exists() or self.info.exists()

    def create(self, overwrite: bool = False) -> None:
        """Make the folder ready for a new run; ``overwrite`` deletes an older run's own files.

        Raises:
            RunError: it holds a run and ``overwrite`` is not set, or it cannot be written.
        """
        try:
            if self.holds_run() and not overwrite:
                raise RunError(
                    f"{self.path} already holds a run; continue it with --resume, replace it with "
                    "--overwrite, or choose another --out"
                )
            self.path.mkdir(parents=True, exist_ok=True)
            if overwrite:
                self._delete_run()
        except OSError as error:
            raise self.write_error(error) from error

    def _delete_run(self) -> None:
        # The table goes first: a crash between the two leaves a run of no trials, not a table
        # without its settings.
        own = [self.table, self.info]
        own += [path.with_name(path.name + ".tmp") for path in own]
        own += sorted(self.recordings.glob("*-[0-9][0-9][0-9][0-9][0-9][0-9].rrd"))
        for path in own:
            path.unlink(missing_ok=True)
        if self.recordings.is_dir() and not any(self.recordings.iterdir()):
            self.recordings.rmdir()

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
        reason = (str(why).splitlines() or ["unreadable"])[0]
        return RunError(
            f"{self.info} is damaged ({reason}); repair it from a copy, or start again with "
            "--overwrite or another --out"
        )

    def read_rows(self, plan: RunPlan) -> dict[int, records.Row]:
        """Finished trials by number in ``plan``, which may have more trials than when they ran.

        Raises:
            RunError: the table is damaged, or holds trials that the plan does not make.
        """
        if not self.table.exists():
            return {}
        try:
            stored = records.read_rows(self.table)
        except records.RecordError as error:
            raise RunError(
                f"{error}; repair it from a copy, or start again with --overwrite or another --out"
            ) from error
        numbers = {(job.settings.object, job.seed): job.trial for job in plan.jobs()}
        rows: dict[int, records.Row] = {}
        for row in stored:
            trial = numbers.get((row["object"], row["seed"]))
            if trial is None or trial in rows:
                raise RunError(
                    f"{self.table} holds trial {row['trial']} ({row['object']}, seed "
                    f"{row['seed']}), which the settings in {self.info} do not make; start again "
                    "with --overwrite or another --out"
                )
            rows[trial] = {**row, "trial": trial}
        return rows

    def write_info(self, plan: RunPlan, sessions: list[dict[str, Any]]) -> None:
        """Keep the plan and the history of who ran it where; raises OSError."""
        data = {"format": FORMAT, **plan.to_dict(), "seed_rule": SEED_RULE, "sessions": sessions}
        text = json.dumps(data, indent=2, allow_nan=False) + "\n"
        write_atomic(self.info, text.encode())


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that decide a trial's numbers."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            if name == "sdh-sim":  # run from a checkout
                import sdh_sim

                found[name] = getattr(sdh_sim, "__version__", "checkout")
    return found


def machine() -> dict[str, str]:
    """The platform, as far as it can change the last bits of a result."""
    return {"platform": platform.platform(), "machine": platform.machine(), "os": sys.platform}
