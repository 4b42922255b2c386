"""What the table hides: every bound before the lift, at lift-off and where it settles.

    python -m experiments.release RUN [--out FOLDER]

RUN is one of ``sdh-sim lift … --lift-off --settle metrics``. Prints a table, and draws areas under
the ROC curve with their intervals. Also: how far objects move in the hand when the table lets go,
and what becomes of those that never leave it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, fail
from experiments.score_table import score_cells, verdict_scores
from experiments.stored_runs import tell
from sdh_sim.analysis.comparison import Comparison, compare_scores, name_of
from sdh_sim.analysis.moments import (
    MOMENT_COLUMNS,
    MOMENT_METRICS,
    MOMENTS,
    TwoMoments,
    compare_moments,
)
from sdh_sim.analysis.trial_tables import without_surplus, without_truth
from sdh_sim.errors import RecordError, RunError
from sdh_sim.records import LIFT_OFF, SETTLED, columns_of, read_table, stack
from sdh_sim.report.figure_style import colour_of, save, style
from sdh_sim.runs import open_runs

FOLDER = "release"
WHOLE_HAND = LIFT_OFF + "q_whole_hand"
NEEDED = (LIFT_OFF + "displacement_mm", LIFT_OFF + "on_table", SETTLED + "displacement_mm",
          SETTLED + "rotation_deg", "settled", "displacement_mm", WHOLE_HAND)  # fmt: skip
VERDICT = "settling"


def main(argv: Sequence[str] | None = None) -> None:
    """Print the tables, draw the figure."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder")
    parser.add_argument("--out", type=Path, help=f"folder (default: {FOLDER} in the run)")
    args = parser.parse_args(argv)
    try:
        with open_runs([args.run]) as opened:
            tell(opened)
            path = opened[0].table
            if len(columns_of([path], NEEDED)) < len(NEEDED):
                fail(f"{args.run} lacks columns; lift with --lift-off --settle metrics")
            columns = ("success", "failure", "surplus", *NEEDED, *MOMENT_METRICS, *MOMENT_COLUMNS)
            table = without_surplus(read_table(path, list(dict.fromkeys(columns))))
    except (RecordError, RunError) as error:
        fail(str(error))
    verdict = of_settling(table)
    moments = compare_moments(table, ~without_truth(table))
    console = Console(width=140)
    console.print(table_of(moments, verdict))
    for line in sentences(table):
        console.print(line, markup=False, soft_wrap=True)
    try:
        folder = args.out or args.run / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        print(f"figure: {draw(moments, verdict, folder / 'release')}")
    except OSError as error:
        fail(f"cannot write to {args.out}: {error.strerror or error}; choose another --out")


def of_settling(table: pa.Table) -> Comparison:
    """The verdict of settling; grasps are ranked by it, then by how far they are to move."""
    moved = np.fmax(
        stack(table, SETTLED + "displacement_mm"), stack(table, SETTLED + "rotation_deg")
    )
    held = np.array([bool(v) for v in table.column("settled").to_pylist()])
    usable = ~without_truth(table) & np.array(table.column("settled").is_valid())
    scores = verdict_scores(held, np.nan_to_num(moved, nan=np.inf))
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    return compare_scores(scores[usable], success[usable], metric=VERDICT)


def table_of(moments: Sequence[TwoMoments], verdict: Comparison) -> Table:
    """A line for every bound and moment."""

    def cells(c: Comparison) -> tuple[str, ...]:
        return (str(c.n), *score_cells(c))

    table = Table(title="the same trials at three moments")
    heads = ("metric", "when", "n", "AUC", "accuracy at 1 %", "TPR %", "FPR %", "p, accuracy")
    for head in heads:
        table.add_column(head, justify="left" if head in heads[:2] else "right")
    for metric in dict.fromkeys(m.before.metric for m in moments):
        own = [m for m in moments if m.before.metric == metric]
        table.add_row(
            name_of(metric),
            "before the lift",
            str(own[0].before.n),
            *score_cells(own[0].before),
            "",
        )
        for m in own:
            table.add_row(
                "",
                MOMENTS[m.moment],
                str(m.after.n),
                *score_cells(m.after),
                f"{m.paired.p_value:.1g}",
            )
        table.add_section()
    table.add_row("settling", "predicted from before", *cells(verdict), "")
    return table


