"""Section IV-B on simulated grasps: figures 7 and 8 beside the paper's numbers, and all metrics.

The predictions are computed again from the stored snapshots, with the distal pads as in the paper.
The same page compares the metrics under other assumptions, and predictors without wrenches.

    python -m experiments.success_prediction runs/paper
"""

from __future__ import annotations

import argparse
import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from experiments.command_line import Parser, fail
from experiments.stored_runs import read_runs
from experiments.success_prediction import baselines
from experiments.success_prediction.candidates import plain_candidates, wrench_candidates
from experiments.success_prediction.load_reasons import load_section
from experiments.success_prediction.metric_grid import (
    REPORTED,
    MapRows,
    Variant,
    evaluate_all,
    grid,
)
from experiments.success_prediction.metric_scores import (
    Result,
    assess,
    forest,
    results_table,
)
from experiments.success_prediction.published import DERIVED, GRASPS, REFERENCE
from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.moments import MOMENT_COLUMNS
from sdh_sim.analysis.study import Study, study_of
from sdh_sim.analysis.trial_tables import SURPLUS
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.report import write_report
from sdh_sim.report.data_tables import write_table
from sdh_sim.report.page import Paragraph, Section, Table
from sdh_sim.report.sections import Draw
from sdh_sim.report.table_cells import number, object_name, percent
from sdh_sim.user_references import ObjectFolder

FOLDER = "success_prediction"


def main(argv: Sequence[str] | None = None) -> None:
    """Evaluate, compare, write the report."""
    args = _arguments(argv)
    try:
        stored = read_runs(args.runs)
    except (RecordError, RunError) as error:
        fail(str(error))
    table, rows = stored.table, stored.rows
    unseen = unseen_contacts(rows, args.pads)
    rows = [{**row, "unsensed_contact": flag} for row, flag in zip(rows, unseen, strict=True)]
    variants = grid(args.full)
    in_parallel = functools.partial(run_all, title="metrics", workers=args.workers)
    try:
        pads = {plan.settings.pads for plan in stored.plans if plan is not None}
        values = evaluated(rows, variants, in_parallel, stored.folders)
    except (SettingsError, RunError) as error:
        fail(str(error))
    table = _with_column(table, "unsensed_contact", pa.array(unseen))
    compared_table = with_pads(table, values, args.pads)
    if pads == {args.pads}:  # the metrics at lift-off are those of the run's own pads
        compared_table = with_lift_off(compared_table, stored.table)
    study = study_of(compared_table, tuple(REPORTED))
    results = assess(table, [*wrench_candidates(values), *plain_candidates(rows, table)])
    folder = args.out or args.runs[0] / FOLDER
    names = ", ".join(run.resolve().name for run in args.runs)

    def sections(draw: Draw) -> list[Section]:
        found = [paper_section(study), metrics_section(results, draw)]
        if study.load:
            found.append(load_section(study, rows, values, args.pads))
        return found

    try:
        page = write_report(
            study,
            folder,
            f"Runs: {names}. {study.compared} trials, predictions from the {args.pads} pads.",
            REFERENCE,
            sections,
        )
        write_table([r.record() for r in results], folder / "metrics")
        write_table(_score_rows(rows, values), folder / "scores")
    except OSError as error:
        fail(f"cannot write to {folder}: {error.strerror or error}; choose another --out")
    for result in results:
        print(result.line())
    print(f"report: {page}")


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(__doc__)
    parser.prog = "success_prediction"
    parser.add_argument("runs", type=Path, nargs="+", help="run folders")
    parser.add_argument("--out", type=Path, help=f"folder (default: {FOLDER} in the run)")
    parser.add_argument("--pads", choices=("distal", "all"), default="distal",
                        help="pads that the figures' predictions use (distal)")  # fmt: skip
    parser.add_argument("--full", action="store_true", help="cross all assumptions")
    parser.add_argument("--workers", type=int, help="processes (default: one per core)")
    args = parser.parse_args(argv)
    if len(args.runs) > 1 and args.out is None:
        fail("several runs have no common folder: give --out")
    if args.out is None and not args.runs[0].is_dir():
        fail(f"{args.runs[0]} is not a run folder: give one, or --out")
    return args


