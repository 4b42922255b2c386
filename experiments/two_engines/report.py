"""The comparison of two engines as tables on the terminal."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.score_table import score_cells
from experiments.two_engines.agreement import (
    Agreement,
    Labels,
    agree,
    kind_of,
    load_ratios,
    scored,
    weightless,
)
from experiments.two_engines.alignment import FULL
from experiments.two_engines.table import STRAIGHT

SHARES = (
    "",
    "n",
    "same label %",
    "lost, gained",
    "held in both",
    "median off mm",
    "90 % off mm",
    "bias mm",
)


def report(labels: Labels, console: Console, alignment: str = FULL) -> None:
    """Print shares of agreement, the disagreements one by one, and scores on both labels.

    Args:
        labels: of both engines.
        console: to print on.
        alignment: of the labels that are scored.
    """
    shares = Table(title="Labels of the run against")
    for head in SHARES:
        shares.add_column(head, justify="right" if head else "left")
    for name, found in labels.found.items():
        shares.add_row(*_cells(_title(name), agree(labels.rows, found)))
    if STRAIGHT in labels.found:
        for name, found in labels.found.items():
            if name != STRAIGHT:
                title = f"{_title(name)}, against the straight lift"
                shares.add_row(*_cells(title, agree(labels.found[STRAIGHT], found)))
    console.print(shares)
    if FULL not in labels.found:
        return
    ratios = load_ratios(labels)
    if len(ratios):
        low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9))
        off = np.median(np.abs(ratios - 1.0))
        console.print(
            f"q_sim of {len(ratios)} grasps, Drake over MuJoCo: median {middle:.3f} "
            f"({low:.3f} to {high:.3f} for eight in ten), off by {100 * off:.1f} % in the median"
        )
        both, first, second = weightless(labels)
        console.print(
            f"gave way without any weight: {both} in both, {first} in MuJoCo alone, {second} in "
            "Drake alone"
        )
    console.print(_disagreements(labels))
    if alignment not in labels.found:
        return
    scores = Table(title=f"Predictors on the labels of (Drake aligned up to {alignment})")
    heads = ("AUC", "accuracy %")
    for head in ("", *(f"{kind}: {h}" for kind in ("MuJoCo", "Drake", "both") for h in heads)):
        scores.add_column(head, justify="right" if head else "left")
    for name, kinds in scored(labels, alignment).items():
        cells = [cell for c in kinds.values() for cell in score_cells(c)[:2]]
        scores.add_row(name, *cells)
    console.print(scores)


def _title(name: str) -> str:
    if name == STRAIGHT:
        return "MuJoCo, straight lift"
    return f"Drake, {'nothing aligned' if name == 'none' else f'aligned up to {name}'}"


def _cells(title: str, found: Agreement) -> tuple[str, ...]:
    return (
        title, str(found.labels.n), found.labels.in_percent(1), f"{found.lost}, {found.gained}",
        str(found.held), f"{found.off[0]:.2f}", f"{found.off[1]:.2f}", f"{found.bias:+.2f}",
    )  # fmt: skip


def _disagreements(labels: Labels) -> Table:
    table = Table(title="Grasps with different labels (mm, degrees; load in weights)")
    for head in ("object", "trial", "kind", "MuJoCo", "straight", "Drake"):
        table.add_column(head)
    straights = labels.found.get(STRAIGHT) or [None] * len(labels.rows)
    for row, straight, other in zip(labels.rows, straights, labels.found[FULL], strict=True):
        if other is not None and row["success"] != other["success"]:
            kind = kind_of(row, straight, other)
            cells = map(_motion, (row, straight, other))
            table.add_row(row["object"], str(row["trial"]), kind, *cells)
    return table


def _motion(row: dict[str, Any] | None) -> str:
    if row is None:
        return "-"
    load = row.get("q_sim")
    end = "" if load is None or math.isnan(load) else f", load {load:.2f}"
    return f"{row['displacement_mm']:.1f}, {row['rotation_deg']:.1f}, {row['failure']}{end}"
