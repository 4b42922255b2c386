"""How well each predictor tells successes from failures, on the same trials and folds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from matplotlib.figure import Figure

from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis import trial_tables
from sdh_sim.analysis.comparison import Comparison
from sdh_sim.analysis.load_agreement import Agreement, agree
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.study import seeded, stratified_folds
from sdh_sim.analysis.thresholds import CrossValidated, cross_validate
from sdh_sim.records import stack
from sdh_sim.report import figure_style
from sdh_sim.report.page import Table
from sdh_sim.report.table_cells import DASH, number, percent


@dataclass(frozen=True)
class Candidate:
    """A predictor.

    Attributes:
        group, assumes: what it is, and under which assumptions.
        pads: ``distal`` or ``all``.
        scores: (n,) of all trials; NaN where it has none.
        boundary: decision boundary it comes with, or None.
        drop_missing: leave trials without a score out instead of counting them as 0.
        is_load: the score is a load in weights, to be compared with q_sim.
    """

    group: str
    assumes: str
    pads: str
    scores: np.ndarray
    boundary: float | None = None
    drop_missing: bool = False
    is_load: bool = False


@dataclass(frozen=True)
class Result:
    """The statistics of a candidate; ``best`` is None with fewer than two of an outcome."""

    candidate: Candidate
    comparison: Comparison
    best: CrossValidated | None
    agreement: Agreement | None

    def record(self) -> dict[str, Any]:
        """The numbers as a row of a table."""
        c, best, a = self.comparison, self.best, self.agreement
        at_boundary = c.accuracy if self.candidate.boundary is not None else Proportion(0, 0)
        found: dict[str, Any] = {
            "metric": self.candidate.group,
            "assumes": self.candidate.assumes,
            "pads": self.candidate.pads,
            "n": c.n,
            "auc": c.auc,
        }
        found |= _ends("auc", c.auc_interval)
        found |= {"boundary": self.candidate.boundary, "accuracy": at_boundary.value}
        found |= _ends("accuracy", at_boundary.interval)
        found["best_threshold"] = best.threshold if best else None
        found["best_accuracy"] = best.accuracy.value if best else None
        found |= _ends("best_accuracy", best.accuracy.interval if best else None)
        found["spearman_q_sim"] = a.spearman if a else None
        found |= _ends("spearman_q_sim", a.spearman_interval if a else None)
        ratio = a.ratio if a else None
        found["median_ratio_q_sim"] = ratio.median if ratio else None
        found["spread_factor"] = ratio.spread if ratio else None
        return found

    def line(self) -> str:
        """One line for the terminal."""
        c, best = self.comparison, self.best
        auc = "  -  " if c.auc is None else f"{c.auc:.3f}"
        fixed = "  - "
        if self.candidate.boundary is not None and c.accuracy.value is not None:
            fixed = f"{100 * c.accuracy.value:4.1f}"
        chosen = "  - "
        if best is not None and best.accuracy.value is not None:
            chosen = f"{100 * best.accuracy.value:4.1f}"
        name = f"{self.candidate.group}, {self.candidate.assumes}"
        return f"{name:<52} {self.candidate.pads:<7} AUC {auc}  at boundary {fixed}  best {chosen}"


def _ends(name: str, bounds: tuple[float, float] | None) -> dict[str, float | None]:
    low, high = bounds or (None, None)
    return {f"{name}_low": low, f"{name}_high": high}


def folds_and_outcomes(table: pa.Table) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Success, whether a trial counts, and its fold, each (n,); the folds are the report's."""
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    usable = ~trial_tables.without_truth(table) & ~trial_tables.surplus_of(table)
    fold = np.full(len(success), -1)
    fold[usable] = stratified_folds(table.filter(pa.array(usable)))
    return success, usable, fold


def assess(table: pa.Table, candidates: Sequence[Candidate]) -> list[Result]:
    """Score every candidate on the trials of a table."""
    success, usable, fold = folds_and_outcomes(table)
    loads = capped = None
    if all(name in table.column_names for name in ("q_sim", "q_sim_capped")):
        loads = stack(table, "q_sim")
        capped = np.array([bool(v) for v in table.column("q_sim_capped").to_pylist()])
    found = []
    for candidate in candidates:
        keep = usable & ~(candidate.drop_missing & np.isnan(candidate.scores))
        scores = np.where(np.isnan(candidate.scores), 0.0, candidate.scores)[keep]
        outcomes = success[keep]
        comparison = compare.compare_scores(
            candidate.scores[keep],
            outcomes,
            metric=candidate.group,
            threshold=0.0 if candidate.boundary is None else candidate.boundary,
        )
        two_sided = outcomes.sum() >= 2 and (~outcomes).sum() >= 2
        agreement = None
        if candidate.is_load and loads is not None and capped is not None:
            tested = keep & ~np.isnan(loads)
            if tested.any():
                agreement = agree(
                    candidate.scores[tested], loads[tested], capped[tested], seeded("agreement")
                )
        best = cross_validate(scores, outcomes, fold[keep]) if two_sided else None
        found.append(Result(candidate, comparison, best, agreement))
    return found


