"""``sdh-sim compare``: the comparison as a table on the terminal and as CSV."""

from __future__ import annotations

import csv as csv_module
import io
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from sdh_sim import compare as statistics
from sdh_sim.atomic import write_atomic
from sdh_sim.cli_console import output, plain_table
from sdh_sim.compare import Comparison, Rate
from sdh_sim.run_folder import RunError, RunFolder

_NAMES = {"q_linf": "q* L∞", "q_l1": "q* L1"}
DASH = "-"


def compare(runs: Sequence[Path], csv: Path | None = None) -> None:
    """Print the comparison of the runs' trials; with ``csv`` write its numbers there too."""
    tables = [_table_of(run) for run in runs]
    places = [path.resolve() for path in tables]
    for run, place in zip(runs, places, strict=True):
        if places.count(place) > 1:
            raise RunError(f"{run} is given twice; its trials would count double: give it once")
    trials = statistics.read_trials(tables)
    if not trials.num_rows:
        raise RunError(f"{runs[0]} holds no finished trial yet; continue it with --resume first")
    results = statistics.compare_table(trials)
    if csv is not None:
        write_csv(results, csv)
    output().print(comparison_table(results))
    for line in notes(results, runs):
        output().print(line, markup=False, soft_wrap=True)


def _table_of(run: Path) -> Path:
    if run.is_file():
        return run
    folder = RunFolder(run)
    if not run.is_dir():
        raise RunError(f"{run} does not exist; give the --out of an earlier lift")
    if not folder.table.exists():
        raise RunError(f"{run} holds no run: it has no {folder.table.name}")
    return folder.table


def write_csv(results: Sequence[Comparison], path: Path) -> None:
    """Every number of the comparison; raises RunError where the file cannot be written."""
    text = io.StringIO(newline="")
    writer = csv_module.writer(text, lineterminator="\n")
    writer.writerow(statistics.CSV_HEADER)
    writer.writerows(statistics.csv_row(result) for result in results)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(path, text.getvalue().encode())
    except OSError as error:
        raise RunError(
            f"cannot write {path}: {error.strerror or error}; choose another --csv"
        ) from error


def comparison_table(results: Sequence[Comparison]) -> Table:
    """One line per object and metric; shares and their intervals in percent."""
    table = plain_table(
        "object", "n", "success", "metric", "accuracy %", "TPR %", "FPR %", "AUC", text=(0, 3)
    )
    group = None
    for result in results:
        first = result.group != group
        if first and group is not None:
            table.add_section()
        group = result.group
        success = DASH if result.success.value is None else f"{100 * result.success.value:.0f} %"
        table.add_row(
            result.group if first else "",
            str(result.n) if first else "",
            success if first else "",
            _NAMES.get(result.metric, result.metric),
            _percent(result.accuracy),
            _percent(result.true_positive_rate),
            _percent(result.false_positive_rate),
            _area(result),
        )
    return table


def _percent(rate: Rate) -> str:
    if rate.value is None or rate.interval is None:
        return DASH
    low, high = rate.interval
    return f"{100 * rate.value:.0f} ({100 * low:.0f}–{100 * high:.0f})"


def _area(result: Comparison) -> str:
    if result.auc is None:
        return DASH
    if result.auc_interval is None:
        return f"{result.auc:.2f}"
    low, high = result.auc_interval
    return f"{result.auc:.2f} ({low:.2f}–{high:.2f})"


def notes(results: Sequence[Comparison], runs: Sequence[Path]) -> list[str]:
    """What the reader of the table has to know."""
    lines = [
        f"Success is predicted when q* > {results[0].threshold:g}. In brackets 95 % intervals: "
        "Wilson for shares, bootstrap for AUC.",
    ]
    if any(
        DASH in (_percent(r.true_positive_rate), _percent(r.false_positive_rate), _area(r))
        for r in results
    ):
        lines.append(f"{DASH}: undefined, all trials of the object ended the same way.")
    last = results[-1]
    if last.missing:
        lines.append(f"{last.missing} trials without q* count as q* = 0, a predicted failure.")
    if last.unstable:
        lines.append(f"{last.unstable} trials left out: their simulation was unstable.")
    for run in runs:
        lines += _unfinished(run)
    return lines


def _unfinished(run: Path) -> list[str]:
    folder = RunFolder(run)
    try:
        plan = folder.read_plan()
        rows = statistics.read_trials([folder.table]).num_rows
    except ValueError:  # a bare table: nothing is known about how long it should be
        return []
    if rows >= plan.total:
        return []
    return [f"{run} is unfinished: {rows} of {plan.total} trials ({folder.resume_command})."]
