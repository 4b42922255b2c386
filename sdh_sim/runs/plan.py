"""What a run is asked to do: objects, settings, trials per object, seed.

The plan alone gives every trial's number and seed, so that an interrupted run continues to the
same table.
"""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sdh_sim.errors import RunError, SettingsError
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import NAME, ObjectFolder, plain

MAX_TRIALS = 1_000_000
MAX_OBJECTS = 1000
MAX_TOTAL = 10_000_000
SEED_RULE = (
    "numpy SeedSequence([seed, crc32(object name), index within the object])"
    ".generate_state(1, uint64)[0] >> 1"
)


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
        settings: settings of every trial (its ``object`` is replaced by each name in turn, its
            ``folder`` by that object's).
        trials: trials per object.
        seed: seed of the run, not negative.
        folders: of those objects that are users' own, by name.

    Raises:
        SettingsError: a number out of range, no object, or one object twice.
    """

    objects: tuple[str, ...]
    settings: TrialSettings
    trials: int
    seed: int
    folders: Mapping[str, ObjectFolder] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _whole("trials", self.trials, 1, MAX_TRIALS)
        _whole("seed", self.seed, 0, 2**63 - 1)
        if len(self.objects) > MAX_OBJECTS or max(map(len, self.objects), default=0) > 1000:
            raise SettingsError(
                f"objects: got {len(self.objects)}; allowed are {MAX_OBJECTS}, with names of up to "
                "1000 letters"
            )
        if self.total > MAX_TOTAL:
            raise SettingsError(
                f"trials: got {self.trials} for each of {len(self.objects)} objects; allowed are "
                f"{MAX_TOTAL} in all"
            )
        if not self.objects or len(set(self.objects)) != len(self.objects):
            raise SettingsError(f"objects: got {list(self.objects)}; give each object once")
        for name, folder in self.folders.items():
            known = name in self.objects and NAME.fullmatch(name) is not None
            if not known or not isinstance(folder, ObjectFolder):
                raise SettingsError(f"folders: got {name!r:.80}; it is no object of the run")

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
        settings = dataclasses.replace(self.settings, object=name, folder=self.folders.get(name))
        return Job(trial, index, trial_seed(self.seed, name, index), settings)

    def jobs(self) -> Iterator[Job]:
        """Every trial of the run in the order of their numbers."""
        return (self.job(trial) for trial in range(self.total))

    def changes_from(self, stored: RunPlan) -> list[str]:
        """What differs from another plan, by name; more trials are no change.

        An object's folder, and a metric's file, may have moved: their content counts.
        """
        flat = [plan._contents() for plan in (self, stored)]
        return [
            f"{name} (run: {_show(flat[1].get(name))}, asked: {_show(flat[0][name])})"
            for name in flat[0]
            if name != "trials" and flat[0][name] != flat[1].get(name)
        ]

    def _contents(self) -> dict[str, Any]:
        plan = self.to_dict()
        flat = {**plan.pop("settings"), **plan}
        flat["metrics"] = [f"{m.name} ({_short(m.sha256)})" for m in self.settings.metrics]
        flat["folders"] = [f"{n} ({_short(f.sha256)})" for n, f in sorted(self.folders.items())]
        return flat

    def to_dict(self) -> dict[str, Any]:
        """The plan as plain JSON values."""
        settings = self.settings.to_dict()
        settings.pop("object")
        settings.pop("folder")
        plan = {
            "objects": list(self.objects),
            "trials": self.trials,
            "seed": self.seed,
            "settings": settings,
        }
        if self.folders:
            plan["folders"] = {name: plain(folder) for name, folder in self.folders.items()}
        return plan

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> RunPlan:
        """The plan that ``to_dict`` gave; raises SettingsError or KeyError, TypeError."""
        names = data["objects"]
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise SettingsError(f"objects: got {names!r}; expected a list of names")
        objects = tuple(names)
        first = objects[0] if objects else ""
        settings = TrialSettings.from_dict({**data["settings"], "object": first})
        if settings.folder is not None:
            raise SettingsError("folder: it stands below folders, not among the settings")
        found = data.get("folders", {})
        if not isinstance(found, dict):
            raise SettingsError(f"folders: got {found!r:.80}; expected them by object")
        folders = {name: ObjectFolder.from_dict(value) for name, value in found.items()}
        return cls(objects, settings, data["trials"], data["seed"], folders)


def _whole(name: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SettingsError(f"{name}: got {value!r}; allowed is a whole number {low} to {high}")


def _short(sha256: str) -> str:
    return f"sha256 {sha256[:12]}" if sha256 else "no file"


def _show(value: object) -> str:
    if isinstance(value, list):
        return " ".join(str(v) for v in value) or "none"
    return str(value)
