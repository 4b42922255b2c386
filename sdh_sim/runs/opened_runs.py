"""Runs opened to be read: all finished trials of each, and what whoever reads several must know."""

from __future__ import annotations

import contextlib
import itertools
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.errors import RunError
from sdh_sim.records import HAND_NAME, columns_of, is_metric, read_table
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import RunPlan
from sdh_sim.runs.shards import shard_files

_TRIAL = ("object", "seed")
_OUTCOME = ("success", "failure", "q_linf", "q_l1")
_NAMED = 4  # settings that a note names at most


@dataclass(frozen=True)
class OpenedRun:
    """A run whose trials can be read.

    Attributes:
        given: its folder, or the file of its trials, as it was given.
        table: a table of all its finished trials, those of a killed run included; there only while
            the runs are open.
        plan: what it was asked to do; None where only a table is known.
        rows: its number of finished trials.
    """

    given: Path
    table: Path
    plan: RunPlan | None
    rows: int


@contextlib.contextmanager
def open_runs(runs: Sequence[Path]) -> Iterator[tuple[OpenedRun, ...]]:
    """Runs as they are now, also while they go on or after they were killed.

    Args:
        runs: run folders, or files of trials.

    Raises:
        RunError: one does not exist, holds no run, is damaged or was given twice, also as a copy.
        RecordError: a file is no table of trials.
    """
    places = [_table_of(run).resolve() for run in runs]
    for run, place in zip(runs, places, strict=True):
        if places.count(place) > 1:
            raise RunError(f"{run} is given twice; its trials would count double: give it once")
    with tempfile.TemporaryDirectory(prefix="sdh-sim-") as scratch:
        opened = []
        for number, (run, place) in enumerate(zip(runs, places, strict=True)):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            table, plan = place, None
            if run.is_dir():
                table = RunFolder(run).whole_table(folder)
                with contextlib.suppress(RunError):  # the table alone can be read as well
                    plan = RunFolder(run).read_plan()
            columns = read_table(table, ["object"])
            opened.append(OpenedRun(run, table, plan, columns.num_rows))
        _refuse_copies(opened)
        yield tuple(opened)


def notes_on(opened: Sequence[OpenedRun]) -> list[str]:
    """Sentences about what is unfinished, and about what differs between the runs."""
    lines = []
    for run in opened:
        if run.plan is not None and run.rows < run.plan.total:
            lines.append(
                f"{run.given} is unfinished: {run.rows} of {run.plan.total} trials "
                f"({RunFolder(run.given).resume_command})."
            )
    first, *others = opened
    for run in others:
        lines += _differences(first, run)
    return lines


def _differences(first: OpenedRun, other: OpenedRun) -> list[str]:
    lines = []
    if first.plan is not None and other.plan is not None:
        mine, theirs = (_settings(plan) for plan in (first.plan, other.plan))
        names = [name for name in mine if mine[name] != theirs[name]]
        if names:
            shown = ", ".join(f"{n} {mine[n]} and {theirs[n]}" for n in names[:_NAMED])
            more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
            lines.append(
                f"{first.given} and {other.given} were run with other settings ({shown}{more}): "
                "their trials are counted together all the same."
            )
    shared = _shared_trials(first, other)
    if shared:
        lines.append(
            f"{shared} trials of {other.given} have object and seed of trials of {first.given}: "
            "the same grasps in part, so that the intervals are too narrow."
        )
    names = [_metrics(run.table) for run in (first, other)]
    for run, mine, theirs in zip((first, other), names, names[::-1], strict=True):
        if alone := [name for name in mine if name not in theirs]:
            lines.append(f"Only {run.given} has {', '.join(alone)}: left out.")
    return lines


def _metrics(table: Path) -> list[str]:
    """Columns of metrics that a table has."""
    return [n for n in pq.read_schema(table).names if n.startswith("q_") or is_metric(n)]


def _settings(plan: RunPlan) -> dict[str, object]:
    """Settings of all trials by name, contents in the place of paths."""
    return {
        name: value
        for name, value in plan.contents().items()
        if name not in ("objects", "trials", "seed", "folders", "grasp_counts")
    }


def _refuse_copies(opened: Sequence[OpenedRun]) -> None:
    for first, other in itertools.combinations(opened, 2):
        shared = _shared_trials(first, other, ends_too=True)
        alike = shared and shared == _shared_trials(first, other)
        if first.plan is not None and other.plan is not None:
            alike = alike and _settings(first.plan) == _settings(other.plan)
        if alike:
            raise RunError(
                f"{shared} trials of {other.given} are trials of {first.given} too (object, seed "
                "and outcome); they would count double: give each trial once"
            )


def _shared_trials(first: OpenedRun, other: OpenedRun, ends_too: bool = False) -> int:
    """How many trials have the same hand, object and seed (and the same end, where asked)."""
    names = (*_TRIAL, *(_OUTCOME if ends_too else ()))
    found = [_keys(run.table, names) for run in (first, other)]
    return len(found[0] & found[1])


def _keys(path: Path, names: Sequence[str]) -> set[tuple]:
    hand = columns_of([path], (HAND_NAME,))
    table: pa.Table = read_table(path, [*names, *hand])
    return set(zip(*(table.column(n).to_pylist() for n in table.column_names), strict=True))


def _table_of(run: Path) -> Path:
    if run.is_file():
        return run
    folder = RunFolder(run)
    if not run.is_dir():
        raise RunError(f"{run} does not exist; give the --out of an earlier lift")
    if not folder.table.exists() and not shard_files(folder.shards):
        raise RunError(f"{run} holds no run: it has no {folder.table.name}")
    return folder.table
