"""Every metric of the field on the same trials: which of them tells grasps that hold from others.

    python -m experiments.leaderboard RUN... [--metrics all] [--metrics my_metric.py:spread]

Each metric is evaluated on the stored grasps before the lift, and where the runs have them at
lift-off and where the grasp settles; learned predictors stand beside. Writes the figure
``leaderboard`` (SVG and PNG) and the numbers of every group and moment (CSV and Parquet).
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, fail
from experiments.leaderboard.learned import learned_entrants
from experiments.leaderboard.moments import BEFORE, SETTLED, moments_of, of_settling, scores_at
from experiments.stored_runs import tell
from sdh_sim.analysis.leaderboard import Leaderboard, rank_all
from sdh_sim.cli.field_comparison import entrants_of, outcomes_of, trials_of
from sdh_sim.cli.leaderboard_table import leaderboard_notes, leaderboard_table
from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.metrics.field import ALL, chosen
from sdh_sim.metrics.field_scores import metrics_of
from sdh_sim.report import figure_style
from sdh_sim.report.data_tables import write_table
from sdh_sim.report.leaderboard_section import leaderboard_figure
from sdh_sim.runs import open_runs

FOLDER = "leaderboard"
BY_VERDICT = (
    "A grasp that does not settle has every metric's worst value: here the verdict of settling "
    "ranks first, and a metric among the grasps that settle."
)


def main(argv: Sequence[str] | None = None) -> None:
    """Evaluate, rank, print, draw."""
    parser = Parser(__doc__)
    parser.prog = "leaderboard"
    parser.add_argument("runs", type=Path, nargs="+", help="run folders")
    parser.add_argument("--metrics", action="append", help="all (default), field, names, or your "
                        "own as file.py:function; again or with commas for more")  # fmt: skip
    parser.add_argument("--out", type=Path, help=f"folder (default: {FOLDER} in the run)")
    parser.add_argument("--workers", type=int, help="processes (default: one per core)")
    parser.add_argument("--before-only", action="store_true", help="leave out later moments")
    args = parser.parse_args(argv)
    if args.out is None and (len(args.runs) > 1 or not args.runs[0].is_dir()):
        fail("several runs, or a file of trials, have no folder of their own: give --out")
    start = time.perf_counter()
    try:
        boards = boards_of(args.runs, args.metrics or [ALL], args.before_only, args.workers)
    except (SettingsError, RunError, RecordError) as error:
        fail(str(error))
    console = Console(width=140)
    for moment, board in boards.items():
        console.print(f"[bold]{moment}[/bold]")
        standings = board.standings[board.main]
        console.print(leaderboard_table(standings, any(s.rank_load is not None for s in standings)))
        console.print(by_object(board))
        if moment == SETTLED:
            console.print(BY_VERDICT, markup=False, soft_wrap=True)
    for line in leaderboard_notes(boards[BEFORE]):
        console.print(line, markup=False, soft_wrap=True)
    folder = args.out or args.runs[0] / FOLDER
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_table(records(boards), folder / "leaderboard")
        with figure_style.style():
            before = boards[BEFORE]
            figure = leaderboard_figure(before.standings[before.main])
            print(f"figure: {figure_style.save(figure, folder / 'leaderboard')[1]}")
    except OSError as error:
        fail(f"cannot write to {folder}: {error.strerror or error}; choose another --out")
    print(f"{time.perf_counter() - start:.0f} s", file=sys.stderr)


def boards_of(
    runs: Sequence[Path], asked: Sequence[str], before_only: bool, workers: int | None
) -> dict[str, Leaderboard]:
    """The leaderboard at every moment, by the moment.

    Raises:
        SettingsError: no such metric, or two of one name.
        RunError, RecordError: runs that cannot be rated.
    """
    known, own = chosen(asked)
    metrics = metrics_of(known, own)
    with open_runs(runs) as opened:
        tell(opened)
        trials = trials_of(opened)
    objects = np.unique(trials.table.column("object").to_pylist(), return_inverse=True)[1]
    boards = {}
    for moment in [BEFORE] if before_only else moments_of(trials):
        scores = scores_at(moment, trials, known, own, workers)
        outcomes, entrants = outcomes_of(trials, scores), entrants_of(metrics, scores)
        if moment == BEFORE:
            settling = of_settling(trials)
            entrants += [settling] if settling else []
            entrants += learned_entrants(trials.rows, outcomes, objects)
        boards[moment] = rank_all(entrants, outcomes, trials.groups)
    return boards


def by_object(board: Leaderboard) -> Table:
    """Area under the ROC curve of every metric for each object."""
    groups = list(board.standings)
    table = Table(title="area under the ROC curve by object")
    for head in ("metric", *groups):
        table.add_column(head, justify="left" if head == "metric" else "right")
    areas = {(g, s.entrant.name): s.auc for g in groups for s in board.standings[g]}
    for s in board.standings[board.main]:
        found = (areas[g, s.entrant.name] for g in groups)
        table.add_row(s.entrant.label, *("-" if a is None else f"{a:.2f}" for a in found))
    return table


def records(boards: dict[str, Leaderboard]) -> list[dict[str, Any]]:
    """All numbers as rows of a table."""
    found = []
    for moment, board in boards.items():
        for group, standings in board.standings.items():
            for place, s in enumerate(standings, start=1):
                low, high = s.auc_interval or (None, None)
                found.append(
                    {
                        "moment": moment,
                        "group": group,
                        "place": place,
                        "metric": s.entrant.name,
                        "label": s.entrant.label,
                        "family": s.entrant.family,
                        "n": s.n,
                        "auc": s.auc,
                        "auc_low": low,
                        "auc_high": high,
                        "best_accuracy": s.best.accuracy.value if s.best else None,
                        "own_accuracy": s.own.value,
                        "spearman_q_sim": s.rank_load,
                        "spearman_motion": s.rank_motion,
                        "cost_us": None if np.isnan(s.entrant.cost_us) else s.entrant.cost_us,
                        "behind": s.behind.value if s.behind else None,
                        "p": s.behind.p_value if s.behind else None,
                        "holm_p": s.holm_p,
                        "missing": s.missing,
                        "infinite": s.infinite,
                        "fault": s.entrant.fault,
                    }
                )
    return found


if __name__ == "__main__":
    main()
