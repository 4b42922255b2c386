"""The ranking of metrics as a table on the terminal, with what its reader has to know."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.table import Table

from sdh_sim.analysis.leaderboard import Leaderboard, Standing
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cli.console import plain_table

DASH = "-"


def leaderboard_table(standings: Sequence[Standing], load: bool) -> Table:
    """One line per metric, the best first.

    Args:
        standings: of one group of trials.
        load: whether there were load tests.
    """
    heads = ["metric", "family", "AUC", "best %", "own %"]
    heads += ["ρ q_sim"] if load else []
    table = plain_table(*heads, "ρ motion", "µs", "p", text=(0, 1))
    for s in standings:
        cells = [s.entrant.label, s.entrant.family, _area(s)]
        cells += [_share(s.best.accuracy) if s.best else DASH, _share(s.own)]
        cells += [_number(s.rank_load)] if load else []
        cells += [_number(s.rank_motion), _cost(s.entrant.cost_us)]
        table.add_row(*cells, DASH if s.holm_p is None else f"{s.holm_p:.2g}")
    return table


def leaderboard_notes(board: Leaderboard) -> list[str]:
    """What the reader of the table has to know."""
    standings = board.standings[board.main]
    lines = [
        f"{standings[0].n} trials, every metric on all of them, from the snapshot before the lift. "
        "AUC with its 95 % score interval; best: accuracy at the threshold chosen on other trials; "
        "own: at the metric's own; ρ: rank correlation, above 0 is good; µs of processor time a "
        "grasp, the median; p: DeLong's test against the best of the table, with Holm's correction."
    ]
    lines += [f"{s.entrant.label}: {s.remarks}." for s in standings if s.remarks]
    if any(s.missing for s in standings):
        lines.append("A grasp for which a metric has no value counts as its worst.")
    return lines


def _area(s: Standing) -> str:
    if s.auc is None or s.auc_interval is None:
        return DASH
    low, high = s.auc_interval
    return f"{s.auc:.3f} ({low:.2f}–{high:.2f})"


def _share(share: Proportion) -> str:
    return DASH if share.value is None else f"{100 * share.value:.0f}"


def _number(value: float | None) -> str:
    return DASH if value is None else f"{value:.2f}".replace("-", "−")


def _cost(microseconds: float) -> str:
    return DASH if math.isnan(microseconds) else f"{microseconds:,.0f}"
