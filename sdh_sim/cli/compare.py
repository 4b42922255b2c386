"""``sdh-sim compare``: the comparison as tables on the terminal, as CSV and as a report."""

from __future__ import annotations

import csv as csv_module
import io
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from sdh_sim.analysis import comparison as statistics
from sdh_sim.analysis import trial_tables
from sdh_sim.analysis.comparison import ALL_METRICS, METRICS, Comparison, name_of
from sdh_sim.analysis.moments import MOMENTS
from sdh_sim.analysis.study import EVERY, Study, read_study
from sdh_sim.atomic_files import write_atomic
from sdh_sim.cli.console import output, plain_table
from sdh_sim.errors import RunError
from sdh_sim.records import is_metric
from sdh_sim.runs import RunFolder

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
        pictures: how many of the worst mispredictions are run again and drawn in the report.

    Raises:
        RunError: a run or a place to write that cannot be used.
    """
    if pictures and not pages:
        raise RunError("--pictures are of the report; leave out --no-report")
    places = [_table_of(run).resolve() for run in runs]
    for run, place in zip(runs, places, strict=True):
        if places.count(place) > 1:
            raise RunError(f"{run} is given twice; its trials would count double: give it once")
    with tempfile.TemporaryDirectory(prefix="sdh-sim-") as scratch:
        tables = []
        for number, (run, place) in enumerate(zip(runs, places, strict=True)):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            # Trials of a run that goes on, or was killed, are not all in its table yet.
            tables.append(RunFolder(run).whole_table(folder) if run.is_dir() else place)
        study = read_study(tables, ALL_METRICS if every else METRICS, by_hand=by_hand)
    if not study.read:
        raise RunError(f"{runs[0]} holds no finished trial yet; continue it with --resume first")
    if csv is not None:
        write_csv(study.comparisons, csv)
    output().print(comparison_table(study.comparisons))
    output().print(metric_table(study))
    for prefix in dict.fromkeys(m.moment for m in study.moments):
        output().print(moment_table(study, prefix))
    for line in [*notes(study.comparisons, runs), *study_notes(study)]:
        output().print(line, markup=False, soft_wrap=True)
    if pages:
        output().print(_report(study, runs, report, pictures), markup=False, soft_wrap=True)


def _report(study: Study, runs: Sequence[Path], folder: Path | None, pictures: int) -> str:
    """Write the report; the line that says where it is, or how to get one."""
    if folder is None:
        if len(runs) > 1 or not runs[0].is_dir():
            return "No report: it has no place of its own here; give --report FOLDER."
        folder = runs[0] / REPORT
    from sdh_sim.cli.trial_pictures import look_at
    from sdh_sim.report import write_report  # matplotlib takes its time

    names = ", ".join(run.resolve().name for run in runs)
    counted = sum(c.n for c in study.comparisons if c.group == study.main) // len(study.metrics)
    lead = f"{'Runs' if len(runs) > 1 else 'Run'} {names}: {counted} trials compared"
    try:
        page = write_report(study, folder, lead, look=look_at(runs, pictures))
    except OSError as error:
        raise RunError(
            f"cannot write the report to {folder}: {error.strerror or error}; choose another "
            "--report, or --no-report"
        ) from error
    return f"report: {page}"


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
    return table


def metric_table(study: Study) -> Table:
    """Every metric over all trials: average precision, the best threshold, the load test."""
    head = ["metric", "average precision", "best threshold", "accuracy % at it"]
    if study.load:
        head += ["rank corr. with q_sim", "q*/q_sim"]
    table = plain_table(*head)
    for metric in study.metrics:
        finding = study.findings[study.main, metric]
        curve, best = finding.precision_recall, finding.best
        cells = [name_of(metric), DASH, DASH, DASH]
        if curve is not None:
            low, high = curve.area_interval
            cells[1] = f"{curve.area:.2f} ({low:.2f}–{high:.2f})"
        if best is not None:
            cells[2], cells[3] = f"{best.threshold:.3g}", best.accuracy.percent
        if study.load:
            agreement = study.agreement.get((study.main, metric, EVERY))
            cells += [DASH, DASH]
            if agreement is not None and agreement.spearman is not None:
                cells[4] = f"{agreement.spearman:.2f}"
            if agreement is not None and agreement.ratio is not None:
                cells[5] = f"{agreement.ratio.median:.2f}"
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


def notes(results: Sequence[Comparison], runs: Sequence[Path]) -> list[str]:
    """What the reader of the table has to know."""
    lines = [
        f"Success is predicted when q* > {results[0].threshold:g}. In brackets 95 % intervals: "
        "Wilson for shares, bootstrap for AUC.",
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
        missing = max(r.missing for r in results if name_of(r.metric) == name)
        if missing:
            lines.append(f"{missing} trials without {name} are left out of its line.")
    if not all(r.has_boundary or is_metric(r.metric) for r in results):
        lines.append("ε and V have units: for them no threshold of 1 means anything.")
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
    for run in runs:
        lines += _unfinished(run)
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
        lines.append("Best threshold: most accurate; its accuracy is cross-validated in ten folds.")
    pair = study.paired[study.main]
    if pair.disagree.n:
        lines.append(
            f"L∞ and L1 disagree on {pair.disagree.k} of {pair.disagree.n} trials: L∞ alone is "
            f"right on {pair.only_first_right}, L1 alone on {pair.only_second_right} (McNemar's "
            f"exact p = {pair.p_value:.2g})."
        )
    if study.load:
        lines.append(
            "q*/q_sim: median ratio to the load held in simulation; above 1 the metric promises "
            "more."
        )
    if study.surplus:
        lines.append(f"{study.surplus} trials beyond the objects' shares are left out.")
    return lines


def _unfinished(run: Path) -> list[str]:
    folder = RunFolder(run)
    try:
        plan = folder.read_plan()
        rows = trial_tables.read_trials([folder.table]).num_rows
    except ValueError:  # a bare table: nothing is known about how long it should be
        return []
    if rows >= plan.total:
        return []
    return [f"{run} is unfinished: {rows} of {plan.total} trials ({folder.resume_command})."]
