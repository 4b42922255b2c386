"""Tables of grasps in Parquet, CSV and JSON: one row per grasp, columns by name.

Each reader gives rows as dicts of text and numbers (of text alone from CSV); what they mean is
checked where entries are made of them.
"""

from __future__ import annotations

import csv
import difflib
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from sdh_sim.errors import one_line
from sdh_sim.grasp_files.grasp_entry import (
    CLOSED,
    COLUMNS,
    HAND,
    MAX_NAME,
    OPEN,
    TEXTS,
    FormatError,
    GraspEntry,
    show,
)

_LARGEST = 1 << 30  # [bytes] of a Parquet file when it is unpacked; 100,000 grasps take 24 million


def read_parquet(data: bytes, max_grasps: int) -> Iterator[dict[str, Any]]:
    """The rows of a Parquet file; raises FormatError."""
    try:
        yield from _parquet_rows(data, max_grasps)
    except (pa.ArrowException, OSError, ValueError, OverflowError) as error:
        if isinstance(error, FormatError):
            raise
        reason = one_line(error, 100) or type(error).__name__
        raise FormatError(f"is not a readable Parquet file: {reason}") from error


def _parquet_rows(data: bytes, max_grasps: int) -> Iterator[dict[str, Any]]:
    schema = pq.read_schema(pa.BufferReader(data))
    _check_columns(schema.names)
    for field in schema:
        _check_type(field)
    # Text as dictionaries: a long text that every row repeats is in memory once.
    texts = [name for name in TEXTS if name in schema.names]
    file = pq.ParquetFile(
        pa.BufferReader(data), read_dictionary=texts, page_checksum_verification=True
    )
    about = file.metadata
    if about.num_rows > max_grasps:
        raise too_many(max_grasps)
    groups = range(about.num_row_groups)
    if sum(about.row_group(k).total_byte_size for k in groups) > _LARGEST:
        raise FormatError(f"is more than {_LARGEST} bytes when it is unpacked; split the file")
    table = file.read()
    table.validate(full=True)
    for name in texts:
        for chunk in table.column(name).chunks:
            _check_lengths(name, chunk)
    for batch in table.to_batches(max_chunksize=1024):
        yield from batch.to_pylist()


def _check_type(field: pa.Field) -> None:
    kind = field.type
    if field.name in TEXTS:
        if pa.types.is_dictionary(kind):
            kind = kind.value_type
        if not any(t(kind) for t in (pa.types.is_string, pa.types.is_large_string, _is_null)):
            raise FormatError(f"has {one_line(kind, 60)} in column {field.name}; expected text")
    elif not any(t(kind) for t in (pa.types.is_floating, pa.types.is_integer, _is_null)):
        raise FormatError(f"has {one_line(kind, 60)} in column {field.name}; expected numbers")


def _is_null(kind: pa.DataType) -> bool:
    return pa.types.is_null(kind)


def _check_lengths(name: str, column: pa.Array) -> None:
    if isinstance(column, pa.DictionaryArray):
        column = column.dictionary
    if _is_null(column.type):
        return
    longest = pc.max(pc.binary_length(column)).as_py() or 0
    if longest > 4 * MAX_NAME:
        raise FormatError(f"has text of {longest} bytes in {name}; allowed are {MAX_NAME} letters")


def read_csv(data: bytes, max_grasps: int) -> Iterator[dict[str, Any]]:
    """The rows of a CSV file with a header; empty cells are None. Raises FormatError."""
    try:
        lines = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""), strict=True)
        header = [name.strip() for name in next(lines, [])]
        _check_columns(header)
        count = 0
        for cells in lines:
            if not cells:
                continue
            count += 1
            if count > max_grasps:
                raise too_many(max_grasps)
            if len(cells) != len(header):
                raise FormatError(
                    f"has {len(cells)} cells in line {lines.line_num}; expected {len(header)}, as "
                    "in its header"
                )
            cells = [cell.strip() or None for cell in cells]
            yield dict(zip(header, cells, strict=True))
    except (UnicodeError, csv.Error) as error:
        raise FormatError(f"is not CSV in UTF-8: {one_line(error, 100)}") from error


