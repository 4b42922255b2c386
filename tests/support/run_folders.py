"""Run folders of stand-in trials: made without workers, changed, read."""

from __future__ import annotations

import subprocess
from pathlib import Path

from sdh_sim.records import read_rows, write_rows
from sdh_sim.runs import RunFolder, RunPlan
from tests.support import trial_stand_ins as stand_ins


def table_bytes(out: Path) -> bytes:
    """The run's table as it is on the disk."""
    return (out / "trials.parquet").read_bytes()


def write_finished_run(run: RunPlan, out: Path) -> None:
    """A finished run without the time that workers take to start."""
    rows = [stand_ins.make_row(j.settings.object, j.seed) | {"trial": j.trial} for j in run.jobs()]
    write_rows(rows, out / "trials.parquet")
    RunFolder(out).write_info(run, [{"state": "finished"}])


def drop_rows(out: Path, keep: list[int]) -> None:
    """Leave the trials of those numbers alone in the table."""
    rows = read_rows(out / "trials.parquet")
    write_rows([row for row in rows if row["trial"] in keep], out / "trials.parquet")


def lines(process: subprocess.Popen[str], count: int) -> list[str]:
    """The next lines that a process prints."""
    assert process.stdout is not None
    return [process.stdout.readline().strip() for _ in range(count)]
