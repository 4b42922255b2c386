"""Users' metrics: functions of a ``PerceivedGrasp`` that are named on the command line.

A run keeps only their names and the SHA-256 of their files. Code that a run's folder refers to is
never run by that alone: a user who continues a run names its metrics again.
"""

from __future__ import annotations

import copy
import hashlib
import importlib
import importlib.metadata
import math
import os
import re
import sys
import types
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from sdh_sim.errors import SettingsError
from sdh_sim.records import METRIC_ERROR
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.user_references import UserMetric

GROUP = "sdh_sim.metrics"  # of entry points
_ENTRY = "entry-point:"
_MODULE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*")

Metric = Callable[[PerceivedGrasp], float]


def find_metrics(asked: Sequence[str], known: Sequence[UserMetric] = ()) -> tuple[UserMetric, ...]:
    """The metrics asked for, sorted by name.

    Args:
        asked: ``module:function``, ``file.py:function``, or the name of an entry point.
        known: the metrics of the run that goes on; those from entry points need not be named.

    Raises:
        SettingsError: there is no such metric, its code fails, or it is not what it was.
    """
    targets = [_target(text) for text in asked]
    targets += [m.target for m in known if m.target.startswith(_ENTRY)]
    found = [_reference(target) for target in dict.fromkeys(targets)]
    earlier = {m.name: m for m in known}
    for metric in found:
        before = earlier.pop(metric.name, metric)
        if before.sha256 != metric.sha256:
            raise _changed(metric)
    if earlier:
        again = " ".join(f"--metric {m.target}" for m in earlier.values())
        raise SettingsError(
            f"metric: this run computes {', '.join(earlier):.400}; name the code yourself with "
            f"{again:.800} (what a run's folder names is not run unasked)"
        )
    return tuple(sorted(found, key=lambda m: m.name))


def evaluate_user_metrics(grasp: PerceivedGrasp, metrics: Iterable[UserMetric]) -> dict[str, Any]:
    """The columns that users' metrics add to a row.

    Each metric gets a copy of the grasp. The value of one that raises, or gives no number, is NaN,
    and the column ``metric_error`` gives the reason, one line for each.

    Raises:
        SettingsError: a metric's code is missing here or is not what the run began with.
    """
    row: dict[str, Any] = {}
    faults = []
    for metric in metrics:
        function = load_metric(metric)
        try:
            row[metric.column] = _number(function(copy.deepcopy(grasp)))
        except (Exception, SystemExit) as error:
            row[metric.column] = math.nan
            faults.append(f"{metric.name}: {summary(error)}")
    if row:
        row[METRIC_ERROR] = "\n".join(faults)
    return row


def fault_lines(notes: Iterable[str | None], total: int) -> list[str]:
    """A sentence for every metric that failed.

    Args:
        notes: the column ``metric_error``.
        total: number of trials.
    """
    count = Counter[str]()
    first: dict[str, str] = {}
    for line in (line for note in notes if note for line in note.splitlines()):
        name, _, why = line.partition(": ")
        count[name] += 1
        first.setdefault(name, why)
    return [
        f"metric {name} failed in {n} of {total} trials, the first time with {first[name]}; they "
        "have no value of it"
        for name, n in sorted(count.items())
    ]


def load_metric(metric: UserMetric) -> Metric:
    """The function; raises SettingsError where it is missing or is not what it was.

    A metric that was read from a run's folder and not named by the user is refused.
    """
    if not metric.asked:
        raise SettingsError(
            f"metric: {metric.name} is known from a file alone; name its code with --metric "
            f"{metric.target} (find_metrics in a program)"
        )
    function, sha256 = _load(metric.target)
    if sha256 != metric.sha256:
        raise _changed(metric)
    return function


def _number(value: Any) -> float:
    """What a metric gave, as a number; raises TypeError or ValueError."""
    if isinstance(value, (str, bytes)):
        raise TypeError(f"gave {value!r:.40}, not a number")
    return float(value)


def summary(error: BaseException) -> str:
    """Type and first line of an error."""
    text = (str(error).splitlines() or [""])[0][:160]
    return f"{type(error).__name__}: {text}".removesuffix(": ")


