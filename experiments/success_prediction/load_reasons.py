"""When the bounds miss the load that a grasp holds, and the grasps where they miss it most."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.success_prediction.metric_grid import REPORTED, Variant
from sdh_sim.analysis.comparison import NAMES
from sdh_sim.analysis.load_agreement import load_ratios
from sdh_sim.analysis.study import Study
from sdh_sim.analysis.trial_tables import SURPLUS
from sdh_sim.records import NO_TRUTH
from sdh_sim.report.page import Section, Table
from sdh_sim.report.table_cells import DASH, TableCell, object_name

SHOWN = 8
LOAD = ("q_sim", "q_sim_capped")
Row = Mapping[str, Any]


def load_section(
    study: Study, rows: Sequence[Row], values: dict[Variant, np.ndarray], pads: str
) -> Section:
    """q*/q_sim in parts of the trials, and the grasps where L-infinity misses q_sim most."""
    q = {name: values[replace(variant, pads=pads)] for name, variant in REPORTED.items()}
    tested = [
        k
        for k, row in enumerate(rows)
        if row.get("q_sim") is not None and row["failure"] not in NO_TRUTH and not row.get(SURPLUS)
    ]
    return Section(
        "Why the bounds miss",
        (by_circumstance(rows, q, tested), *worst(rows, q["q_linf"], tested)),
    )


def circumstances() -> list[tuple[str, Callable[[Row], bool]]]:
    """Parts of the trials: a name, and which rows belong to it."""
    return [
        ("all", lambda row: True),
        ("held in the lift", lambda row: bool(row["success"])),
        ("did not hold", lambda row: not row["success"]),
        ("pads see every contact", lambda row: not row.get("unsensed_contact")),
        ("others bear load too", lambda row: bool(row.get("unsensed_contact"))),
        ("both: held, pads see all",
         lambda row: row["success"] and not row.get("unsensed_contact")),
        ("side grasps", lambda row: row.get("approach") == "side"),
        ("top grasps", lambda row: row.get("approach") == "top"),
    ]  # fmt: skip


def by_circumstance(rows: Sequence[Row], q: dict[str, np.ndarray], tested: Sequence[int]) -> Table:
    """Median and spread of q*/q_sim of every bound in each part of the trials."""
    lines = []
    for text, belongs in circumstances():
        part = [k for k in tested if belongs(rows[k])]
        cells: list[str | TableCell] = [text, str(len(part))]
        for scores in q.values():
            loads, capped = (np.array([rows[k][name] for k in part]) for name in LOAD)
            ratios = load_ratios(scores[part], loads.astype(float), capped.astype(bool))
            if not len(ratios):
                cells.append(DASH)
                continue
            low, middle, high = np.quantile(ratios, [0.16, 0.5, 0.84], method="nearest")
            cells.append(TableCell(f"{middle:.2f}", f"{low:.2f}–{high:.2f}"))
        lines.append(cells)
    return Table(
        "Median of q*/q_sim (in brackets the 16 % and 84 % quantiles), 0 and infinity included, in "
        "parts of the trials.",
        ["trials", "n", *(NAMES[name] for name in q)],
        lines,
    )


def worst(rows: Sequence[Row], q: np.ndarray, tested: Sequence[int]) -> list[Table]:
    """Trials that L-infinity over- or underestimates most, also where one of the loads is 0."""

    def ratio(k: int) -> float:
        return q[k] / rows[k]["q_sim"]

    defined = [k for k in tested if q[k] > 0 and rows[k]["q_sim"] > 0]
    lost = [k for k in tested if q[k] > 0 and not rows[k]["q_sim"] > 0]
    unseen = [k for k in tested if q[k] <= 0 and rows[k]["q_sim"] > 0]
    picks = (
        ("most overestimated", sorted(defined, key=ratio, reverse=True)),
        ("most underestimated", sorted(defined, key=ratio)),
        ("promised most, held nothing", sorted(lost, key=lambda k: q[k], reverse=True)),
        ("promised nothing, held most",
         sorted(unseen, key=lambda k: rows[k]["q_sim"], reverse=True)),
    )  # fmt: skip
    found = []
    for text, chosen in picks:
        if not chosen:
            continue
        lines = [_describe(rows[k], float(q[k])) for k in chosen[:SHOWN]]
        found.append(
            Table(
                f"Grasps that L∞ {text}" if text.startswith("most") else f"L∞ {text}",
                ["object", "trial", "seed", "q* L∞", "q_sim", "failure", "pads", "unseen force"],
                lines,
                text_columns=(0, 5),
            )
        )
    return found


def _describe(row: Row, q: float) -> list[str]:
    sensed, unsensed = row.get("sensed_force_n") or 0.0, row.get("unsensed_force_n") or 0.0
    share = unsensed / (sensed + unsensed) if sensed + unsensed > 0 else 0.0
    pads = sum(
        int((np.asarray(pad) > 0).any())
        for kind in ("tactile_proximal", "tactile_distal")
        if row.get(kind) is not None
        for pad in row[kind]
    )
    return [
        object_name(row["object"]),
        str(row["trial"]),
        str(row["seed"]),
        f"{q:.2f}",
        f"{row['q_sim']:.2f}",
        row["failure"].replace("_", " "),
        str(pads),
        f"{100 * share:.0f} %",
    ]
