"""What a run is asked to do: objects, settings, trials per object or grasp, seed.

The plan alone gives every trial's number and seed, so that an interrupted run continues to the
same table.
"""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from sdh_sim.errors import RunError, SettingsError
from sdh_sim.settings import FROM_FILE, TrialSettings
from sdh_sim.user_references import NAME, ObjectFolder, plain

if TYPE_CHECKING:
    from sdh_sim.grasp_files import GraspEntry

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
    """One trial to run.

    Attributes:
        trial: its number in the run.
        index: its number among those of its object.
        seed, settings: of the trial.
        grasp_number: number of its grasp among those of its object in the file; None: random.
        copy: number of the trial among those of its grasp.
        grasp: the grasp itself, once ``with_grasp`` has put it there.
    """

    trial: int
    index: int
    seed: int
    settings: TrialSettings
    grasp_number: int | None = None
    copy: int = 0
    grasp: GraspEntry | None = None

    @property
    def labels(self) -> dict[str, Any]:
        """Columns of the row that the run knows, not the trial."""
        if self.grasp is None:
            return {"trial": self.trial}
        return {
            "trial": self.trial,
            "grasp_name": self.grasp.name,
            "grasp_copy": self.copy,
            "grasp_confidence": self.grasp.confidence,
        }


@dataclass(frozen=True)
class RunPlan:
    """What a run is asked to do.

    Attributes:
        objects: names of the objects, in the order of the table.
        settings: settings of every trial (its ``object`` is replaced by each name in turn, its
            ``folder`` by that object's).
        trials: trials per object; with grasps from a file, of each of them.
        seed: seed of the run, not negative.
        folders: of those objects that are users' own, by name.
        grasp_counts: number of grasps in the file by object; empty where grasps are random.

    Raises:
        SettingsError: a number out of range, no object, or one object twice.
    """

    objects: tuple[str, ...]
    settings: TrialSettings
    trials: int
    seed: int
    folders: Mapping[str, ObjectFolder] = field(default_factory=dict)
    grasp_counts: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _whole("trials", self.trials, 1, MAX_TRIALS)
        _whole("seed", self.seed, 0, 2**63 - 1)
        if len(self.objects) > MAX_OBJECTS or max(map(len, self.objects), default=0) > 1000:
            raise SettingsError(
                f"objects: got {len(self.objects)}; allowed are {MAX_OBJECTS}, with names of up to "
                "1000 letters"
            )
        self._check_counts()
        if self.total > MAX_TOTAL:
            grasps = sum(self.grasp_counts.values())
            each = f"{grasps} grasps" if grasps else f"{len(self.objects)} objects"
            raise SettingsError(
                f"trials: got {self.trials} for each of {each}; allowed are {MAX_TOTAL} in all"
            )
        if not self.objects or len(set(self.objects)) != len(self.objects):
            raise SettingsError(f"objects: got {list(self.objects)}; give each object once")
        for name, folder in self.folders.items():
            known = name in self.objects and NAME.fullmatch(name) is not None
            if not known or not isinstance(folder, ObjectFolder):
                raise SettingsError(f"folders: got {name!r:.80}; it is no object of the run")

    def _check_counts(self) -> None:
        wanted = set(self.objects) if self.settings.grasps == FROM_FILE else set()
        if set(self.grasp_counts) != wanted:
            raise SettingsError(
                f"grasp_counts: got {sorted(self.grasp_counts)!r:.200}; expected one for each "
                "object of the run where grasps come from a file, else none"
            )
        for count in self.grasp_counts.values():
            _whole("grasp_counts", count, 1, MAX_TRIALS)

    def trials_of(self, name: str) -> int:
        """Number of trials on an object."""
        return self.trials * self.grasp_counts.get(name, 1)

    @cached_property
    def starts(self) -> np.ndarray:
        """Number of the first trial on each object, and behind them that of all trials."""
        return np.cumsum([0, *(self.trials_of(name) for name in self.objects)])

    @property
    def total(self) -> int:
        """Number of trials of the whole run."""
        return int(self.starts[-1])

    def job(self, trial: int) -> Job:
        """The trial of that number: each object has its trials in a row, in the plan's order.

        With grasps from a file every grasp is tried once before any is tried again, so that
        more trials of each follow behind those that there were.
        """
        if not 0 <= trial < self.total:
            raise RunError(f"trial {trial} is not in the run; it has trials 0 to {self.total - 1}")
        which = int(np.searchsorted(self.starts, trial, side="right")) - 1
        name, index = self.objects[which], trial - int(self.starts[which])
        settings = dataclasses.replace(self.settings, object=name, folder=self.folders.get(name))
        job = Job(trial, index, trial_seed(self.seed, name, index), settings)
        if name not in self.grasp_counts:
            return job
        copy, number = divmod(index, self.grasp_counts[name])
        return dataclasses.replace(job, grasp_number=number, copy=copy)

    def jobs(self) -> Iterator[Job]:
        """Every trial of the run in the order of their numbers."""
        return (self.job(trial) for trial in range(self.total))

    def changes_from(self, stored: RunPlan) -> list[str]:
        """What differs from another plan, by name; more trials are no change.

        An object's folder, and a metric's file, may have moved: their content counts.
        """
        flat = [plan.contents() for plan in (self, stored)]
        return [
            f"{name} (run: {_show(flat[1].get(name))}, asked: {_show(flat[0][name])})"
            for name in flat[0]
            if name != "trials" and flat[0][name] != flat[1].get(name)
        ]

    def contents(self) -> dict[str, Any]:
        """Every setting by name; of what lies in files the content, not the place."""
        plan = self.to_dict()
        flat = {**plan.pop("settings"), **plan}
        flat["metrics"] = [f"{m.name} ({_short(m.sha256)})" for m in self.settings.metrics]
        grasp_set = self.settings.grasp_set
        flat["grasp_set"] = "none" if grasp_set is None else _short(grasp_set.sha256)
        hand = self.settings.hand_folder
        flat["hand_folder"] = "none" if hand is None else _short(hand.sha256)
        flat["grasp_counts"] = [f"{name} {count}" for name, count in self.grasp_counts.items()]
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
        if self.grasp_counts:
            plan["grasp_counts"] = dict(self.grasp_counts)
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
        counts = data.get("grasp_counts", {})
        if not isinstance(counts, dict):
            raise SettingsError(f"grasp_counts: got {counts!r:.80}; expected numbers by object")
        return cls(objects, settings, data["trials"], data["seed"], folders, counts)


def _whole(name: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SettingsError(f"{name}: got {value!r}; allowed is a whole number {low} to {high}")


def _short(sha256: str) -> str:
    return f"sha256 {sha256[:12]}" if sha256 else "no file"


def _show(value: object) -> str:
    if isinstance(value, list):
        return " ".join(str(v) for v in value) or "none"
    return str(value)
