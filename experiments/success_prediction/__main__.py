"""Section IV-B on simulated grasps: figures 7 and 8 beside the paper's numbers, and every metric.

The predictions are computed anew from the stored snapshots, from the distal pads as in the paper;
beside them stand the metrics under other assumptions, and predictors without wrenches.

    python -m experiments.success_prediction runs/paper
"""

from __future__ import annotations

import argparse
import functools
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pyarrow as pa

from experiments.parallel import run_all
from experiments.success_prediction import baselines
from experiments.success_prediction.load_reasons import load_section
from experiments.success_prediction.metric_grid import MapRows, Variant, evaluate_all, grid
from experiments.success_prediction.metric_scores import (
    Candidate,
    Result,
    assess,
    forest,
    results_table,
)
from experiments.success_prediction.published import DERIVED, GRASPS, REFERENCE
from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.study import Study, study_of
from sdh_sim.analysis.trial_tables import SURPLUS
from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.metrics.stored_grasps import read_stored
from sdh_sim.report import html
from sdh_sim.report.data_tables import write_table
from sdh_sim.report.html import Section
from sdh_sim.report.report import Draw, write_report
from sdh_sim.runs.folder import RunFolder
from sdh_sim.user_references import ObjectFolder

FOLDER = "success_prediction"
_COLUMNS = {
    "q_linf": ("q", "linf", "hf"),
    "q_l1": ("q", "l1", "hf"),
    "q_capability": ("capability", "", ""),
    "q_held": ("held", "", ""),
    "q_whole_hand": ("whole", "", ""),
}


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line and exits with status 2."""

    def error(self, message: str) -> NoReturn:
        """See the class."""
        fail(message)


def fail(message: str) -> NoReturn:
    """Print one line to the error stream and exit with status 2."""
    print(f"success_prediction: {message}", file=sys.stderr)
    raise SystemExit(2)


def main(argv: Sequence[str] | None = None) -> None:
    """Evaluate, compare, write the report."""
    args = _arguments(argv)
    tables = [RunFolder(run).table if run.is_dir() else run for run in args.runs]
    try:
        table, rows = read_stored(tables)
    except RecordError as error:
        fail(str(error))
    if not rows:
        fail(f"{args.runs[0]} holds no finished trial")
    unseen = unseen_contacts(rows, args.pads)
    rows = [{**row, "unsensed_contact": flag} for row, flag in zip(rows, unseen, strict=True)]
    variants = grid(args.full)
    in_parallel = functools.partial(run_all, title="metrics", workers=args.workers)
    try:
        folders = {}
        for run in args.runs:
            if (run / "run.json").exists():
                folders |= RunFolder(run).read_plan().folders
        values = evaluated(rows, variants, in_parallel, folders)
    except (SettingsError, RunError) as error:
        fail(str(error))
    table = _with_column(table, "unsensed_contact", pa.array(unseen))
    study = study_of(with_pads(table, values, args.pads), tuple(_COLUMNS))
    results = assess(table, [*wrench_candidates(values), *plain_candidates(rows, table)])
    folder = args.out or args.runs[0] / FOLDER
    names = ", ".join(run.resolve().name for run in args.runs)
    compared = study.findings[study.main, "q_linf"].comparison.n

    def sections(draw: Draw) -> list[Section]:
        found = [paper_section(study), metrics_section(results, draw)]
        if study.load:
            found.append(load_section(study, rows, values, args.pads))
        return found

    try:
        page = write_report(
            study,
            folder,
            f"Runs: {names}. {compared} trials, predictions from the {args.pads} pads.",
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
    parser = Parser(prog="success_prediction", description=(__doc__ or "").splitlines()[0])
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
    if len({run.resolve() for run in args.runs}) != len(args.runs):
        fail("a run is given twice; its trials would count double")
    return args


def evaluated(
    rows: Sequence[dict[str, Any]],
    variants: Sequence[Variant],
    run: MapRows,
    folders: Mapping[str, ObjectFolder],
) -> dict[Variant, np.ndarray]:
    """Values (n,) of every variant; NaN for trials beyond their share, which count nowhere."""
    counted = np.array([not row.get(SURPLUS) for row in rows])
    kept = [row for row, c in zip(rows, counted, strict=True) if c]
    found = evaluate_all(kept, variants, run, folders)
    values = {}
    for variant, column in found.items():
        values[variant] = np.full(len(rows), np.nan)
        values[variant][counted] = column
    return values


def unseen_contacts(rows: Sequence[dict[str, Any]], pads: str) -> list[bool]:
    """Whether anything bears force in a trial that the chosen pads do not feel."""
    return [
        bool(row.get("unsensed_contact"))
        or (pads == "distal" and baselines.pads_in_contact(row, ["tactile_proximal"]) > 0)
        for row in rows
    ]


def with_pads(table: pa.Table, values: dict[Variant, np.ndarray], pads: str) -> pa.Table:
    """The table with the task scalings as predicted from certain pads."""
    for name, (kind, bound, augment) in _COLUMNS.items():
        scores = values[Variant(kind, bound, 12, augment, True, pads)]
        table = _with_column(table, name, pa.array(scores, from_pandas=True))
    return table


def _with_column(table: pa.Table, name: str, column: pa.Array) -> pa.Table:
    if name in table.column_names:
        return table.set_column(table.column_names.index(name), name, column)
    return table.append_column(name, column)


def wrench_candidates(values: dict[Variant, np.ndarray]) -> list[Candidate]:
    """The metrics as predictors."""
    return [
        Candidate(
            group=v.group,
            assumes=v.assumes,
            pads=v.pads,
            scores=scores,
            boundary=1.0 if v.has_boundary else None,
            drop_missing=v.kind == "volume",
            is_load=v.has_boundary,
        )
        for v, scores in values.items()
    ]


def plain_candidates(rows: Sequence[dict[str, Any]], table: pa.Table) -> list[Candidate]:
    """Predictors without wrenches; the learned ones where scikit-learn is installed."""
    found = []
    for pads, kinds in (("distal", baselines.PAD_KINDS[:1]), ("all", baselines.PAD_KINDS)):
        for text, function in (
            ("sum of readings", baselines.sum_of_readings),
            ("number of pads in contact", baselines.pads_in_contact),
            ("number of active taxels", baselines.active_taxels),
        ):
            scores = np.array([function(row, kinds) for row in rows])
            found.append(Candidate("no wrenches", text, pads, scores))
    if not baselines.has_learning():
        print("without scikit-learn (the extra 'learn'): no logistic regression", file=sys.stderr)
        return found
    tactile = np.array([baselines.tactile_features(row) for row in rows])
    joints = np.array([baselines.joint_features(row) for row in rows])
    known = np.array([baselines.object_features(row) for row in rows])
    for text, features in (
        ("tactile", (tactile,)),
        ("tactile and joints", (tactile, joints)),
        ("tactile, joints, object pose", (tactile, joints, known)),
    ):
        scores = _learn(np.hstack(features), table)
        if scores is not None:
            found.append(Candidate("logistic regression", text, "all", scores, boundary=0.5))
    return found


def _learn(features: np.ndarray, table: pa.Table) -> np.ndarray | None:
    """Scores of grasps by models that have not seen them; None with too few of an outcome."""
    from experiments.success_prediction.metric_scores import folds_and_truth

    success, usable, fold = folds_and_truth(table)
    if min(np.sum(success & usable), np.sum(~success & usable)) < 20:
        return None
    scores = np.full(len(success), np.nan)
    scores[usable] = baselines.logistic_scores(features[usable], success[usable], fold[usable])
    return scores


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
            label = [html.name(group), compare.NAMES[metric]]
            if key == "auc":
                cells = [f"{value:.3f}", html.number(c.auc, c.auc_interval, 3)]
            else:
                cells = [f"{100 * value:.1f} %", html.percent(own[key])]
            rows.append([*label, names.get(key, "AUC") + star, *cells])
    return Section(
        "Beside the paper",
        (
            html.table(
                f"Published numbers of {GRASPS} real grasps, half of them stable, and the same "
                "numbers of the simulated ones [shares in %, 95 % intervals].",
                ["object", "metric", "number", "published", "simulated"],
                rows,
                text=(0, 1, 2),
            ),
        ),
    )


def metrics_section(results: Sequence[Result], draw: Draw) -> Section:
    """All metrics on the same grasps."""
    figure = draw(
        "metrics",
        forest(results),
        "Area under the ROC curve, and accuracy with a threshold chosen on other trials, of "
        "every metric; full dots: distal pads, hollow: all pads; 95 % intervals. Dashed: chance, "
        "and the accuracy of always predicting the more frequent outcome.",
    )
    files = "The table is metrics.csv; the scores of every single grasp are in scores.csv."
    parts = (figure, results_table(results), html.paragraph(files))
    return Section("All metrics on the same grasps", parts)


def _score_rows(
    rows: Sequence[dict[str, Any]], values: dict[Variant, np.ndarray]
) -> list[dict[str, Any]]:
    found = []
    for k, row in enumerate(rows):
        record = {name: row[name] for name in ("trial", "object", "seed", "success", "failure")}
        found.append(record | {v.key: float(scores[k]) for v, scores in values.items()})
    return found


if __name__ == "__main__":
    main()
