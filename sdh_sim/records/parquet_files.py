"""Tables of trials as Parquet files: written whole or not at all, checked when they are read."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.atomic_files import atomic_file
from sdh_sim.errors import RecordError, one_line
from sdh_sim.records.column import Column
from sdh_sim.records.hand_columns import as_in, is_hand_column
from sdh_sim.records.rows import to_rows, to_table
from sdh_sim.records.schema import column_named, columns_in, is_moment_column, schema_of
from sdh_sim.records.trial_row import TrialRow
from sdh_sim.records.user_columns import is_added

ROW_GROUP = 1024  # rows; about 3 MB in memory, so that a table of any size can be streamed


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

    The whole table of an earlier version gets the columns that it lacks, null in every row.

    Raises:
        RecordError: no such file, not a readable parquet file, not a table of trials, or one
            without a named column.
    """
    with readable(path):
        file = pq.ParquetFile(path, page_checksum_verification=True)
        schema = file.schema_arrow
        if columns is None:
            wanted = columns_in(schema)
            there = columns_there(path, schema, wanted)
        else:
            wanted = there = tuple(as_in(schema, column_named(name)) for name in columns)
            for column in wanted:
                check_field(path, schema, column)
        table = file.read(columns=[column.name for column in there])
        table.validate(full=True)
        return with_nulls(table, wanted)


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


def columns_there(path: Path, schema: pa.Schema, wanted: Iterable[Column]) -> tuple[Column, ...]:
    """Those of the columns that a file has: earlier versions lacked some.

    Raises:
        RecordError: one that every row needs, or a user's metric, is missing, or one is of another
            type.
    """
    names = set(schema.names)
    there = tuple(c for c in wanted if c.required or is_added(c.name) or c.name in names)
    for column in there:
        check_field(path, schema, column)
    return there


def with_nulls(table: pa.Table, wanted: Sequence[Column]) -> pa.Table:
    """The table with the columns wanted, in that order; those that it lacks are null."""
    names = set(table.column_names)
    return pa.table(
        {
            c.name: table.column(c.name)
            if c.name in names
            else pa.nulls(table.num_rows, c.arrow_type)
            for c in wanted
        },
        schema=pa.schema(
            [table.schema.field(c.name) if c.name in names else c.field for c in wanted],
            metadata=table.schema.metadata,
        ),
    )


def read_rows(path: Path) -> list[TrialRow]:
    """The rows of a table file; raises RecordError where it is not one."""
    return to_rows(read_table(path))


def columns_of(paths: Sequence[Path], wanted: Sequence[str]) -> tuple[str, ...]:
    """Those of the wanted columns that every one of the tables has."""
    found = [_column_names(path) for path in paths]
    return tuple(name for name in wanted if all(name in names for names in found))


def hand_columns_of(paths: Sequence[Path]) -> tuple[str, ...]:
    """Columns of other hands than the SDH-2 that every one of the tables has."""
    first = _column_names(paths[0]) if paths else set()
    return columns_of(paths, sorted(name for name in first if is_hand_column(name)))


def moment_columns_of(paths: Sequence[Path]) -> tuple[str, ...]:
    """Columns of other moments than the first snapshot that every one of the tables has."""
    first = _column_names(paths[0]) if paths else set()
    return columns_of(paths, sorted(name for name in first if is_moment_column(name)))


def _column_names(path: Path) -> set[str]:
    try:
        return set(pq.read_schema(path).names)
    except (pa.ArrowException, OSError):  # whoever reads the table says what is wrong with it
        return set()
