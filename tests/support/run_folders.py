"""Run folders of stand-in trials: made without workers, changed, read."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sdh_sim.records import read_rows, write_rows
from sdh_sim.runs import RunFolder, RunPlan, columns_of_run
from sdh_sim.settings import TrialSettings
from tests.support import trial_stand_ins as stand_ins


def table_bytes(out: Path) -> bytes:
    """The run's table as it is on the disk."""
    return (out / "trials.parquet").read_bytes()


def write_finished_run(run: RunPlan, out: Path) -> None:
    """A finished run without the time that workers take to start."""
    rows = [stand_ins.make_row(j.settings.object, j.seed) | {"trial": j.trial} for j in run.jobs()]
    write_rows(rows, out / "trials.parquet")
    RunFolder(out).write_info(run, [{"state": "finished"}])


def write_run_of(rows: Iterable[Mapping[str, Any]], settings: TrialSettings, out: Path) -> Path:
    """A finished run of one object's rows, numbered in order; its folder."""
    numbered = [{**row, "trial": number, "seed": number} for number, row in enumerate(rows)]
    folder = RunFolder(out)
    folder.make()
    write_rows(numbered, folder.table, columns_of_run(settings))
    plan = RunPlan((settings.object,), settings, len(numbered), seed=0)
    folder.write_info(plan, [{"state": "finished"}])
    return out


def drop_rows(out: Path, keep: list[int]) -> None:
    """Leave the trials of those numbers alone in the table."""
    rows = read_rows(out / "trials.parquet")
    write_rows([row for row in rows if row["trial"] in keep], out / "trials.parquet")


def lines(process: subprocess.Popen[str], count: int) -> list[str]:
    """The next lines that a process prints."""
    assert process.stdout is not None
    return [process.stdout.readline().strip() for _ in range(count)]