def read_json(data: bytes, max_grasps: int) -> Iterator[dict[str, Any]]:
    """The rows of a JSON file, a list of objects; raises FormatError."""
    # Every grasp opens one brace. Counted first: parsed, a file of braces alone fills the memory.
    if data.count(b"{") > max_grasps:
        raise too_many(max_grasps)
    if data.count(b"[") > max_grasps:
        raise FormatError("is not a list of grasps; expected an object for each in one list")
    try:
        rows = json.loads(data.decode("utf-8-sig"), object_pairs_hook=_no_key_twice)
    except (ValueError, RecursionError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"is not JSON: {one_line(error, 100)}") from error
    if not isinstance(rows, list):
        raise FormatError(f"holds {show(rows)}; expected a list with an object for each grasp")
    known = None
    for number, row in enumerate(rows, start=1):
        if not isinstance(row, dict):
            raise FormatError(f"row {number} is {show(row)}; expected an object")
        if row.keys() != known:
            _check_columns(list(row))
            known = row.keys()
        yield row


def _no_key_twice(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        names = [name for name, _ in pairs]
        raise FormatError(f"has {show(next(n for n in names if names.count(n) > 1))} twice")
    return found


def _check_columns(names: Sequence[str]) -> None:
    """Raise FormatError where a column is unknown or there twice."""
    for name in names:
        if name in COLUMNS:
            continue
        kind = next((kind for kind in ("open_", "closed_") if name.startswith(kind)), None)
        if kind is not None:
            raise FormatError(
                f"has the column {show(name)}; the motors of this hand are "
                f"{', '.join(HAND.motor_names)}"
            )
        near = difflib.get_close_matches(name[:50], COLUMNS, 1)
        hint = f"is it {near[0]}?" if near else f"known are {', '.join((*COLUMNS[:11], '…'))}"
        raise FormatError(f"has the column {show(name)}; {hint}")
    if len(set(names)) != len(names):
        twice = next(name for name in names if list(names).count(name) > 1)
        raise FormatError(f"has the column {twice} twice")


def too_many(max_grasps: int) -> FormatError:
    """The error for a file with too many grasps."""
    return FormatError(f"has more than {max_grasps} grasps; split the file")


def write_parquet(entries: Sequence[GraspEntry]) -> bytes:
    """The content of a Parquet file."""
    rows = [entry.values() for entry in entries]
    columns = _columns(rows)
    types = {name: pa.string() if name in TEXTS else pa.float64() for name in columns}
    table = pa.table({name: pa.array([row[name] for row in rows], types[name]) for name in columns})
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd", write_page_checksum=True)
    return sink.getvalue().to_pybytes()


def write_csv(entries: Sequence[GraspEntry]) -> bytes:
    """The content of a CSV file, numbers with all their digits."""
    rows = [entry.values() for entry in entries]
    columns = _columns(rows)
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    # The module writes a float as repr does, and None as an empty cell.
    writer.writerows([row[name] for name in columns] for row in rows)
    return text.getvalue().encode()


def write_json(entries: Sequence[GraspEntry]) -> bytes:
    """The content of a JSON file, a grasp on a line; keys without a value are left out."""
    rows = [{k: v for k, v in entry.values().items() if v is not None} for entry in entries]
    lines = ",\n".join(json.dumps(row, ensure_ascii=False, allow_nan=False) for row in rows)
    return f"[\n{lines}\n]\n".encode()


def _columns(rows: Iterable[dict[str, Any]]) -> list[str]:
    """Columns that some row fills; those of the pose and the names are always there."""
    rows = list(rows)
    optional = {"preshape", "ratio", "object_yaw", "confidence", *OPEN, *CLOSED}
    return [
        name
        for name in COLUMNS
        if name not in optional or any(row[name] is not None for row in rows)
    ]
