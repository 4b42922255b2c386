"""Labels of a run against those of a second engine, Drake.

    python -m experiments.two_engines RUN... [--alignments NAME ...] [--ramp] [--picture STEM]

Every trial of RUN with a snapshot is repeated up to it, the state is carried into Drake, and hand
and object are lifted there; the same rule labels what happens. Rows are appended to
``RUN/two_engines.csv`` as they are found, and what is there already is not computed again. Then
it is printed how far both engines agree. Needs Drake: ``pip install -e ".[crosscheck]"``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from experiments.command_line import Parser, at_least, fail
from experiments.stored_runs import read_runs
from experiments.two_engines.agreement import both_labels
from experiments.two_engines.alignment import ALIGNMENTS, FULL
from experiments.two_engines.drake import need_drake
from experiments.two_engines.report import report
from experiments.two_engines.table import LABELS
from sdh_sim.cli.worker_pool import run_each
from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.records import NO_TRUTH


def main(argv: Sequence[str] | None = None) -> None:
    """Compute what is missing, and print the comparison."""
    parser = _parser()
    args = parser.parse_args(argv)
    at_least(parser, args, trials=0, workers=0)
    need_drake()
    try:
        for run in args.run:
            _complete(run, args)
        labels = both_labels(args.run)
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    report(labels, Console(width=140), args.scores)
    if args.picture is not None and FULL in labels.found:
        from experiments.two_engines.picture import draw

        print(f"figure: {draw(labels, args.picture)}")


def _complete(run: Path, args: argparse.Namespace) -> None:
    """Append the rows that the table beside a run lacks."""
    from experiments.two_engines.trials import Task, compare

    stored = read_runs([run])
    there = {(row["trial"], row["alignment"]): row for row in LABELS.read(run)}
    tasks = []
    for row in [r for r in stored.rows if r["failure"] not in (*NO_TRUTH, "no_contact")]:
        wanted = [
            name for name in args.alignments
            if (found := there.get((row["trial"], name))) is None
            or (args.ramp and name == FULL and found["q_sim"] != found["q_sim"])
        ]  # fmt: skip
        if wanted:
            chosen = {name: ALIGNMENTS[name] for name in wanted}
            ramp = (FULL,) if args.ramp else ()
            tasks.append(Task(stored.plan.job(row["trial"]), row, chosen, ramp))
    tasks.sort(key=lambda task: task.job.index)  # what is stopped early has all objects
    tasks = tasks[: args.trials] if args.trials else tasks
    for rows in run_each(compare, tasks, str(run), args.workers):
        LABELS.append(run, rows)


def _parser() -> argparse.ArgumentParser:
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, nargs="+", help="run folders of sdh-sim lift")
    parser.add_argument(
        "--alignments", nargs="+", choices=list(ALIGNMENTS), default=[FULL], metavar="NAME",
        help=f"differences aligned up to this one: {', '.join(ALIGNMENTS)} (default: {FULL})",
    )  # fmt: skip
    parser.add_argument("--ramp", action="store_true", help="the load ramp (q_sim) in Drake, too")
    parser.add_argument(
        "--scores", choices=list(ALIGNMENTS), default=FULL, metavar="NAME",
        help=f"alignment of which the labels are scored (default: {FULL})",
    )  # fmt: skip
    parser.add_argument("--trials", type=int, default=0, help="new trials at most (default: all)")
    parser.add_argument("--picture", type=Path, help="draw a figure of this name")
    parser.add_argument("--workers", type=int, default=0, help="processes (default: one per core)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