def results_table(results: Sequence[Result]) -> Table:
    """All results as a table of the report."""
    rows, rules, before = [], [], ("", "")
    load = any(result.agreement for result in results)
    for result in results:
        candidate, c, best, a = (
            *(result.candidate, result.comparison),
            *(result.best, result.agreement),
        )
        section = (candidate.pads, candidate.group)
        if section != before:
            rules.append(len(rows))
        fixed = percent(c.accuracy) if candidate.boundary is not None else DASH
        cells = [
            candidate.pads if section != before else "",
            candidate.group if section != before else "",
            candidate.assumes,
            str(c.n),
            number(c.auc, c.auc_interval),
            fixed,
            percent(best.accuracy) if best else DASH,
        ]
        if load:
            cells.append(number(a.spearman) if a else DASH)
            cells.append(number(a.ratio.median) if a and a.ratio else DASH)
        rows.append(cells)
        before = section
    head = ["pads", "metric", "assumptions", "n", "AUC", "at 1", "at best"]
    return Table(
        "Every metric and plain baseline: area under the ROC curve, accuracy [%] at the decision "
        "boundary 1 (of a probability: one half) and at the threshold chosen by cross-validation. "
        "Wrenches at the contact's centre alone (none), and forces without friction (fl), with "
        "friction (hf) and with torsion (sf) at every active taxel; literal: contacts cannot "
        "press with less than their limit, equations (9) and (10) to the letter"
        + ("; rank correlation with q_sim and median of q*/q_sim." if load else "."),
        head + (["rank corr.", "q*/q_sim"] if load else []),
        rows,
        text_columns=(0, 1, 2),
        ruled_rows=rules,
    )


def forest(results: Sequence[Result]) -> Figure:
    """Area and best accuracy of every predictor: a line each, with both choices of pads."""
    names = list(dict.fromkeys((r.candidate.group, r.candidate.assumes) for r in results))
    figure, axes = figure_style.panels(2, 1.0 + 0.23 * len(names), width=9.0, sharey=True)
    for result in results:
        c, best = result.comparison, result.best
        hollow = result.candidate.pads == "all"
        y = names.index((result.candidate.group, result.candidate.assumes))
        colour = _colour(result.candidate.group)
        if c.auc is not None and c.auc_interval is not None:
            _dot(axes[0], c.auc, c.auc_interval, y, colour, hollow)
        if best is not None and best.accuracy.value is not None and best.accuracy.interval:
            _dot(axes[1], best.accuracy.value, best.accuracy.interval, y, colour, hollow)
    success = results[0].comparison.success.value
    base = 0.5 if success is None else success
    for k, (ax, mark) in enumerate(zip(axes, (0.5, max(base, 1.0 - base)), strict=True)):
        ax.axvline(mark, color=figure_style.GREY, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
        ax.grid(axis="x")
        figure_style.letter(ax, k, ("AUC", "accuracy, held out")[k])
        for y in range(1, len(names)):
            if names[y][0] != names[y - 1][0]:
                ax.axhline(y - 0.5, color="#cccccc", linewidth=0.7)
    axes[0].set_yticks(range(len(names)), [f"{group}, {assumes}" for group, assumes in names])
    axes[0].set_ylim(len(names) - 0.4, -0.6)
    for ax in axes:
        ax.tick_params(axis="y", length=0)
        ax.spines["left"].set_visible(False)
    return figure


def _dot(
    ax: Any, value: float, bounds: tuple[float, float], y: int, colour: str, hollow: bool
) -> None:
    place = y + (0.17 if hollow else -0.17)
    ax.plot(bounds, [place, place], color=colour, linewidth=1.1)
    face = "white" if hollow else colour
    ax.plot(value, place, marker="o", markersize=4.2, color=colour, markerfacecolor=face)


def _colour(group: str) -> str:
    names = {text: key for key, text in compare.NAMES.items()}
    return figure_style.COLOURS.get(names.get(group, ""), "#222222")
