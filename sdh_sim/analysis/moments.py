"""The same metrics at several moments of the same trials: before the lift, at lift-off, settled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from sdh_sim.analysis.comparison import ALL_METRICS, THRESHOLD, Comparison, compare_scores
from sdh_sim.analysis.paired_metrics import Paired, compare_pair
from sdh_sim.records import LIFT_OFF, SETTLED, stack

MOMENTS = {LIFT_OFF: "at lift-off", SETTLED: "where it settles"}
"""Moments after the first, by the prefix of their columns: as measured, and as predicted."""
LOOKED_AT = {LIFT_OFF: LIFT_OFF + "on_table", SETTLED: "settled"}
"""A column that every trial has in which a moment was looked at."""
MOMENT_METRICS = tuple(m for m in ALL_METRICS if m.startswith("q_") and m != "q_settled")
MOMENT_COLUMNS = (
    *LOOKED_AT.values(),
    *(prefix + metric for prefix in MOMENTS for metric in MOMENT_METRICS),
)


@dataclass(frozen=True)
class TwoMoments:
    """One metric before the lift and at a later moment, against the same outcomes.

    Attributes:
        moment: prefix of the later moment's columns, a key of ``MOMENTS``.
        before, after: the metric at the first and at the later moment.
        paired: the later moment (first of the pair) against the first.
    """

    moment: str
    before: Comparison
    after: Comparison
    paired: Paired


def compare_moments(table: pa.Table, usable: np.ndarray) -> tuple[TwoMoments, ...]:
    """Every q* at every moment that a table has.

    Args:
        table: of trials.
        usable: trials with an outcome (n,) bool; of those, the ones that were looked at in the
            later moment are compared, which a hand that never touched the object was not.
    """
    found = []
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    names = set(table.column_names)
    for prefix in MOMENTS:
        seen = usable.copy()
        if LOOKED_AT[prefix] in names:
            seen &= np.array(table.column(LOOKED_AT[prefix]).is_valid())
        for metric in MOMENT_METRICS:
            if not {metric, prefix + metric} <= names:
                continue
            first, second = (
                np.nan_to_num(stack(table, name)[seen], nan=0.0, posinf=np.inf, neginf=-np.inf)
                for name in (metric, prefix + metric)
            )
            found.append(
                TwoMoments(
                    prefix,
                    compare_scores(first, success[seen], metric=metric),
                    compare_scores(second, success[seen], metric=prefix + metric),
                    compare_pair(second, first, success[seen], THRESHOLD),
                )
            )
    return tuple(found)
