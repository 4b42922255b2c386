"""The metrics side by side: a figure of their areas, families by colour, and a table."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sdh_sim.analysis.leaderboard import Leaderboard, Standing
from sdh_sim.report import figure_style as fs
from sdh_sim.report.page import Paragraph, Section, Table
from sdh_sim.report.sections import Draw
from sdh_sim.report.table_cells import DASH, TableCell, number, p_value, percent

FAMILY_COLOURS = {
    "task": "#0072B2",
    "settling": "#CC3311",
    "wrench space": "#56B4E9",
    "grasp map": "#009E73",
    "contact geometry": "#E69F00",
    "posture": "#AA4499",
    "compliance": "#332288",
    "synthesis": "#D55E00",
    "probability": "#44AA99",
    "learned": "#555555",
    "own": "#000000",
}


def leaderboard_figure(standings: Sequence[Standing]) -> Figure:
    """Area under the ROC curve of every metric, the best on top, with 95 % intervals."""
    shown = [s for s in standings if s.auc is not None and s.auc_interval is not None]
    figure, (ax,) = fs.panels(1, 1.1 + 0.19 * max(len(shown), 4), width=6.4)
    for y, s in enumerate(shown):
        assert s.auc is not None
        assert s.auc_interval is not None
        colour = FAMILY_COLOURS.get(s.entrant.family, fs.GREY)
        ax.plot(s.auc_interval, [y, y], color=colour, linewidth=1.3)
        ax.plot(s.auc, y, marker="o", markersize=4.6, color=colour)
    ax.axvline(0.5, color=fs.GREY, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
    ax.set_yticks(range(len(shown)), [s.entrant.label for s in shown], fontsize=7.5)
    ax.set_ylim(len(shown) - 0.4, -0.6)
    low = min([0.45, *(s.auc_interval[0] for s in shown if s.auc_interval)])
    ax.set_xlim(low - 0.02, 1.01)
    ax.grid(axis="x")
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
    ax.set_xlabel("area under the ROC curve (chance: 0.5)")
    families = list(dict.fromkeys(s.entrant.family for s in shown))
    handles = [
        Line2D([], [], color=FAMILY_COLOURS.get(f, fs.GREY), marker="o", markersize=4.6, label=f)
        for f in families
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7.5)
    return figure


def leaderboard_table(board: Leaderboard) -> Table:
    """Every metric over all trials, the best first, and its area for each object."""
    groups = [group for group in board.standings if group != board.main]
    areas = {(group, s.entrant.name): s.auc for group in groups for s in board.standings[group]}
    rows: list[list[str | TableCell]] = []
    for s in board.standings[board.main]:
        rows.append([
            s.entrant.label,
            s.entrant.family,
            number(s.auc, s.auc_interval, 3),
            *(number(areas.get((group, s.entrant.name))) for group in groups),
            percent(s.best.accuracy) if s.best else DASH,
            percent(s.own) if s.own.n else DASH,
            number(s.rank_load),
            number(s.rank_motion),
            DASH if math.isnan(s.entrant.cost_us) else f"{s.entrant.cost_us:.0f}",
            DASH if s.holm_p is None else p_value(s.holm_p),
            s.remarks,
        ])  # fmt: skip
    n = board.standings[board.main][0].n
    return Table(
        f"Every metric on the same {n} trials: area under the ROC curve over all and by object; "
        "accuracy [%] at the threshold that is most accurate on other trials, and at the metric's "
        "own; rank correlation with q_sim and with the motion in the hand (above 0 is good); "
        "processor time a grasp; p of DeLong's test against the first, with Holm's correction.",
        [
            *("metric", "family", "AUC", *(g.replace("_", " ") for g in groups), "at best"),
            *("at own", "ρ q_sim", "ρ motion", "µs", "p", "remarks"),
        ],
        rows,
        text_columns=(0, 1, 9 + len(groups)),
    )


def leaderboard_section(board: Leaderboard, draw: Draw) -> Section:
    """The section of the page."""
    picture = draw(
        "leaderboard",
        leaderboard_figure(board.standings[board.main]),
        "Area under the ROC curve of every metric asked for, with 95 % score intervals; colours "
        "are families. Intervals that overlap do not say that two metrics are alike: p in the "
        "table compares them on the same trials.",
    )
    note = Paragraph(
        "Each metric is turned so that high is good, and compared on every trial: a grasp for "
        "which it has no value counts as its worst."
    )
    return Section("Metrics side by side", (picture, leaderboard_table(board), note))