def _changed(metric: UserMetric) -> SettingsError:
    """The error for a metric whose file is not what it was."""
    return SettingsError(
        f"metric: {metric.target} has changed since the run began; bring its file back, or start "
        "a run of its own with another --out"
    )


def _target(text: str) -> str:
    """What was asked for in the form in which a run keeps it; raises SettingsError."""
    place, colon, function = text.rpartition(":")
    if not colon:
        return _ENTRY + text
    if not function.isidentifier():
        raise SettingsError(f"metric: got {text!r:.200}; after the colon goes a function's name")
    if place.endswith(".py"):
        return f"{Path(place).expanduser().absolute()}:{function}"
    if not _MODULE.fullmatch(place):
        raise SettingsError(
            f"metric: got {text!r:.200}; give module:function, file.py:function, or the name of "
            f"an entry point ({_entry_names()})"
        )
    return text


def _entry_names() -> str:
    """The installed entry points, for a message."""
    names = sorted({entry.name for entry in importlib.metadata.entry_points(group=GROUP)})
    return f"installed: {', '.join(names)}" if names else "none is installed"


def _reference(target: str) -> UserMetric:
    """The reference to a metric that the user names; its code is run to load it."""
    function, sha256 = _load(target)
    threshold = getattr(function, "threshold", None)
    if threshold is not None:
        try:
            threshold = float(threshold)
        except (TypeError, ValueError) as error:
            raise SettingsError(
                f"metric: {target} has threshold {threshold!r:.80}; give a number"
            ) from error
    return UserMetric(target.rpartition(":")[2], target, sha256, threshold, asked=True)


@lru_cache(maxsize=256)
def _load(target: str) -> tuple[Metric, str]:
    """The function of a target and the SHA-256 of its file; raises SettingsError."""
    place, _, name = target.rpartition(":")
    try:
        if target.startswith(_ENTRY):
            function, module = _from_entry(target.removeprefix(_ENTRY))
        elif place.endswith(".py"):
            return _from_file(Path(place), name)
        else:
            module = _import(place)
            function = getattr(module, name)
    except SettingsError:
        raise
    except (Exception, SystemExit) as error:
        raise SettingsError(f"metric: {target} cannot be loaded ({summary(error)})") from error
    return _as_function(function, target), _sha256_of(module)


def _from_entry(name: str) -> tuple[Any, Any]:
    """What an entry point names, and its module."""
    found = [entry for entry in importlib.metadata.entry_points(group=GROUP) if entry.name == name]
    if not found:
        raise SettingsError(
            f"metric: got {name!r:.200}; there is no entry point of that name in the group "
            f"{GROUP} ({_entry_names()}); or give module:function or file.py:function"
        )
    function = found[0].load()
    return function, sys.modules.get(found[0].module)


def _from_file(path: Path, name: str) -> tuple[Metric, str]:
    """A function of a file, and the SHA-256 of the bytes that were run."""
    source = path.read_bytes()
    sha256 = hashlib.sha256(source).hexdigest()
    module = types.ModuleType(f"sdh_sim_metric_{sha256[:16]}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # where dataclasses and pickle look
    exec(compile(source, str(path), "exec"), module.__dict__)
    return _as_function(getattr(module, name), f"{path}:{name}"), sha256


def _import(name: str) -> types.ModuleType:
    """A module that is installed or lies in the working folder."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        # Last on the path, so that nothing in the working folder hides an installed package.
        here = os.getcwd()
        if here in sys.path or error.name != name.partition(".")[0]:
            raise
        sys.path.append(here)
        importlib.invalidate_caches()
        return importlib.import_module(name)


def _as_function(function: Any, target: str) -> Metric:
    """What a target names, which must be callable; raises SettingsError."""
    if not callable(function):
        raise SettingsError(f"metric: {target} is a {type(function).__name__}; give a function")
    return cast(Metric, function)


def _sha256_of(module: Any) -> str:
    """Of the module's file; empty where it has none."""
    try:
        return hashlib.sha256(Path(module.__file__).read_bytes()).hexdigest()
    except (OSError, TypeError, AttributeError):
        return ""  # built in, or in an archive: no file to compare
