"""The numbers of a report as flat tables, written as CSV and Parquet."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.study import Study
from sdh_sim.atomic_files import write_atomic

Record = dict[str, Any]


def tables_of(study: Study) -> dict[str, list[Record]]:
    """Every table by name; all rows of one have the same keys."""
    found = {
        "summary": _summary(study),
        "pairs": _pairs(study),
        "calibration": _calibration(study),
        "curves": _curves(study),
        "load": _load(study),
    }
    return {name: rows for name, rows in found.items() if rows}


def _rate(name: str, rate: Proportion) -> Record:
    low, high = rate.interval or (None, None)
    return {name: rate.value, f"{name}_low": low, f"{name}_high": high}


def _bounds(name: str, bounds: tuple[float, float] | None) -> Record:
    low, high = bounds or (None, None)
    return {f"{name}_low": low, f"{name}_high": high}


def _summary(study: Study) -> list[Record]:
    rows = []
    for finding in study.findings.values():
        c, best, curve = finding.comparison, finding.best, finding.precision_recall
        row: Record = dict(zip(compare.CSV_HEADER, compare.csv_values(c), strict=True))
        row["average_precision"] = curve.area if curve else None
        row |= _bounds("average_precision", curve.area_interval if curve else None)
        row["best_threshold"] = best.threshold if best else None
        row |= _bounds("best_threshold", (best.low, best.high) if best else None)
        none = Proportion(0, 0)
        row |= _rate("best_accuracy", best.accuracy if best else none)
        row |= _rate("best_tpr", best.true_positive_rate if best else none)
        row |= _rate("best_tnr", best.true_negative_rate if best else none)
        rows.append(row)
    return rows


def _pairs(study: Study) -> list[Record]:
    rows = []
    for group, p in study.paired.items():
        row = {"object": group, "first": "q_linf", "second": "q_l1", "n": p.n}
        row |= _rate("disagree", p.disagree)
        row |= {
            "only_first_right": p.only_first_right,
            "only_second_right": p.only_second_right,
            "only_first_predicts_success": p.first_optimistic.n,
            "of_these_succeeded": p.first_optimistic.k,
            "only_second_predicts_success": p.second_optimistic.n,
            "of_those_succeeded": p.second_optimistic.k,
            "mcnemar_p": p.p_value,
            "auc_difference": p.areas.value if p.areas else None,
            "delong_p": p.areas.p_value if p.areas else None,
        }
        rows.append(row | _bounds("auc_difference", p.areas.interval if p.areas else None))
    return rows


def _calibration(study: Study) -> list[Record]:
    rows = []
    for (group, metric), finding in study.findings.items():
        c = finding.calibration
        for k in range(len(c.targets) if c else 0):
            assert c is not None
            row = {
                "object": group,
                "metric": metric,
                "desired_fpr": float(c.targets[k]),
                "threshold": float(c.threshold[k]),
                "threshold_low": float(c.threshold_low[k]),
                "threshold_high": float(c.threshold_high[k]),
                "tpr": float(c.tpr[k]),
                "tpr_low": float(c.tpr_low[k]),
                "tpr_high": float(c.tpr_high[k]),
            }
            rows.append(row | _rate("achieved_fpr", c.achieved[k]))
    return rows


def _curves(study: Study) -> list[Record]:
    rows = []
    for (group, metric), finding in study.findings.items():
        for kind, curve in (("roc", finding.roc), ("pr", finding.precision_recall)):
            if curve is None:
                continue
            points = zip(curve.thresholds, curve.x, curve.y, strict=True)
            label = {"object": group, "metric": metric, "curve": kind}
            rows += [
                label | {"score_at_least": float(t), "x": float(x), "y": float(y)}
                for t, x, y in points
            ]
    return rows


def _load(study: Study) -> list[Record]:
    rows = []
    for (group, metric, subset), a in study.agreement.items():
        row = {"object": group, "metric": metric, "trials": subset, "n": a.n}
        row["spearman"] = a.spearman
        row |= _bounds("spearman", a.spearman_interval)
        ratio = a.ratio
        low, high = ratio.quartiles if ratio else (None, None)
        row |= {"ratios": ratio.n if ratio else 0, "median_ratio": ratio.median if ratio else None}
        row |= _bounds("median_ratio", ratio.median_interval if ratio else None)
        row |= {
            "quartile_low": low,
            "quartile_high": high,
            "spread_factor": ratio.spread if ratio else None,
        }
        row |= _rate("not_above_q_sim", a.below)
        counts = {"capped": a.capped, "both_above_zero": a.both, "q_zero": a.zero}
        rows.append(row | counts | {"q_sim_zero": a.dropped, "both_zero": a.neither})
    return rows


def csv_text(rows: Sequence[Record]) -> str:
    """The rows as CSV with a header; None is empty."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def write_table(rows: Sequence[Record], stem: Path) -> list[Path]:
    """Write one or more rows as ``stem``.csv and ``stem``.parquet; raises OSError."""
    table = pa.Table.from_pylist(list(rows))
    for position, field in enumerate(table.schema):
        if pa.types.is_null(field.type):  # None in every row
            column = table.column(position).cast(pa.float64())
            table = table.set_column(position, field.name, column)
    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    paths = [stem.with_suffix(".csv"), stem.with_suffix(".parquet")]
    write_atomic(paths[0], csv_text(rows).encode())
    write_atomic(paths[1], buffer.getvalue())
    return paths
