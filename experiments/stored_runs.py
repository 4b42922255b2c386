"""Trials of runs, read in the same way by every experiment: those of a killed run too."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa

from sdh_sim.errors import RunError
from sdh_sim.metrics import read_stored
from sdh_sim.runs import OpenedRun, RunPlan, notes_on, open_runs
from sdh_sim.user_references import ObjectFolder


@dataclass(frozen=True)
class StoredRuns:
    """All finished trials of some runs.

    Attributes:
        table: of the columns that all of the runs have.
        rows: its rows as ``read_stored`` gives them.
        plans: of the runs, in order; None where only a table is known.
        folders: of users' objects, by name.
    """

    table: pa.Table
    rows: list[dict[str, Any]]
    plans: tuple[RunPlan | None, ...]
    folders: dict[str, ObjectFolder]

    @property
    def plan(self) -> RunPlan:
        """Of the first run; raises RunError where only a table is known."""
        if self.plans[0] is None:
            raise RunError("the run has no run.json; give the folder that lift made")
        return self.plans[0]


def tell(opened: Sequence[OpenedRun]) -> None:
    """Print on the error stream what a reader of the runs must know."""
    for line in notes_on(opened):
        print(line, file=sys.stderr)


def read_runs(runs: Sequence[Path]) -> StoredRuns:
    """The trials of run folders or of files of trials.

    Raises:
        RunError, RecordError: one that cannot be read, or is given twice.
    """
    with open_runs(runs) as opened:
        tell(opened)
        table, rows = read_stored([run.table for run in opened])
    if not rows:
        raise RunError(f"{runs[0]} holds no finished trial")
    plans = tuple(run.plan for run in opened)
    folders = {
        name: folder for plan in plans if plan is not None for name, folder in plan.folders.items()
    }
    return StoredRuns(table, rows, plans, folders)
