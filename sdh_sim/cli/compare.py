"""``sdh-sim compare``: the comparison as tables on the terminal, as CSV and as a report."""

from __future__ import annotations

import csv as csv_module
import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from sdh_sim.analysis import comparison as statistics
from sdh_sim.analysis.comparison import (
    ALL_METRICS,
    METRICS,
    Comparison,
    drops_missing,
    name_of,
)
from sdh_sim.analysis.moments import MOMENTS
from sdh_sim.analysis.study import EVERY, Study, read_study
from sdh_sim.atomic_files import write_atomic
from sdh_sim.cli.console import output, plain_table
from sdh_sim.errors import RunError
from sdh_sim.records import is_metric
from sdh_sim.runs import OpenedRun, notes_on, open_runs

if TYPE_CHECKING:
    from sdh_sim.analysis.leaderboard import Leaderboard
    from sdh_sim.report.page import Section
    from sdh_sim.report.sections import Draw

DASH = "-"
REPORT = "report"  # folder inside a run's own


def compare(
    runs: Sequence[Path],
    csv: Path | None = None,
    *,
    every: bool = False,
    by_hand: bool = False,
    report: Path | None = None,
    pages: bool = True,
    metrics: Sequence[str] = (),
    workers: int | None = None,
    pictures: int = 0,
) -> None:
    """Print the comparison of the runs' trials and write its report.

    Args:
        runs: run folders, or files of trials.
        csv: write the numbers of the first table there too.
        every: all metrics instead of q* under L-infinity and L1.
        by_hand: runs of different hands may be given, and are shown apart.
        report: folder of the report; None takes RUN/report of a single run folder.
        pages: False writes no report.
        metrics: evaluated anew on the stored grasps and ranked, besides: ``all``, ``field``, names,
            users' own.
        workers: processes that do so; None: one per core.
        pictures: how many of the worst mispredictions are run again and drawn in the report.

    Raises:
        RunError: a run or a place to write that cannot be used.
        SettingsError: a metric that there is not.
    """
    if pictures and not pages:
        raise RunError("--pictures are of the report; leave out --no-report")
    with open_runs(runs) as opened:
        tables = [run.table for run in opened]
        study = read_study(tables, ALL_METRICS if every else METRICS, by_hand=by_hand)
        about_runs = notes_on(opened)
        board = _ranked(opened, metrics, workers) if metrics and study.read else None
    if not study.read:
        raise RunError(f"{runs[0]} holds no finished trial yet; continue it with --resume first")
    if csv is not None:
        write_csv(study.comparisons, csv)
    output().print(comparison_table(study.comparisons))
    output().print(metric_table(study))
    for prefix in dict.fromkeys(m.moment for m in study.moments):
        output().print(moment_table(study, prefix))
    for line in [*notes(study.comparisons), *study_notes(study), *about_runs]:
        output().print(line, markup=False, soft_wrap=True)
    if board is not None:
        _print_board(board, bool(study.load))
    if pages:
        output().print(_report(study, runs, report, board, pictures), markup=False, soft_wrap=True)


def _ranked(
    opened: Sequence[OpenedRun], metrics: Sequence[str], workers: int | None
) -> Leaderboard:
    from sdh_sim.cli.field_comparison import compare_field  # MuJoCo takes its time

    return compare_field(opened, metrics, workers)


def _print_board(board: Leaderboard, load: bool) -> None:
    from sdh_sim.cli.leaderboard_table import leaderboard_notes, leaderboard_table

    output().print(leaderboard_table(board.standings[board.main], load))
    for line in leaderboard_notes(board):
        output().print(line, markup=False, soft_wrap=True)


def _report(
    study: Study,
    runs: Sequence[Path],
    folder: Path | None,
    board: Leaderboard | None,
    pictures: int,
) -> str:
    """Write the report; the line that says where it is, or how to get one."""
    if folder is None:
        if len(runs) > 1 or not runs[0].is_dir():
            return "No report: it has no place of its own here; give --report FOLDER."
        folder = runs[0] / REPORT
    from sdh_sim.cli.trial_pictures import look_at
    from sdh_sim.report import write_report  # matplotlib takes its time

    names = ", ".join(run.resolve().name for run in runs)
    lead = f"{'Runs' if len(runs) > 1 else 'Run'} {names}: {study.compared} trials compared"
    try:
        look = look_at(runs, pictures)
        page = write_report(study, folder, lead, extra=_sections(board), look=look)
    except OSError as error:
        raise RunError(
            f"cannot write the report to {folder}: {error.strerror or error}; choose another "
            "--report, or --no-report"
        ) from error
    return f"report: {page}"


def _sections(board: Leaderboard | None) -> Callable[[Draw], list[Section]] | None:
    """What the page shows of the metrics side by side."""
    if board is None:
        return None
    from sdh_sim.report.leaderboard_section import leaderboard_section

    return lambda draw: [leaderboard_section(board, draw)]


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
    """One line per object and metric; shares and their intervals in percent.

    n and the share of successes stand where they differ from the line above: a metric may lack
    values.
    """
    table = plain_table(
        "object", "n", "success", "metric", "accuracy %", "TPR %", "FPR %", "AUC", text=(0, 3)
    )
    group, shown = None, 0
    for result in results:
        first = result.group != group
        if first and group is not None:
            table.add_section()
        group = result.group
        success = DASH if result.success.value is None else f"{100 * result.success.value:.0f} %"
        table.add_row(
            result.group if first else "",
            str(result.n) if first or result.n != shown else "",
            success if first or result.n != shown else "",
            name_of(result.metric),
            *(
                rate.percent if result.has_boundary else DASH
                for rate in (
                    *(result.accuracy, result.true_positive_rate),
                    result.false_positive_rate,
                )
            ),
            result.area(),
        )
        shown = result.n
    return table


