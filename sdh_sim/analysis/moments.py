"""The same metrics at two moments of the same trials: before the lift, and at lift-off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from sdh_sim.analysis.comparison import ALL_METRICS, THRESHOLD, Comparison, compare_scores
from sdh_sim.analysis.paired_metrics import Paired, compare_pair
from sdh_sim.analysis.resampling import RESAMPLES
from sdh_sim.records import LIFT_OFF, stack

MOMENT_METRICS = tuple(m for m in ALL_METRICS if m.startswith("q_"))
MOMENT_COLUMNS = (LIFT_OFF + "on_table", *(LIFT_OFF + metric for metric in MOMENT_METRICS))


@dataclass(frozen=True)
class TwoMoments:
    """One metric before the lift and at lift-off, against the same outcomes.

    Attributes:
        before, after: the metric at the first and at the second moment.
        paired: the second moment (first of the pair) against the first.
    """

    before: Comparison
    after: Comparison
    paired: Paired


def compare_moments(
    table: pa.Table, usable: np.ndarray, rng: np.random.Generator, resamples: int = RESAMPLES
) -> tuple[TwoMoments, ...]:
    """Every q* of a table that has it at both moments.

    Args:
        table: of trials.
        usable: trials with an outcome (n,) bool; of those, the ones that have a second snapshot
            are compared, which a hand that never touched the object has not.
        rng, resamples: of the bootstrap.
    """
    found = []
    success = np.array(table.column("success").to_pylist(), dtype=bool)
    names = set(table.column_names)
    seen = usable.copy()
    if LIFT_OFF + "on_table" in names:
        seen &= np.array(table.column(LIFT_OFF + "on_table").is_valid())
    for metric in MOMENT_METRICS:
        if not {metric, LIFT_OFF + metric} <= names:
            continue
        first, second = (
            np.nan_to_num(stack(table, name)[seen], nan=0.0, posinf=np.inf, neginf=-np.inf)
            for name in (metric, LIFT_OFF + metric)
        )
        found.append(
            TwoMoments(
                compare_scores(first, success[seen], metric=metric),
                compare_scores(second, success[seen], metric=LIFT_OFF + metric),
                compare_pair(second, first, success[seen], THRESHOLD, rng, resamples),
            )
        )
    return tuple(found)