def evaluated(
    rows: Sequence[Mapping[str, Any]],
    variants: Sequence[Variant],
    run: MapRows,
    folders: Mapping[str, ObjectFolder],
) -> dict[Variant, np.ndarray]:
    """Values (n,) of every variant; NaN for surplus trials, which are not compared."""
    counted = np.array([not row.get(SURPLUS) for row in rows])
    kept = [row for row, c in zip(rows, counted, strict=True) if c]
    found = evaluate_all(kept, variants, run, folders)
    values = {}
    for variant, column in found.items():
        values[variant] = np.full(len(rows), np.nan)
        values[variant][counted] = column
    return values


def unseen_contacts(rows: Sequence[Mapping[str, Any]], pads: str) -> list[bool]:
    """Whether a trial has a contact force that the chosen pads do not measure."""
    return [
        bool(row.get("unsensed_contact"))
        or (pads == "distal" and baselines.pads_in_contact(row, ["tactile_proximal"]) > 0)
        for row in rows
    ]


def with_pads(table: pa.Table, values: dict[Variant, np.ndarray], pads: str) -> pa.Table:
    """The table with the task scalings predicted from the chosen pads."""
    for name, variant in REPORTED.items():
        scores = values[replace(variant, pads=pads)]
        table = _with_column(table, name, pa.array(scores, from_pandas=True))
    return table


def with_lift_off(table: pa.Table, stored: pa.Table) -> pa.Table:
    """The table with the task scalings at lift-off, where all of the runs have them."""
    for name in (name for name in MOMENT_COLUMNS if name in stored.column_names):
        table = _with_column(table, name, stored.column(name))
    return table


def _with_column(table: pa.Table, name: str, column: pa.Array) -> pa.Table:
    if name in table.column_names:
        return table.set_column(table.column_names.index(name), name, column)
    return table.append_column(name, column)


def paper_section(study: Study) -> Section:
    """The paper's numbers beside the simulation's."""
    names = {"accuracy": "accuracy", "tpr": "true positive rate", "tnr": "true negative rate"}
    rows = []
    for (group, metric), published in REFERENCE.items():
        if (group, metric) not in study.findings:
            continue
        c = study.findings[group, metric].comparison
        own = {"accuracy": c.accuracy, "tpr": c.true_positive_rate, "tnr": c.true_negative_rate}
        for key, value in published.items():
            star = " (derived)" if (group, key) in DERIVED else ""
            label = [object_name(group), compare.NAMES[metric]]
            if key == "auc":
                cells = [f"{value:.3f}", number(c.auc, c.auc_interval, 3)]
            else:
                cells = [f"{100 * value:.1f} %", percent(own[key])]
            rows.append([*label, names.get(key, "AUC") + star, *cells])
    return Section(
        "Beside the paper",
        (
            Table(
                f"Published numbers of {GRASPS} real grasps, half of them stable, and the same "
                "numbers of the simulated ones [shares in %, 95 % intervals].",
                ["object", "metric", "number", "published", "simulated"],
                rows,
                text_columns=(0, 1, 2),
            ),
        ),
    )


def metrics_section(results: Sequence[Result], draw: Draw) -> Section:
    """All metrics and baselines, compared on the same grasps."""
    figure = draw(
        "metrics",
        forest(results),
        "Area under the ROC curve, and accuracy with a threshold chosen on other trials, of "
        "every metric; full dots: distal pads, hollow: all pads; 95 % intervals. Dashed: chance, "
        "and the accuracy of always predicting the more frequent outcome.",
    )
    files = "The table is metrics.csv; the scores of every single grasp are in scores.csv."
    parts = (figure, results_table(results), Paragraph(files))
    return Section("All metrics on the same grasps", parts)


def _score_rows(
    rows: Sequence[Mapping[str, Any]], values: dict[Variant, np.ndarray]
) -> list[dict[str, Any]]:
    found = []
    for k, row in enumerate(rows):
        record = {name: row[name] for name in ("trial", "object", "seed", "success", "failure")}
        found.append(record | {v.key: float(scores[k]) for v, scores in values.items()})
    return found


if __name__ == "__main__":
    main()
