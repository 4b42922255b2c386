"""The table of a run, ``trials.parquet``: one row per trial, its columns listed here and only here.

Users' metrics add columns of their own at the end (``columns``); what writes a table is told which.

A row is a plain ``dict`` from column name to value. Array columns are fixed-size lists, so that
pandas, polars and DuckDB open the file as it is; ``stack`` gives them back as one numpy array.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.atomic import atomic_file
from sdh_sim.columns import Column, RecordError, added_column, added_in, is_added, one_line

Row = dict[str, Any]

FAILURES = ("none", "no_contact", "dropped", "slipped", "rotated", "unstable_simulation", "error")
"""How a trial ended. ``none`` is a success. ``unstable_simulation`` (the simulation diverged) and
``error`` (the trial raised, or its process died, twice) tell nothing about the grasp: comparisons
leave both out and count them. An ``error`` row has no values but trial, object and seed."""
TACTILE_UNIT = "kPa"
FORMAT = "sdh-sim trials 1"
ROW_GROUP = 1024  # rows; about 3 MB in memory, so that a table of any size can be streamed


_INT, _REAL, _TEXT, _FLAG = pa.int64(), pa.float64(), pa.string(), pa.bool_()

COLUMNS: tuple[Column, ...] = (
    Column("trial", _INT, "", "number of the trial in its run", required=True),
    Column("object", _TEXT, "", "name of the object model", required=True),
    Column("seed", _INT, "", "seed that decides the trial", required=True),
    Column("success", _FLAG, "", "the object was lifted and held", required=True),
    Column("failure", _TEXT, "", "one of " + ", ".join(FAILURES), required=True),
    Column("displacement_mm", _REAL, "mm", "object motion in the hand frame since the snapshot"),
    Column("rotation_deg", _REAL, "deg", "object rotation in the hand frame since the snapshot"),
    Column("q_linf", _REAL, "", "task scaling under the L-infinity bound"),
    Column("q_l1", _REAL, "", "task scaling under the L1 bound"),
    Column("q_capability", _REAL, "", "task scaling within what shared motors could do"),
    Column("q_held", _REAL, "", "task scaling with saturated motors at their torque, else -inf"),
    Column("q_whole_hand", _REAL, "", "as q_capability, with all that touches, felt or not"),
    Column("epsilon_linf", _REAL, "", "epsilon of the same wrench sets, L-infinity, 1 N = 1 N m"),
    Column("epsilon_l1", _REAL, "", "epsilon of the same wrench sets, L1, 1 N = 1 N m"),
    Column("volume_linf", _REAL, "N^3 (N m)^3", "volume, hard contacts, L-infinity; null above 3"),
    Column("volume_l1", _REAL, "N^3 (N m)^3", "volume, hard contacts, L1; null above 3"),
    Column("q_reason", _TEXT, "", "why q is 0 or missing, empty otherwise"),
    Column("contacts", _INT, "", "pads with readings that the prediction used"),
    Column("q_sim", _REAL, "", "weights the grasp held in the load test, by the simulation"),
    Column("q_sim_capped", _FLAG, "", "the load test ended at its largest load; q_sim is that"),
    Column(
        "load_at_failure",
        _REAL,
        "N, N m",
        "load along +x -x +y -y +z -z and moment about x y z of the hand at failure; inf: none",
        (9,),
    ),
    Column("disturbance_failure", _TEXT, "", "failure of the disturbance test after the lift"),
    Column("disturbance_displacement_mm", _REAL, "mm", "object motion in it"),
    Column("disturbance_rotation_deg", _REAL, "deg", "object rotation in it"),
    Column("repeats", _INT, "", "perturbed copies of the trial that ran"),
    Column("success_probability", _REAL, "", "share of them that held"),
    Column("success_low", _REAL, "", "lower end of its 95 % Wilson interval"),
    Column("success_high", _REAL, "", "upper end of its 95 % Wilson interval"),
    Column(
        "perceived_pose_hand",
        _REAL,
        "m, quaternion",
        "object pose in the hand frame that the metrics saw: x y z qw qx qy qz",
        (7,),
    ),
    Column("perceived_mass_kg", _REAL, "kg", "mass that the metrics assumed"),
    Column("perceived_friction", _REAL, "", "friction that the metrics assumed"),
    Column("sensed_force_n", _REAL, "N", "sum of normal forces on taxels at the snapshot"),
    Column("unsensed_force_n", _REAL, "N", "the same on palm, edges and backs, which no pad feels"),
    Column("unsensed_contact", _FLAG, "", "such a contact bears force at the snapshot"),
    Column("surplus", _FLAG, "", "beyond its share of a preset: not compared; null without one"),
    Column("mass_kg", _REAL, "kg", "mass of the object"),
    Column("friction", _REAL, "", "friction coefficient of the object"),
    Column("torque_limit_nm", _REAL, "N m", "torque limit of each motor", (7,)),
    Column("joint_angles_rad", _REAL, "rad", "motor angles at the snapshot", (7,)),
    Column("motor_torque_nm", _REAL, "N m", "motor torques at the snapshot", (7,)),
    Column("peak_torque_nm", _REAL, "N m", "largest motor torques of the whole trial", (7,)),
    Column(
        "tactile_proximal",
        pa.float32(),
        TACTILE_UNIT,
        "proximal pads at the snapshot: finger, row, column",
        (3, 14, 6),
    ),
    Column(
        "tactile_distal",
        pa.float32(),
        TACTILE_UNIT,
        "distal pads at the snapshot: finger, row, column",
        (3, 13, 6),
    ),
    Column(
        "object_pose_hand",
        _REAL,
        "m, quaternion",
        "object pose in the hand frame at the snapshot: x y z qw qx qy qz",
        (7,),
    ),
    Column(
        "hand_pose_world",
        _REAL,
        "m, quaternion",
        "hand frame in the world at the snapshot: x y z qw qx qy qz",
        (7,),
    ),
    Column("approach", _TEXT, "", "side or top"),
    Column("preshape", _TEXT, "", "preshape of the fingers"),
    Column("plan_azimuth_rad", _REAL, "rad", "direction of approach about the vertical"),
    Column("plan_roll_rad", _REAL, "rad", "roll of the hand about its approach axis"),
    Column("plan_tilt_rad", _REAL, "rad", "tilt of the approach off the horizontal or vertical"),
    Column("plan_depth_m", _REAL, "m", "palm frame to grasp centre along the palm's z"),
    Column("plan_height_m", _REAL, "m", "height of the grasp"),
    Column("plan_offset_m", _REAL, "m", "position error of the approach", (3,)),
    Column("object_yaw_rad", _REAL, "rad", "yaw of the object on the table"),
    Column("resampled_unreachable", _INT, "", "grasps drawn before that the arm cannot reach"),
    Column("resampled_colliding", _INT, "", "grasps drawn before that collide at the start"),
    Column("sim_seconds", _REAL, "s", "simulated time"),
)
"""Every column in the table's order; a new column is one line here."""

