"""Rows of the table: checked, made into Arrow tables and back, compared."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from sdh_sim.errors import RecordError, one_line
from sdh_sim.records.column import Column
from sdh_sim.records.hand_columns import as_in, is_hand_column
from sdh_sim.records.schema import (
    all_columns,
    column_named,
    columns_in,
    is_moment_column,
    schema_of,
)
from sdh_sim.records.trial_row import COLUMNS, FAILURES, TrialRow
from sdh_sim.records.user_columns import is_added

_KNOWN = {column.name for column in COLUMNS}
_WANTED = {pa.int64(): (int, np.integer), pa.bool_(): (bool, np.bool_), pa.string(): (str,)}


def normalise(row: Mapping[str, Any]) -> TrialRow:
    """The row with values as the table keeps them: arrays as numpy, NaN scalars as None.

    Args:
        row: values by column name; columns that may be null can be left out.

    Raises:
        RecordError: an unknown or missing column, a wrong shape or type, an unknown failure.
    """
    more = [name for name in row if name not in _KNOWN]
    unknown = sorted(
        name
        for name in more
        if not (is_added(name) or is_hand_column(name) or is_moment_column(name))
    )
    if unknown:
        raise RecordError(f"row has unknown column {unknown[0]!r}; columns are listed in COLUMNS")
    full = TrialRow(
        **{column.name: _value(column, row.get(column.name)) for column in COLUMNS},
        user_columns={name: _value(column_named(name), row[name]) for name in more},
    )
    if full.failure not in FAILURES:
        got = one_line(repr(full.failure))
        raise RecordError(f"failure is {got}; expected one of {', '.join(FAILURES)}")
    if full.success != (full.failure == "none"):
        raise RecordError(f"success is {full.success} but failure is {full.failure!r}")
    return full


def _value(column: Column, value: Any) -> Any:
    if value is None:
        if column.required:
            raise RecordError(f"row lacks column {column.name!r}, which every row needs")
        return None
    try:
        if column.shape:
            array = np.array(value, dtype=column.type.to_pandas_dtype())
            fits = array.ndim == len(column.shape) if column.per_hand else False
            if array.shape != column.shape and not fits:
                raise RecordError(
                    f"column {column.name!r} has shape {array.shape}; expected {column.shape}"
                )
            return array
        if pa.types.is_floating(column.type):
            return None if np.isnan(value) else float(value)
        wanted, whole = _WANTED[column.type], column.type == pa.int64()
        if not isinstance(value, wanted) or (whole and isinstance(value, bool)):
            raise TypeError
        if whole:
            np.int64(value)  # raises OverflowError
        return wanted[0](value)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, RecordError):
            raise
        raise RecordError(
            f"column {column.name!r} got {one_line(repr(value))}; expected {column.arrow_type}"
        ) from error


def to_table(rows: Iterable[Mapping[str, Any]], added: Sequence[Column] = ()) -> pa.Table:
    """Rows, in any order, as an arrow table sorted by trial number."""
    return table_of([normalise(row) for row in rows], added)


def table_of(full: Iterable[TrialRow], added: Sequence[Column] = ()) -> pa.Table:
    """As ``to_table`` for rows that ``normalise`` gave, which it does not check again.

    Raises:
        RecordError: a row has a metric that is not among the added columns.
    """
    full = sorted(full, key=lambda row: row["trial"])
    columns = all_columns(added)
    known = {column.name for column in columns}
    for row in full:
        if len(row) > len(COLUMNS) and (more := [name for name in row if name not in known]):
            raise RecordError(f"row has column {more[0]!r}, which this table has not")
    return pa.Table.from_arrays(
        [_array(c, [row.get(c.name) for row in full]) for c in columns], schema=schema_of(added)
    )


def _array(column: Column, values: Sequence[Any]) -> pa.Array:
    if not column.shape:
        return pa.array(values, type=column.type)
    missing = np.array([value is None for value in values], dtype=bool)
    blank = np.zeros(column.shape, dtype=column.type.to_pandas_dtype())
    for value in values:
        if value is not None and value.shape != column.shape:
            raise RecordError(
                f"column {column.name!r} has shape {value.shape}; expected {column.shape}"
            )
    filled = np.array([blank if value is None else value for value in values], dtype=blank.dtype)
    array = pa.array(filled.reshape(-1))
    for axis in reversed(range(len(column.shape))):
        mask = pa.array(missing) if axis == 0 and missing.any() else None
        array = pa.FixedSizeListArray.from_arrays(array, column.shape[axis], mask=mask)
    return array


def stack(table: pa.Table, name: str) -> np.ndarray:
    """An array column as one array (n, *shape), or a number column as (n,); null becomes NaN."""
    column = as_in(table.schema, column_named(name))
    flat = table.column(name).combine_chunks()
    if isinstance(flat, pa.ChunkedArray):
        flat = pa.concat_arrays(flat.chunks) if flat.num_chunks else pa.array([], flat.type)
    valid = np.array(flat.is_valid())
    for _ in column.shape:
        flat = flat.flatten()  # leaves out the values of null rows
    present = np.asarray(flat if column.shape else flat.drop_null())
    out = np.full((len(valid), *column.shape), np.nan)
    out[valid] = present.reshape(-1, *column.shape)
    return out


def to_rows(table: pa.Table) -> list[TrialRow]:
    """The rows of a table as ``normalise`` gives them."""
    columns: dict[str, list[Any]] = {}
    for column in columns_in(table.schema):
        values = table.column(column.name)
        if column.shape:
            arrays = stack(table, column.name).astype(column.type.to_pandas_dtype())
            columns[column.name] = [
                a if ok else None
                for a, ok in zip(arrays, values.is_valid().to_pylist(), strict=True)
            ]
        else:
            columns[column.name] = values.to_pylist()
    return [
        normalise(dict(zip(columns, values, strict=True)))
        for values in zip(*columns.values(), strict=True)
    ]


def differing_columns(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[str]:
    """Names of the columns in which two rows differ in any bit that the table keeps."""
    a, b = normalise(first), normalise(second)
    return [name for name in {**a, **b} if not _same(a.get(name), b.get(name))]


def _same(a: Any, b: Any) -> bool:
    if a is None or b is None:
        return a is b
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b, equal_nan=True)
    return a == b
