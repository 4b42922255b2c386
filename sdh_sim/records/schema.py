"""The schema of ``trials.parquet``: one row per trial, the columns of ``TrialRow``.

Users' metrics, other hands and other moments than the snapshot add columns of their own; what
writes a table is told which. Array columns are fixed-size lists, so that pandas, polars and DuckDB
open the file as it is.
"""

from __future__ import annotations

from collections.abc import Sequence

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.hand_columns import as_in, hand_column, is_hand_column
from sdh_sim.records.moments import is_moment_column, moment_column, moments_in
from sdh_sim.records.trial_row import COLUMNS, TACTILE_UNIT
from sdh_sim.records.user_columns import added_column, added_in, is_added

FORMAT = "sdh-sim trials 1"
_BY_NAME = {column.name: column for column in COLUMNS}


def all_columns(added: Sequence[Column] = ()) -> tuple[Column, ...]:
    """All columns of a table: ours and the added ones, which may be ours in another shape."""
    return tuple(({c.name: c for c in COLUMNS} | {c.name: c for c in added}).values())


def schema_of(added: Sequence[Column] = ()) -> pa.Schema:
    """Schema of a table with all columns and the added ones."""
    return pa.schema(
        [column.field for column in all_columns(added)],
        metadata={"format": FORMAT, "tactile_unit": TACTILE_UNIT},
    )


SCHEMA = schema_of()


def column_named(name: str) -> Column:
    """The column of that name, one of ours or an added one; KeyError where there is none."""
    if is_hand_column(name):
        return hand_column(name)
    if is_moment_column(name):
        return moment_column(name)
    return added_column(name) if is_added(name) else _BY_NAME[name]


def columns_in(schema: pa.Schema) -> tuple[Column, ...]:
    """All columns of a table of ours with those that its file has besides."""
    hand = [hand_column(name) for name in dict.fromkeys(schema.names) if is_hand_column(name)]
    more = (*hand, *added_in(schema), *moments_in(schema))
    return tuple(as_in(schema, column) for column in (*COLUMNS, *more))
