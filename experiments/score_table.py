"""Predictors of success side by side: one line each."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from rich.table import Table

from sdh_sim.analysis.comparison import Comparison

HEADS = ("AUC", "accuracy %", "TPR %", "FPR %")


def verdict_scores(held: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Scores (n,) of a predictor that gives a verdict and a motion, above 1 where it says held.

    Args:
        held: what it says (n,) bool.
        moved: by how much it says that the object moves (n,), infinite where it has left the hand;
            of two with the same verdict the one that moves less ranks higher.
    """
    return np.where(held, 2.0, 0.5) + 0.4 / (1.0 + moved)


def score_cells(c: Comparison) -> tuple[str, ...]:
    """The cells of ``HEADS``."""
    rates = (c.accuracy, c.true_positive_rate, c.false_positive_rate)
    return (c.area(3), *(rate.percent for rate in rates))


def score_table(found: Mapping[str, Comparison]) -> Table:
    """One line per predictor, which all saw the same trials."""
    table = Table(title=f"{next(iter(found.values())).n} grasps")
    for head in ("predictor", *HEADS):
        table.add_column(head, justify="left" if head == "predictor" else "right")
    for name, c in found.items():
        table.add_row(name, *score_cells(c))
    return table
