"""The report of a comparison: a page with its figures, and every number as CSV and Parquet."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from sdh_sim.analysis.study import Study
from sdh_sim.atomic_files import write_atomic
from sdh_sim.report import figure_style
from sdh_sim.report.case_parts import TRIALS, marks_of, trials_section, worst_section
from sdh_sim.report.data_tables import tables_of, write_table
from sdh_sim.report.dots import POINTS, dots_of
from sdh_sim.report.figures import Reference
from sdh_sim.report.look import Look
from sdh_sim.report.page import Bullets, Paragraph, Picture, Section, render_page
from sdh_sim.report.sections import Draw, sections_of

PAGE = "index.html"
TITLE = "Predicted and simulated grasp success"
METHOD = (
    "A grasp is predicted to hold when its metric exceeds the threshold: 1 for q*, its own for a "
    "user's metric that states one. A trial without q* or ε counts as 0 (no pad felt anything, or "
    "the space is flat); V and users' metrics are compared on the trials that have them. Trials "
    "whose simulation was unstable or broke off, or whose grasp the arm cannot do without a "
    "collision, are left out.",
    "95 % intervals: Wilson's of shares, and of average precision as a share of the successes; "
    "score intervals of areas under the ROC curve (Newcombe's method 5 with the sample's own "
    "shape); order statistics of medians; 2000 bootstrap resamples (fewer of more than 5000 "
    "trials) of curves, thresholds and rank correlations, none where an outcome has fewer than ten "
    "trials. Tests are two-sided: McNemar's exact one for accuracies, DeLong's for areas.",
    "Cross-validation: ten folds, stratified by object and outcome. The threshold used in a fold "
    "maximises the accuracy on the nine others; the accuracy is that of all folds together.",
    "The same trials give the same page: every random stream starts from a fixed seed.",
)
_TABLES = ("summary", "pairs", "calibration", "curves", "load")


def write_report(
    study: Study,
    folder: Path,
    lead: str,
    reference: Reference | None = None,
    extra: Callable[[Draw], Sequence[Section]] | None = None,
    look: Look | None = None,
) -> Path:
    """Write the report of a study.

    Args:
        study: what to report.
        folder: made where it is missing; the report's own older files in it are replaced.
        lead: one line below the title, such as the runs' names.
        reference: published numbers to draw beside the study's own.
        extra: gives further sections for the end of the page; its argument writes their figures.
        look: how to look at single trials; None where nothing is known of that.

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
    look = look or Look()
    figures = _FigureWriter(folder, study, look)
    with figure_style.style():
        sections = sections_of(study, figures.draw, reference)
        if extra is not None:
            sections += extra(figures.draw)
    if study.cases:
        sections += [worst_section(study, look), trials_section(study, look)]
    sections.append(_method(tables))
    path = folder / PAGE
    write_atomic(path, render_page(TITLE, lead, sections).encode())
    return path


class _FigureWriter:
    """Writes figures into a folder and numbers them in the order of the page."""

    def __init__(self, folder: Path, study: Study, look: Look) -> None:
        self.folder, self.count = folder, 0
        self.study, self.look = study, look

    def draw(self, name: str, figure: Figure, caption: str, numbers: str = "") -> Picture:
        self.count += 1
        svg, _ = figure_style.save(figure, self.folder / name)
        marks = marks_of(dots_of(figure), self.study.cases, self.look)
        width, height = figure.get_size_inches() * POINTS
        numbers = numbers or (TRIALS if marks else "")
        return Picture(svg.read_bytes(), self.count, caption, marks, (width, height), numbers)


def _method(tables: Iterable[str]) -> Section:
    files = ", ".join(f"{name}.csv" for name in tables)
    beside = (
        f"Beside this page lie the figures as SVG and PNG, and the numbers: {files}, each also as "
        "Parquet."
    )
    return Section("How these numbers come about", [Bullets(METHOD), Paragraph(beside)])


def _remove_stale(folder: Path, tables: Iterable[str], load: bool) -> None:
    """Remove what an earlier report wrote and this one does not."""
    stale = {f"{name}{end}" for name in _TABLES for end in (".csv", ".parquet")}
    stale -= {f"{name}{end}" for name in tables for end in (".csv", ".parquet")}
    if not load:
        stale |= {f"load_{kind}{end}" for kind in ("scatter", "ratio") for end in (".svg", ".png")}
    if "calibration" not in tables:
        stale |= {"calibration.svg", "calibration.png"}
    for name in stale:
        with contextlib.suppress(FileNotFoundError):
            (folder / name).unlink()