def sentences(table: pa.Table) -> list[str]:
    """How far objects move when the table lets go, and what becomes of those that stay on it."""
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    moved, final = stack(table, LIFT_OFF + "displacement_mm"), stack(table, "displacement_mm")
    on_table = table.column(LIFT_OFF + "on_table")
    stayed = np.array(on_table.fill_null(False))  # what was not looked at neither stayed nor left
    off = np.array(on_table.is_valid()) & ~stayed
    if not (success & off).any():
        return ["No object left the table and was held to the end."]
    low, middle, high = np.quantile(moved[success & off], (0.1, 0.5, 0.9))
    error = np.abs(stack(table, SETTLED + "displacement_mm") - final)[success]
    return [
        f"Objects that were held had moved {middle:.1f} mm in the hand at lift-off in the median "
        f"(10 % below {low:.1f}, 10 % above {high:.1f}), and {np.median(final[success]):.1f} mm at "
        "the end.",
        f"{int(off.sum())} objects left the table within the rise; {int((off & success).sum())} of "
        f"them were held to the end. {int(stayed.sum())} still touched it; "
        f"{int((stayed & success).sum())} of them were held.",
        *_without_the_table(table, success, stayed, off),
        f"Settling predicts the motion of held objects within {np.nanmedian(error):.2f} mm in the "
        f"median, {np.nanquantile(error, 0.9):.1f} mm for nine in ten.",
    ]


def _without_the_table(
    table: pa.Table, success: np.ndarray, stayed: np.ndarray, off: np.ndarray
) -> list[str]:
    """The whole hand at lift-off, where objects that never left the table count as 0."""
    q = np.nan_to_num(stack(table, WHOLE_HAND), neginf=-1.0)
    usable = (stayed | off) & ~without_truth(table)
    every = compare_scores(np.where(stayed, 0.0, q)[usable], success[usable])
    alone = compare_scores(q[usable & off], success[usable & off])
    return [
        f"{name_of(WHOLE_HAND)}: counting as 0 what never left the table, AUC {every.area(3)} and "
        f"{every.accuracy.percent} % right; among those that left it, {alone.area(3)} and "
        f"{alone.accuracy.percent} %."
    ]


def draw(moments: Sequence[TwoMoments], verdict: Comparison, stem: Path) -> Path:
    """Areas under the ROC curve of every bound at every moment."""
    import matplotlib.pyplot as plt

    metrics = list(dict.fromkeys(m.before.metric for m in moments))
    marks = {"before": "o", **dict(zip(MOMENTS, "sD", strict=True))}
    with style():
        figure, axes = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
        for place, metric in enumerate(metrics):
            own = [m for m in moments if m.before.metric == metric]
            shown = [("before", own[0].before), *((m.moment, m.after) for m in own)]
            for step, (moment, c) in enumerate(shown):
                _interval(axes, place + 0.22 * (step - 1), c, colour_of(metric), marks[moment])
        _interval(axes, len(metrics), verdict, "0.2", "D")
        labels = [name_of(m).removeprefix("q* ") for m in metrics]
        axes.set_yticks(range(len(metrics) + 1), [*labels, "settling itself"])
        axes.invert_yaxis()
        axes.set_xlabel("area under the ROC curve, 95 % interval")
        names = {"before": "before the lift", **MOMENTS}
        for moment, mark in marks.items():
            axes.plot([], [], mark, color="0.4", ms=5, label=names[moment])
        axes.legend(loc="lower left", frameon=False)
        _, png = save(figure, stem)
        plt.close(figure)
    return png


def _interval(axes, y: float, c: Comparison, colour: str, mark: str) -> None:
    if c.auc is None or c.auc_interval is None:
        return
    axes.plot(c.auc_interval, [y, y], color=colour, lw=1.6)
    axes.plot([c.auc], [y], mark, color=colour, ms=5)


if __name__ == "__main__":
    main()