def metric_table(study: Study) -> Table:
    """Every metric over all trials: average precision, the best threshold, the load test."""
    head = ["metric", "n", "average precision", "best threshold", "accuracy % at best"]
    if study.load:
        head += ["n with q_sim", "rank corr.", "q*/q_sim"]
    table = plain_table(*head)
    for metric in study.metrics:
        finding = study.findings[study.main, metric]
        curve, best = finding.precision_recall, finding.best
        cells = [name_of(metric), str(finding.comparison.n), DASH, DASH, DASH]
        if curve is not None:
            low, high = curve.area_interval
            cells[2] = f"{curve.area:.2f} ({low:.2f}–{high:.2f})"
        if best is not None:
            cells[3], cells[4] = f"{best.threshold:.3g}", best.accuracy.percent
        if study.load:
            agreement = study.agreement.get((study.main, metric, EVERY))
            cells += [str(agreement.n), DASH, DASH] if agreement else [DASH] * 3
            if agreement is not None and agreement.spearman is not None:
                cells[6] = f"{agreement.spearman:.2f}"
            if agreement is not None and agreement.ratio is not None:
                low, high = agreement.ratio.median_interval
                cells[7] = f"{agreement.ratio.median:.2f} ({low:.2f}–{high:.2f})"
        table.add_row(*cells)
    return table


def moment_table(study: Study, prefix: str) -> Table:
    """Every q* before the lift and at a later moment; p is McNemar's, of their accuracies."""
    later = MOMENTS[prefix]
    head = ("metric", "n", "AUC before the lift", later, "accuracy % before", later,
            "FPR % before", later, "p")  # fmt: skip
    table = plain_table(*head)
    for m in (m for m in study.moments if m.moment == prefix):
        rates = (*(c.accuracy for c in (m.before, m.after)),
                 *(c.false_positive_rate for c in (m.before, m.after)))  # fmt: skip
        table.add_row(name_of(m.before.metric), str(m.before.n), m.before.area(), m.after.area(),
                      *(rate.percent for rate in rates), f"{m.paired.p_value:.2g}")  # fmt: skip
    return table


def notes(results: Sequence[Comparison]) -> list[str]:
    """What the reader of the table has to know."""
    lines = [
        f"Success is predicted when q* > {results[0].threshold:g}. In brackets 95 % intervals: "
        "score intervals of shares (Wilson) and of AUC.",
    ]
    if any(r.auc is None for r in results):
        lines.append(f"{DASH}: undefined, all trials of the object ended the same way.")
    bounds = {name_of(r.metric): r for r in results if is_metric(r.metric)}
    for name, r in bounds.items():
        lines.append(
            f"{name}: success is predicted above {r.threshold:g}."
            if r.has_boundary
            else f"{name} states no threshold above which success is predicted."
        )
    if not all(r.has_boundary or is_metric(r.metric) for r in results):
        lines.append("ε and V have units: for them no threshold of 1 means anything.")
    for metric in dict.fromkeys(r.metric for r in results if drops_missing(r.metric)):
        missing = max(r.missing for r in results if r.metric == metric)
        if missing:
            lines.append(f"{missing} trials without {name_of(metric)} are left out of its lines.")
    first = results[0]
    last = next(r for r in reversed(results) if r.metric == first.metric)
    if last.missing:
        lines.append(f"{last.missing} trials without q* count as q* = 0, a predicted failure.")
    lines += contact_notes(results)
    if last.unstable:
        lines.append(
            f"{last.unstable} trials left out: their simulation was unstable or broke off."
        )
    if last.infeasible:
        lines.append(
            f"{last.infeasible} trials left out: the arm cannot do their grasp without a collision "
            "(infeasible_reason in the table)."
        )
    return lines


def contact_notes(results: Sequence[Comparison]) -> list[str]:
    """The accuracy without the trials in which the hand never touched, where there are some."""
    lines = []
    for group in dict.fromkeys(r.group for r in results):
        own = [r for r in results if r.group == group and r.no_contact and r.has_boundary]
        if not own:
            continue
        shares = ", ".join(f"{name_of(r.metric)} {r.accuracy_touching.percent} %" for r in own)
        lines.append(
            f"In {own[0].no_contact} of {own[0].n} trials ({group}) the hand did not touch the "
            f"object (no_contact). Without them {own[0].n - own[0].no_contact} remain, and the "
            f"accuracy is {shares}."
        )
        if any(r.carried for r in own):
            lines.append(
                f"warning: {group}: trials without contact carry the accuracy; any metric predicts "
                "them. Aim better (grasp.offset in object.toml), or go by the numbers without them."
            )
    return lines


def study_notes(study: Study) -> list[str]:
    """What the statistics over all trials say in words."""
    lines = []
    if any(study.findings[study.main, m].best for m in study.metrics):
        lines.append(
            "Best threshold: the most accurate one on all trials; its accuracy is on trials that "
            "did not choose it (ten folds)."
        )
    pair = study.paired[study.main]
    if pair.disagree.n:
        lines.append(
            f"L∞ and L1 disagree on {pair.disagree.k} of {pair.disagree.n} trials: L∞ alone is "
            f"right on {pair.only_first_right}, L1 alone on {pair.only_second_right} (McNemar's "
            f"exact p = {pair.p_value:.2g})."
        )
    if study.load:
        lines.append(
            "q*/q_sim: median ratio to the load held in simulation with its interval, over all "
            "that gave way, 0 and infinity included; above 1 the metric promises more."
        )
    if study.surplus:
        lines.append(f"{study.surplus} trials beyond the objects' shares are left out.")
    return lines
