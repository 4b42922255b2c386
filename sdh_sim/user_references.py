"""References to what users bring: folders of objects and hands, metrics, files of grasps.

References are small, go to every worker and stand in ``run.json``. The SHA-256 of what they point
to comes along, so that a run never goes on with another object or another metric.
"""

from __future__ import annotations

import math
import re
from dataclasses import asdict, dataclass, field
from typing import Any

from sdh_sim.errors import SettingsError

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,47}")
METRIC_NAME = re.compile(r"[a-z][a-z0-9_]{0,47}")
MAX_METRICS = 32
MAX_NOTES = 500
_SHA256 = re.compile(r"[0-9a-f]{64}")
_LONGEST = 4096


@dataclass(frozen=True)
class ObjectFolder:
    """A user's object.

    Attributes:
        path: absolute path of its folder.
        sha256: of the files that make the object (``object_folder`` says which).
        notes: what was done with the files to make the object of them, for the user.

    Raises:
        SettingsError: not a path, not a SHA-256 or not notes.
    """

    path: str = field(repr=False)  # the object is the same wherever its folder lies
    sha256: str
    notes: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        _text("object", self.path)
        _digest("object", self.sha256)
        if len(self.notes) > MAX_NOTES:
            raise SettingsError(f"object: got {len(self.notes)} notes; at most {MAX_NOTES}")
        for note in self.notes:
            _text("object", note)

    @classmethod
    def from_dict(cls, data: Any) -> ObjectFolder:
        """The reference that ``plain`` gave; raises SettingsError."""
        if isinstance(data, dict) and isinstance(data.get("notes"), list):
            data = dict(data)
            notes = tuple(data.pop("notes"))
        else:
            notes = ()
        return cls(**_fields("object", data, ("path", "sha256")), notes=notes)


@dataclass(frozen=True)
class HandFolder:
    """A user's hand.

    Attributes:
        path: absolute path of its folder.
        sha256: of the files that make the hand: hand.toml, MJCF, what it includes, and meshes.
        notes: what was done with the files to make the hand of them, for the user.

    Raises:
        SettingsError: not a path, not a SHA-256 or not notes.
    """

    path: str = field(repr=False)  # the hand is the same wherever its folder lies
    sha256: str
    notes: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        _text("hand", self.path)
        _digest("hand", self.sha256)
        if len(self.notes) > MAX_NOTES:
            raise SettingsError(f"hand: got {len(self.notes)} notes; at most {MAX_NOTES}")
        for note in self.notes:
            _text("hand", note)

    @classmethod
    def from_dict(cls, data: Any) -> HandFolder:
        """The reference that ``plain`` gave; raises SettingsError."""
        given = dict(data) if isinstance(data, dict) else data
        notes = given.pop("notes", []) if isinstance(given, dict) else []
        if not isinstance(notes, list):
            raise SettingsError(f"hand: got {notes!r:.80} as notes; expected a list")
        return cls(**_fields("hand", given, ("path", "sha256")), notes=tuple(notes))


@dataclass(frozen=True)
class GraspSet:
    """A file of a user's own grasps.

    Attributes:
        path: absolute path of the file.
        sha256: of its bytes.

    Raises:
        SettingsError: not a path or not a SHA-256.
    """

    path: str = field(repr=False)  # the grasps are the same wherever their file lies
    sha256: str

    def __post_init__(self) -> None:
        _text("grasp_set", self.path)
        _digest("grasp_set", self.sha256)

    @classmethod
    def from_dict(cls, data: Any) -> GraspSet:
        """The reference that ``asdict`` gave; raises SettingsError."""
        return cls(**_fields("grasp_set", data, ("path", "sha256")))


@dataclass(frozen=True)
class UserMetric:
    """A user's metric.

    Attributes:
        name: letters, digits and _; the column is ``metric_`` and this.
        target: ``module:function``, ``file.py:function`` (absolute) or ``entry-point:name``.
        sha256: of the file with the function; empty where there is none.
        threshold: success is predicted above it, None where no value is a boundary.
        asked: the user of this process named it; what was read from a file is not run.

    Raises:
        SettingsError: one of them cannot be used.
    """

    name: str
    target: str = field(repr=False)
    sha256: str
    threshold: float | None = None
    asked: bool = field(default=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        if (
            not isinstance(self.name, str)
            or not METRIC_NAME.fullmatch(self.name)
            or self.name == "error"
        ):
            raise SettingsError(
                f"metric: got the name {self.name!r:.80}; allowed are small letters, digits and _, "
                "at most 48, the first a letter; not error"
            )
        _text("metric", self.target)
        if self.sha256 != "":
            _digest("metric", self.sha256)
        value = self.threshold
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise SettingsError(f"metric: {self.name} has threshold {value!r:.80}; give a number")
        if value is not None and not math.isfinite(value):
            raise SettingsError(f"metric: {self.name} has threshold {value}; give a finite one")

    @property
    def column(self) -> str:
        """Its column of the table."""
        return f"metric_{self.name}"

    @classmethod
    def from_dict(cls, data: Any) -> UserMetric:
        """The reference that ``asdict`` gave; raises SettingsError."""
        return cls(**_fields("metric", data, ("name", "target", "sha256", "threshold")))


def plain(references: Any) -> Any:
    """One or several references as plain JSON values."""
    if isinstance(references, tuple):
        return [plain(reference) for reference in references]
    return (
        None
        if references is None
        else {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in asdict(references).items()
            if name != "asked" and (name != "notes" or value)
        }
    )


def metrics_from(data: Any) -> tuple[UserMetric, ...]:
    """What ``plain`` gave of metrics; raises SettingsError."""
    if not isinstance(data, (list, tuple)):
        raise SettingsError(f"metrics: got {data!r:.80}; expected a list")
    return tuple(m if isinstance(m, UserMetric) else UserMetric.from_dict(m) for m in data)


def check_metrics(metrics: Any) -> None:
    """Raise SettingsError unless it is a tuple of metrics with a name each."""
    if not isinstance(metrics, tuple) or not all(isinstance(m, UserMetric) for m in metrics):
        raise SettingsError(f"metrics: got {metrics!r:.80}; expected a tuple of UserMetric")
    names = [m.name for m in metrics]
    if len(names) > MAX_METRICS or len(set(names)) != len(names):
        raise SettingsError(
            f"metrics: got {', '.join(names):.400}; give each name once, {MAX_METRICS} at most"
        )


def _fields(what: str, data: Any, names: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(data, dict) or set(data) != set(names):
        raise SettingsError(f"{what}: got {data!r:.80}; expected {', '.join(names)}")
    return data


def _text(what: str, value: Any) -> None:
    if not isinstance(value, str) or not 0 < len(value) <= _LONGEST or not value.isprintable():
        raise SettingsError(f"{what}: got {value!r:.80}; expected a path or name")


def _digest(what: str, value: Any) -> None:
    if not isinstance(value, str) or not _SHA256.fullmatch(value):
        raise SettingsError(f"{what}: got {value!r:.80}; expected a SHA-256 in hexadecimal")
