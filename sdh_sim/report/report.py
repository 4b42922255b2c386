"""The report of a comparison: a page with its figures, and every number as CSV and Parquet."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from sdh_sim.analysis.study import Study
from sdh_sim.atomic_files import write_atomic
from sdh_sim.report import figure_style, figures, html
from sdh_sim.report import load_figures as figures_load
from sdh_sim.report.data_tables import tables_of, write_table
from sdh_sim.report.figures import Reference
from sdh_sim.report.html import Section
from sdh_sim.report.sections import (
    calibration_table,
    key_lines,
    load_lines,
    load_table,
    metric_table,
    pair_lines,
    pair_table,
    rate_table,
)

PAGE = "index.html"
_TABLES = ("summary", "pairs", "calibration", "curves", "load")

METHOD = (
    "A grasp is predicted to hold when its q* exceeds the threshold; a trial without q* counts as "
    "q* = 0. Trials whose simulation was unstable or broke off are left out.",
    "Shares carry 95 % Wilson intervals. Areas, curves, medians and correlations carry 95 % "
    "percentile intervals from 2000 bootstrap resamples, successes and failures resampled each "
    "among themselves (load test: trials). McNemar's test is the exact two-sided one.",
    "Cross-validation: ten folds, stratified by object and outcome. The threshold used in a fold "
    "maximises the accuracy on the nine others; the accuracy is that of all folds together.",
    "The same trials give the same page: every random stream starts from a fixed seed.",
)


Draw = Callable[[str, Figure, str], str]


class _Writer:
    """Draws figures into the folder and numbers them in the order of the page."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0

    def draw(self, name: str, figure: Figure, caption: str) -> str:
        self.count += 1
        svg, _ = figure_style.save(figure, self.folder / name)
        return html.picture(svg, self.count, caption)


def write_report(
    study: Study,
    folder: Path,
    lead: str,
    reference: Reference | None = None,
    extra: Callable[[Draw], Sequence[Section]] | None = None,
) -> Path:
    """Write the report of a study.

    Args:
        study: what to report.
        folder: made where it is missing; the report's own older files in it are replaced.
        lead: one line below the title, such as the runs' names.
        reference: published numbers to draw beside the own ones.
        extra: gives further sections for the end of the page; their figures go through its
            argument (name of the file, figure, caption), which returns the HTML.

    Returns:
        the page.

    Raises:
        OSError: the disk refused.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tables = tables_of(study)
    _remove_stale(folder, tables, bool(study.load))
    for name, rows in tables.items():
        write_table(rows, folder / name)
    writer = _Writer(folder)
    with figure_style.style():
        sections = [*_sections(study, writer, reference), *(extra(writer.draw) if extra else ())]
    files = ", ".join(f"{name}.csv" for name in tables)
    sections.append(
        Section(
            "How these numbers come about",
            (
                html.bullets(METHOD),
                html.paragraph(
                    f"Beside this page lie the figures as SVG and PNG, and the numbers: {files}, "
                    "each also as Parquet."
                ),
            ),
        )
    )
    path = folder / PAGE
    title = "Predicted and simulated grasp success"
    write_atomic(path, html.page(title, lead, sections).encode())
    return path


def _remove_stale(folder: Path, tables: dict, load: bool) -> None:
    old = [f"{name}{end}" for name in _TABLES if name not in tables for end in (".csv", ".parquet")]
    if not load:
        old += [f"load_{kind}{end}" for kind in ("scatter", "ratio") for end in (".svg", ".png")]
    for name in old:
        with contextlib.suppress(FileNotFoundError):
            (folder / name).unlink()


def _sections(study: Study, writer: _Writer, reference: Reference | None) -> list[Section]:
    beside = " Diamonds: published numbers of the real grasps." if reference else ""
    found = [
        Section("In short", (html.bullets(key_lines(study)),)),
        Section(
            "Distribution of the metric",
            (
                writer.draw(
                    "boxes",
                    figures.boxes(study),
                    "Task scaling of every grasp before the lift, for grasps that held (full) and "
                    "that did not (hollow). Boxes: quartiles and median; whiskers: the last trial "
                    "within 1.5 interquartile ranges. Dashed: the decision boundary 1. Grasps "
                    "that cannot exert the task at all are drawn at 0, values beyond the axis at "
                    "its end.",
                ),
            ),
        ),
        Section(
            "Prediction with the threshold 1",
            (
                writer.draw(
                    "rates",
                    figures.rates(study, reference),
                    "Share of the trials predicted rightly, of the successes predicted, and of "
                    "the failures predicted, with 95 % Wilson intervals." + beside,
                ),
                rate_table(study),
            ),
        ),
        Section(
            "L∞ against L1",
            (html.bullets(pair_lines(study)), pair_table(study)),
        ),
        Section(
            "All thresholds",
            (
                writer.draw(
                    "roc",
                    figures.roc(study, reference),
                    "Receiver operating characteristic over all trials, 95 % bands of L∞ and L1.",
                ),
                writer.draw(
                    "precision_recall",
                    figures.precision_recall(study),
                    "Precision over recall. Dashed: share of all trials that succeeded.",
                ),
                metric_table(study),
            ),
        ),
        Section(
            "As conservative as desired",
            (
                writer.draw(
                    "calibration",
                    figures_load.calibration(study),
                    "(a) The smallest threshold that lets through no more than the desired share "
                    "of the failing grasps. (b) The share of the successful grasps that is still "
                    "predicted at it. (c) The share of failing grasps that passes when the "
                    "threshold was chosen on other trials.",
                ),
                calibration_table(study),
            ),
        ),
    ]
    if study.load:
        found.append(
            Section(
                "What the grasp really holds",
                (
                    html.bullets(load_lines(study)),
                    writer.draw(
                        "load_scatter",
                        figures_load.load_scatter(study),
                        "The bound's promise q* against the load q_sim at which the object gave "
                        "way in simulation, one dot a trial; on the dashed line the bound is "
                        "exact, above it too optimistic; ρ is the rank correlation. Hollow: "
                        "something that no pad feels bears load as well. The axes are linear up "
                        "to 1, then logarithmic; what lies beyond is drawn at the edge.",
                    ),
                    writer.draw(
                        "load_ratio",
                        figures_load.load_ratio(study),
                        "By what factor each bound over- or underestimates the load that the "
                        "grasp holds.",
                    ),
                    load_table(study),
                ),
            )
        )
    return found