_BY_NAME = {column.name: column for column in COLUMNS}


def schema_of(added: Sequence[Column] = ()) -> pa.Schema:
    """Schema of a table with all columns and the added ones."""
    return pa.schema(
        [column.field for column in (*COLUMNS, *added)],
        metadata={"format": FORMAT, "tactile_unit": TACTILE_UNIT},
    )


SCHEMA = schema_of()


def column_named(name: str) -> Column:
    """The column of that name, one of ours or an added one; KeyError where there is none."""
    return added_column(name) if is_added(name) else _BY_NAME[name]


def columns_in(schema: pa.Schema) -> tuple[Column, ...]:
    """All columns of a table of ours with those that its file has besides."""
    return (*COLUMNS, *added_in(schema))


def normalise(row: Mapping[str, Any]) -> Row:
    """The row with every column present, arrays as numpy, NaN scalars as None.

    Args:
        row: values by column name; columns that may be null can be left out.

    Raises:
        RecordError: an unknown or missing column, a wrong shape or type, an unknown failure.
    """
    more = [name for name in row if name not in _BY_NAME]
    unknown = sorted(name for name in more if not is_added(name))
    if unknown:
        raise RecordError(f"row has unknown column {unknown[0]!r}; columns are listed in COLUMNS")
    columns = (*COLUMNS, *(added_column(name) for name in more))
    full = {column.name: _value(column, row.get(column.name)) for column in columns}
    if full["failure"] not in FAILURES:
        got = one_line(repr(full["failure"]))
        raise RecordError(f"failure is {got}; expected one of {', '.join(FAILURES)}")
    if full["success"] != (full["failure"] == "none"):
        raise RecordError(f"success is {full['success']} but failure is {full['failure']!r}")
    return full


