"""What a column of the table of trials is, and the columns that users' metrics add."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import pyarrow as pa

from sdh_sim.extensions import METRIC_NAME, UserMetric

METRIC = "metric_"
METRIC_ERROR = "metric_error"
_METRIC = re.compile(METRIC + METRIC_NAME.pattern)


class RecordError(ValueError):
    """A table or a row that cannot be used; the message says what came and what would do."""


def one_line(text: object, length: int = 200) -> str:
    """What comes from a file, as part of a message: its first line, cut to a length."""
    first = (str(text).splitlines() or [""])[0]
    return first if len(first) <= length else first[: length - 1] + "…"


@dataclass(frozen=True)
class Column:
    """One column of the table.

    Attributes:
        name: the key in a row.
        type: arrow type of one element.
        unit: unit of the values, "" where there is none.
        meaning: one line for the reader of the file.
        shape: () for a scalar, otherwise the shape of the array in each row.
        required: a row without it is refused; other columns may be null.
        threshold: of a user's metric: success is predicted above it.
    """

    name: str
    type: pa.DataType
    unit: str
    meaning: str
    shape: tuple[int, ...] = ()
    required: bool = False
    threshold: float | None = None

    @property
    def arrow_type(self) -> pa.DataType:
        """The element type wrapped in one fixed-size list per axis."""
        arrow = self.type
        for size in reversed(self.shape):
            arrow = pa.list_(arrow, size)
        return arrow

    @property
    def field(self) -> pa.Field:
        """The arrow field; unit, shape and meaning are its metadata."""
        about = {"unit": self.unit, "meaning": self.meaning}
        if self.shape:
            about["shape"] = "x".join(str(n) for n in self.shape)
        if self.threshold is not None:
            about["threshold"] = repr(self.threshold)
        return pa.field(self.name, self.arrow_type, nullable=not self.required, metadata=about)


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
