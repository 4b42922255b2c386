"""Single trials of a comparison: which they are, and those that a metric predicts worst."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import NamedTuple

import pyarrow as pa

from sdh_sim.records import NO_TRUTH

SOURCE = "source"  # column: which of the files read a trial is from
IDENTITY = ("trial", "seed")  # columns that tell a trial from the others of its file
ASIDE = (*IDENTITY, "q_reason")  # what is read beside the columns that are compared


@dataclass(frozen=True)
class Case:
    """One trial as it is compared.

    Attributes:
        number: its place among the trials compared, surplus ones aside.
        source: which of the files read it is from.
        trial, object, seed, success, failure, q_reason: as in the table.
        scores: metric by column, None where the trial has none.
        q_sim: load held [weights]; None without a load test.
        capped: it held the largest load tried.
    """

    number: int
    source: int
    trial: int
    object: str
    seed: int
    success: bool
    failure: str
    q_reason: str
    scores: Mapping[str, float | None]
    q_sim: float | None
    capped: bool

    @property
    def usable(self) -> bool:
        """Whether it has an outcome to compare with."""
        return self.failure not in NO_TRUTH

    def score(self, metric: str) -> float:
        """The metric, 0 where the trial has none: that is how a comparison counts it."""
        value = self.scores[metric]
        return 0.0 if value is None else value


class Mistake(NamedTuple):
    """A trial that a metric mispredicts.

    Attributes:
        case: the trial.
        metric: column of the metric.
        rank: 1 for the worst of its kind, which are the failures promised and the successes denied.
    """

    case: Case
    metric: str
    rank: int


def cases_of(table: pa.Table, metrics: Sequence[str]) -> tuple[Case, ...]:
    """Every trial of a table, in its order; none where it does not say which they are."""
    if not {SOURCE, *IDENTITY} <= set(table.column_names):
        return ()
    optional = ("q_reason", "q_sim", "q_sim_capped")
    present = [name for name in optional if name in table.column_names]
    rows = table.select(
        [SOURCE, *IDENTITY, "object", "success", "failure", *dict.fromkeys((*metrics, *present))]
    ).to_pylist()
    return tuple(
        Case(
            number=number,
            source=row[SOURCE],
            trial=row["trial"],
            object=row["object"],
            seed=row["seed"],
            success=bool(row["success"]),
            failure=row["failure"],
            q_reason=row.get("q_reason") or "",
            scores={metric: _number(row[metric]) for metric in metrics},
            q_sim=_number(row.get("q_sim")),
            capped=bool(row.get("q_sim_capped")),
        )
        for number, row in enumerate(rows)
    )


def _number(value: float | None) -> float | None:
    return None if value is None or math.isnan(value) else float(value)


def mispredicted(
    cases: Sequence[Case], metric: str, threshold: float
) -> tuple[list[Mistake], list[Mistake]]:
    """Trials that a metric promises to hold and that failed, and the reverse, the worst first.

    The worst failure promised is the one with the highest q*; the worst success denied the one with
    the lowest, of equal ones the one that bore the largest load.
    """
    usable = [case for case in cases if case.usable]
    promised = [c for c in usable if not c.success and c.score(metric) > threshold]
    denied = [c for c in usable if c.success and not c.score(metric) > threshold]
    promised.sort(key=lambda c: (-c.score(metric), c.q_sim or 0.0, c.number))
    denied.sort(key=lambda c: (c.score(metric), -(c.q_sim or 0.0), c.number))
    return _ranked(promised, metric), _ranked(denied, metric)


def _ranked(cases: Sequence[Case], metric: str) -> list[Mistake]:
    return [Mistake(case, metric, rank) for rank, case in enumerate(cases, 1)]


def worst(
    cases: Sequence[Case], metrics: Sequence[str], threshold: float, count: int
) -> list[Mistake]:
    """The worst mispredictions of some metrics, each trial once.

    They come in turns: of each metric the worst failure promised and the worst success denied, then
    the second ones, and so on.
    """
    kinds = [kind for metric in metrics for kind in mispredicted(cases, metric, threshold)]
    found: dict[int, Mistake] = {}
    for turn in zip_longest(*kinds):
        for mistake in turn:
            if mistake is not None and len(found) < count:
                found.setdefault(mistake.case.number, mistake)
    return list(found.values())
