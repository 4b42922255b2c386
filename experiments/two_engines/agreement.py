"""How far two engines agree: labels, motions, loads, and what that makes of every bound's score."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from experiments.score_table import verdict_scores
from experiments.two_engines.alignment import FULL, NAMES
from experiments.two_engines.table import LABELS, STRAIGHT
from sdh_sim.analysis.comparison import ALL_METRICS, Comparison, compare_scores, name_of
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.errors import RunError
from sdh_sim.metrics import read_stored
from sdh_sim.records import columns_of, read_table
from sdh_sim.runs import open_runs
from sdh_sim.trial.outcome import MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG

AT_REST = ("settled_q_linf", "settled_q_l1", "settled_q_capability", "settled_q_whole_hand")
SETTLING_COLUMNS = ("settled", "settled_displacement_mm", "q_settled", *AT_REST)
NEAR_LIMIT = 1.5  # mm and degrees from a limit within which a motion counts as next to it
NEAR_LOAD = 0.05  # of its weight by which an object that falls or stays was next to doing otherwise


@dataclass(frozen=True)
class Labels:
    """Trials that both engines have labelled.

    Attributes:
        rows: of the runs.
        found: rows of the tables beside them by alignment, None where a trial has none.
    """

    rows: list[dict[str, Any]]
    found: dict[str, list[dict[str, Any] | None]]


class Agreement(NamedTuple):
    """Two sets of labels of the same trials.

    Attributes:
        labels: share on which they are the same.
        lost, gained: trials that the first holds and the second does not, and the other way round.
        held: trials held in both.
        off: differences of their displacements, median and 90 % quantile [mm].
        bias: median of the differences with their sign, the second less the first [mm].
    """

    labels: Proportion
    lost: int
    gained: int
    held: int
    off: tuple[float, float]
    bias: float


def both_labels(runs: Sequence[Path]) -> Labels:
    """Trials of the runs with the rows of the tables beside them.

    Raises:
        RunError, RecordError: a run that cannot be read, or nothing has been compared yet.
    """
    rows: list[dict[str, Any]] = []
    known: dict[tuple[int, str], dict[str, Any]] = {}
    for run in runs:
        table = LABELS.read(run)
        place = {}
        for row in _rows(run):
            place[row["trial"]] = len(rows)
            rows.append(row)
        known |= {(place[r["trial"]], r["alignment"]): r for r in table if r["trial"] in place}
    if not known:
        raise RunError(f"{runs[0]} holds no trial that the second engine could carry on")
    names = [n for n in (STRAIGHT, "none", *NAMES) if any(key[1] == n for key in known)]
    found = {name: [known.get((k, name)) for k in range(len(rows))] for name in names}
    return Labels(rows, found)


def _rows(run: Path) -> list[dict[str, Any]]:
    """Rows of a run, with what settling said of them where it was asked."""
    with open_runs([run]) as opened:
        path = opened[0].table
        _, rows = read_stored([path])
        names = columns_of([path], tuple(SETTLING_COLUMNS))
        if names:
            for row, more in zip(rows, read_table(path, names).to_pylist(), strict=True):
                row |= more
    return rows


def agree(first: Sequence[Any], second: Sequence[Any]) -> Agreement:
    """Compare rows of two engines, in the same order; trials that either lacks are left out."""
    pairs = [(a, b) for a, b in zip(first, second, strict=True) if a is not None and b is not None]
    lost = sum(a["success"] and not b["success"] for a, b in pairs)
    gained = sum(b["success"] and not a["success"] for a, b in pairs)
    held = [(a, b) for a, b in pairs if a["success"] and b["success"]]
    change = np.array([b["displacement_mm"] - a["displacement_mm"] for a, b in held])
    off, bias = (math.nan, math.nan), math.nan
    if len(change):
        off = (float(np.median(np.abs(change))), float(np.quantile(np.abs(change), 0.9)))
        bias = float(np.median(change))
    same = Proportion(len(pairs) - lost - gained, len(pairs))
    return Agreement(same, lost, gained, len(held), off, bias)


def load_ratios(labels: Labels) -> np.ndarray:
    """q_sim in Drake over that of the run (n,), of grasps that bear something in both."""
    ratios = []
    for row, other in zip(labels.rows, labels.found.get(FULL, []), strict=True):
        own = row.get("q_sim")
        if other is None or not own or math.isnan(other["q_sim"]) or other["q_sim_capped"]:
            continue
        if not row["q_sim_capped"] and other["q_sim"] > 0.0:
            ratios.append(other["q_sim"] / own)
    return np.array(ratios)


def weightless(labels: Labels) -> tuple[int, int, int]:
    """Grasps that give way without any weight: in both engines, in MuJoCo alone, in Drake alone."""
    found = [
        (row["q_sim"] == 0.0, other["q_sim"] == 0.0)
        for row, other in zip(labels.rows, labels.found.get(FULL, []), strict=True)
        if other is not None and row.get("q_sim") is not None and not math.isnan(other["q_sim"])
    ]
    return found.count((True, True)), found.count((True, False)), found.count((False, True))


def kind_of(row: dict[str, Any], straight: dict[str, Any] | None, other: dict[str, Any]) -> str:
    """Why the engines disagree on a grasp, as far as the numbers show it.

    ``arm``: MuJoCo too says what Drake says once nothing turns in the lift. ``limit``: the one that
    holds moved to within ``NEAR_LIMIT`` of a limit. ``load``: it bears its weight with
    less than ``NEAR_LOAD`` to spare or to lack (of runs with a load test). ``other``: none.
    """
    if straight is not None and straight["success"] == other["success"]:
        return "arm"
    holding = row if row["success"] else other
    if (
        holding["displacement_mm"] > MAX_DISPLACEMENT_MM - NEAR_LIMIT
        or holding["rotation_deg"] > MAX_ROTATION_DEG - NEAR_LIMIT
    ):
        return "limit"
    failing = other if row["success"] else row
    if (
        failing["displacement_mm"] < MAX_DISPLACEMENT_MM + NEAR_LIMIT
        and failing["rotation_deg"] < MAX_ROTATION_DEG + NEAR_LIMIT
    ):
        return "limit"
    loads = [x["q_sim"] for x in (row, other) if x.get("q_sim") is not None]
    if any(abs(load - 1.0) < NEAR_LOAD for load in loads):
        return "load"
    return "other"


def scored(labels: Labels, alignment: str = FULL) -> dict[str, dict[str, Comparison]]:
    """Every predictor against MuJoCo's labels, Drake's, and those on which they agree.

    Trials without contact, which no engine was asked about, are left out.
    """
    pairs = [
        (row, other)
        for row, other in zip(labels.rows, labels.found[alignment], strict=True)
        if other is not None
    ]
    first = np.array([row["success"] for row, _ in pairs])
    second = np.array([other["success"] for _, other in pairs])
    everyone = np.ones(len(pairs), dtype=bool)
    kinds = {
        "MuJoCo": (first, everyone), "Drake": (second, everyone), "both": (first, first == second),
    }  # fmt: skip
    found: dict[str, dict[str, Comparison]] = {}
    for metric in (*ALL_METRICS, *AT_REST):
        if any(row.get(metric) is not None for row, _ in pairs):
            values = np.array([_number(row.get(metric)) for row, _ in pairs])
            found[name_of(metric)] = {
                kind: compare_scores(values[use], success[use], metric=metric)
                for kind, (success, use) in kinds.items()
            }
    if all(row.get("settled") is not None for row, _ in pairs):
        held = np.array([row["settled"] for row, _ in pairs])
        moved = np.array([_number(row.get("settled_displacement_mm")) for row, _ in pairs])
        values = verdict_scores(held, np.nan_to_num(moved, nan=np.inf))
        found["settling"] = {
            kind: compare_scores(values[use], success[use])
            for kind, (success, use) in kinds.items()
        }
    return found


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)
