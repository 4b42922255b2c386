"""What a column of the table of trials is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pyarrow as pa


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
        per_hand: the lengths of the shape are those of the hand.
    """

    name: str
    type: pa.DataType
    unit: str
    meaning: str
    shape: tuple[int, ...] = ()
    required: bool = False
    threshold: float | None = None
    per_hand: bool = False

    def with_shape(self, shape: tuple[int, ...]) -> Column:
        """The column with another shape."""
        return replace(self, shape=shape)

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
