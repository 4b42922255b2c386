"""The table of a run, ``trials.parquet``: its columns, its rows, reading and writing it."""

from sdh_sim.errors import RecordError, one_line
from sdh_sim.records.column import Column
from sdh_sim.records.hand_columns import HAND_NAME, JOINTS, TACTILE, HandShape, hand_columns
from sdh_sim.records.moments import LIFT_OFF, SNAPSHOT, is_moment_column, lift_off_columns
from sdh_sim.records.parquet_files import (
    ROW_GROUP,
    columns_of,
    columns_there,
    hand_columns_of,
    read_rows,
    read_table,
    readable,
    with_nulls,
    write_groups,
    write_rows,
)
from sdh_sim.records.rows import (
    differing_columns,
    normalise,
    stack,
    table_of,
    to_rows,
    to_table,
)
from sdh_sim.records.schema import FORMAT, SCHEMA, all_columns, column_named, columns_in, schema_of
from sdh_sim.records.trial_row import COLUMNS, FAILURES, NO_TRUTH, TACTILE_UNIT, TrialRow
from sdh_sim.records.user_columns import (
    METRIC,
    METRIC_ERROR,
    added_column,
    added_columns,
    added_in,
    is_added,
    is_metric,
    threshold_in,
)

__all__ = [
    "COLUMNS",
    "FAILURES",
    "FORMAT",
    "HAND_NAME",
    "JOINTS",
    "LIFT_OFF",
    "METRIC",
    "METRIC_ERROR",
    "NO_TRUTH",
    "ROW_GROUP",
    "SCHEMA",
    "SNAPSHOT",
    "TACTILE",
    "TACTILE_UNIT",
    "Column",
    "HandShape",
    "RecordError",
    "TrialRow",
    "added_column",
    "added_columns",
    "added_in",
    "all_columns",
    "column_named",
    "columns_in",
    "columns_of",
    "columns_there",
    "differing_columns",
    "hand_columns",
    "hand_columns_of",
    "is_added",
    "is_metric",
    "is_moment_column",
    "lift_off_columns",
    "normalise",
    "one_line",
    "read_rows",
    "read_table",
    "readable",
    "schema_of",
    "stack",
    "table_of",
    "threshold_in",
    "to_rows",
    "to_table",
    "with_nulls",
    "write_groups",
    "write_rows",
]