def _value(column: Column, value: Any) -> Any:
    if value is None:
        if column.required:
            raise RecordError(f"row lacks column {column.name!r}, which every row needs")
        return None
    try:
        if column.shape:
            array = np.array(value, dtype=column.type.to_pandas_dtype())
            if array.shape != column.shape:
                raise RecordError(
                    f"column {column.name!r} has shape {array.shape}; expected {column.shape}"
                )
            return array
        if pa.types.is_floating(column.type):
            return None if np.isnan(value) else float(value)
        wanted = {_INT: (int, np.integer), _FLAG: (bool, np.bool_), _TEXT: (str,)}[column.type]
        if not isinstance(value, wanted) or (column.type == _INT and isinstance(value, bool)):
            raise TypeError
        if column.type == _INT:
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


def table_of(full: Iterable[Row], added: Sequence[Column] = ()) -> pa.Table:
    """As ``to_table`` for rows that ``normalise`` gave, which it does not check again.

    Raises:
        RecordError: a row has a metric that is not among the added columns.
    """
    full = sorted(full, key=lambda row: row["trial"])
    columns = (*COLUMNS, *added)
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
    filled = np.array([blank if value is None else value for value in values], dtype=blank.dtype)
    array = pa.array(filled.reshape(-1))
    for axis in reversed(range(len(column.shape))):
        mask = pa.array(missing) if axis == 0 and missing.any() else None
        array = pa.FixedSizeListArray.from_arrays(array, column.shape[axis], mask=mask)
    return array


def write_rows(rows: Iterable[Mapping[str, Any]], path: Path, added: Sequence[Column] = ()) -> None:
    """Write the table so that a reader, or a crash, sees the old file or the new, never a part.

    Args:
        rows: in any order.
        path: of the file.
        added: columns of users' metrics.

    Raises:
        OSError: the disk refused; the file that was there stays as it was.
    """
    table = to_table(rows, added)
    starts = range(0, table.num_rows, ROW_GROUP)
    write_groups((table.slice(start, ROW_GROUP) for start in starts), path, added)


def write_groups(groups: Iterable[pa.Table], path: Path, added: Sequence[Column] = ()) -> None:
    """Write a table that comes in pieces of ``ROW_GROUP`` rows (the last may be shorter).

    The file's bytes are those that ``write_rows`` gives for the same rows; one piece at a time is
    in memory.

    Raises:
        OSError: the disk refused; the file that was there stays as it was.
    """
    with (
        atomic_file(path) as file,
        pq.ParquetWriter(
            file, schema_of(added), compression="zstd", write_page_checksum=True
        ) as writer,
    ):
        for group in groups:
            writer.write_table(group.combine_chunks(), row_group_size=ROW_GROUP)


@contextlib.contextmanager
def readable(path: Path) -> Iterator[None]:
    """What fails in the block because of the file at ``path`` becomes a RecordError."""
    try:
        yield
    except RecordError:
        raise
    except FileNotFoundError as error:
        raise RecordError(f"{path} does not exist") from error
    except (pa.ArrowException, OSError, ValueError, OverflowError) as error:
        reason = one_line(error) or type(error).__name__
        raise RecordError(f"{path} is not a readable parquet file: {reason}") from error


def read_table(path: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """The table of a run, or the named columns of it.

    Raises:
        RecordError: no such file, not a readable parquet file, or not a table of trials.
    """
    with readable(path):
        file = pq.ParquetFile(path, page_checksum_verification=True)
        wanted = columns_in(file.schema_arrow)
        if columns is not None:
            wanted = tuple(column_named(name) for name in columns)
        for column in wanted:
            check_field(path, file.schema_arrow, column)
        table = file.read(columns=[column.name for column in wanted])
        table.validate(full=True)
        return table


def check_field(path: Path, schema: pa.Schema, column: Column) -> None:
    """Raise RecordError unless the file's schema has the column with its type."""
    if column.name not in schema.names:
        raise RecordError(
            f"{path} has no column {column.name!r}; it is not a table of this version"
        )
    if schema.names.count(column.name) > 1:
        raise RecordError(f"{path} has column {column.name!r} twice; it is not a table of ours")
    found = schema.field(column.name).type
    if found != column.arrow_type:
        raise RecordError(
            f"{path}: column {column.name!r} is {one_line(found)}; expected {column.arrow_type}"
        )


def stack(table: pa.Table, name: str) -> np.ndarray:
    """An array column as one array (n, *shape), or a number column as (n,); null becomes NaN."""
    column = column_named(name)
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


def to_rows(table: pa.Table) -> list[Row]:
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


def read_rows(path: Path) -> list[Row]:
    """The rows of a table file; raises RecordError where it is not one."""
    return to_rows(read_table(path))


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
