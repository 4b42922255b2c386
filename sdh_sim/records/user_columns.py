"""What a column of the table of trials is, and the columns that users' metrics add."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.user_references import METRIC_NAME, UserMetric

METRIC = "metric_"
METRIC_ERROR = "metric_error"
_METRIC = re.compile(METRIC + METRIC_NAME.pattern)


def is_added(name: str) -> bool:
    """Whether a column is one that users' metrics add."""
    return _METRIC.fullmatch(name) is not None


def is_metric(name: str) -> bool:
    """Whether a column holds the values of a user's metric."""
    return is_added(name) and name != METRIC_ERROR


def added_column(name: str, threshold: float | None = None) -> Column:
    """The column of that name, for which ``is_added``."""
    if name == METRIC_ERROR:
        return Column(name, pa.string(), "", "what users' metrics raised, empty where nothing")
    meaning = f"the user's metric {name.removeprefix(METRIC)}; null where it gave no number"
    return Column(name, pa.float64(), "", meaning, threshold=threshold)


def added_columns(metrics: Sequence[UserMetric]) -> tuple[Column, ...]:
    """The columns that the metrics of a run add to its table."""
    if not metrics:
        return ()
    each = (added_column(m.column, m.threshold) for m in metrics)
    return (*each, added_column(METRIC_ERROR))


def added_in(schema: pa.Schema) -> tuple[Column, ...]:
    """The columns in a file that users' metrics added."""
    names = (name for name in dict.fromkeys(schema.names) if is_added(name))
    return tuple(added_column(name, threshold_in(schema, name)) for name in names)


def threshold_in(schema: pa.Schema, name: str) -> float | None:
    """The threshold that a file states for a user's metric, or None."""
    if schema.names.count(name) != 1:
        return None
    try:
        value = float((schema.field(name).metadata or {}).get(b"threshold", b"nan"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None
