"""Finished trials on disk: the table, and beside it shards of what finished since it was written.

A shard is an Arrow stream file ``NNNNNNNN-CCCCCCCC.arrow`` of one or more rows; C is the CRC-32 of
its bytes. Each comes into being by one rename and is never changed, so that a kill leaves whole
shards only. Small shards are joined when they hold a row group, and all of them go into the table
in the end. A kill between a rename and the deletion of what it replaces leaves rows twice; readers
take one of each.
"""

from __future__ import annotations

import contextlib
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.atomic_files import write_atomic
from sdh_sim.errors import RecordError
from sdh_sim.records import (
    ROW_GROUP,
    SCHEMA,
    Column,
    TrialRow,
    all_columns,
    column_named,
    columns_there,
    readable,
    schema_of,
    table_of,
    with_nulls,
)

_CACHED_BLOCKS = 6  # of 3 MB; neighbours in the table mostly lie in two or three


class _Table:
    """The table as a source: its blocks are row groups."""

    def __init__(self, path: Path, added: Sequence[Column]) -> None:
        self.path = path
        self._columns = all_columns(added)
        with readable(path):
            self._file = pq.ParquetFile(path, page_checksum_verification=True)
            there = columns_there(path, self._file.schema_arrow, self._columns)
        self._there = {column.name for column in there}

    @property
    def blocks(self) -> int:
        return self._file.num_row_groups

    def read(self, block: int, columns: Sequence[str] | None = None) -> pa.Table:
        named = self._columns if columns is None else tuple(map(column_named, columns))
        names = [column.name for column in named if column.name in self._there]
        with readable(self.path):
            table = self._file.read_row_group(block, columns=names, use_threads=False)
            table.validate(full=True)
        return with_nulls(table, named)

    def close(self) -> None:
        self._file.close()


class _Shard:
    """A shard as a source of one block."""

    blocks = 1

    def __init__(self, path: Path, schema: pa.Schema) -> None:
        self.path = path
        self._schema = schema

    def read(self, block: int, columns: Sequence[str] | None = None) -> pa.Table:
        table = read_shard(self.path, self._schema)
        return table if columns is None else table.select(list(columns))

    def close(self) -> None:
        """Nothing stays open."""


def read_shard(path: Path, schema: pa.Schema = SCHEMA) -> pa.Table:
    """The rows of a shard; raises RecordError where it is damaged or has other columns."""
    try:
        data = path.read_bytes()
        if path.stem[9:] != f"{zlib.crc32(data):08x}":
            raise RecordError(f"{path} is damaged: its content does not match its name")
        table = pa.ipc.open_stream(data).read_all()
        table.validate(full=True)
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, RecordError):
            raise
        raise RecordError(f"{path} is not a readable shard: {error}") from error
    if not table.schema.equals(schema):
        raise RecordError(f"{path} is not a shard of this version")
    return table


@dataclass(frozen=True)
class Index:
    """Where each row of a set of sources is; arrays (n,), one entry per row.

    Attributes:
        trial: its number.
        source, block, row: its place.
    """

    trial: np.ndarray
    source: np.ndarray
    block: np.ndarray
    row: np.ndarray

    def __len__(self) -> int:
        return len(self.trial)

    def take(self, which: Any) -> Index:
        """The entries at those positions, or of a slice or mask."""
        return Index(self.trial[which], self.source[which], self.block[which], self.row[which])

    def once(self) -> Index:
        """One entry per trial, by trial number."""
        _, first = np.unique(self.trial, return_index=True)
        return self.take(first)


class Rows:
    """All rows of a table and its shards, without holding them in memory.

    Args:
        table, shards: files.
        added: columns of users' metrics.

    Raises:
        RecordError: the table is damaged or of another version; so do its methods for shards.
    """

    def __init__(self, table: Path, shards: Iterable[Path], added: Sequence[Column] = ()) -> None:
        self._schema = schema_of(added)
        self.sources: list[_Table | _Shard] = [_Table(table, added)] if table.exists() else []
        self.sources += [_Shard(path, self._schema) for path in shards]
        self._read = lru_cache(maxsize=_CACHED_BLOCKS)(self._block)

    def close(self) -> None:
        """Close the files."""
        for source in self.sources:
            source.close()

    def _block(self, source: int, block: int) -> pa.Table:
        return self.sources[source].read(block)

    def parts(self, columns: Sequence[str]) -> Iterator[tuple[int, int, pa.Table]]:
        """Every block's columns with the numbers of its source and block."""
        for number, source in enumerate(self.sources):
            for block in range(source.blocks):
                yield number, block, source.read(block, columns)

    def index(self) -> Index:
        """Every row by the number stored with it, rows that are there twice twice."""
        pieces = [
            place(table.column("trial").to_numpy(), number, block)
            for number, block, table in self.parts(["trial"])
        ]
        return join(pieces)

    def groups(self, index: Index) -> Iterator[pa.Table]:
        """The rows of the index in its order and with its numbers, ``ROW_GROUP`` at a time."""
        for start in range(0, len(index), ROW_GROUP):
            yield self._gather(index.take(slice(start, start + ROW_GROUP)))

    def _gather(self, part: Index) -> pa.Table:
        places = np.stack([part.source, part.block], axis=1)
        pieces: list[pa.Table] = []
        positions: list[np.ndarray] = []
        for source, block in np.unique(places, axis=0):
            mine = np.flatnonzero((part.source == source) & (part.block == block))
            pieces.append(self._read(int(source), int(block)).take(pa.array(part.row[mine])))
            positions.append(mine)
        order = np.argsort(np.concatenate(positions))
        # Schema metadata of a file is its writer's; the table's own is put back here.
        table = pa.concat_tables([piece.cast(self._schema) for piece in pieces])
        table = table.take(pa.array(order)).combine_chunks()
        return table.set_column(0, self._schema.field(0), pa.array(part.trial, pa.int64()))


def place(trials: np.ndarray, source: int, block: int) -> Index:
    """The index of one block; ``trials`` (n,) are its rows' numbers."""
    count = len(trials)
    return Index(
        np.asarray(trials, np.int64),
        np.full(count, source, np.int32),
        np.full(count, block, np.int32),
        np.arange(count, dtype=np.int32),
    )


def join(pieces: Sequence[Index]) -> Index:
    """Several indices as one."""
    pieces = pieces or [place(np.zeros(0), 0, 0)]
    return Index(
        *(np.concatenate([getattr(p, n) for p in pieces]) for n in Index.__dataclass_fields__)
    )


class ShardWriter:
    """Adds shards to a folder and keeps their number small.

    Args:
        folder: of the shards.
        added: columns of users' metrics.

    Attributes:
        rows: rows in shards that this writer wrote or was told of.
    """

    def __init__(self, folder: Path, added: Sequence[Column] = ()) -> None:
        self.folder = folder
        self._added = added
        self._schema = schema_of(added)
        self.rows = 0
        self._small: list[tuple[Path, int]] = []
        self._next = 0

    def list(self) -> list[Path]:
        """The shards, oldest first."""
        return shard_files(self.folder)

    def adopt(self, shards: Iterable[tuple[Path, int]]) -> None:
        """Go on from shards that are there, each with its number of rows."""
        for path, count in shards:
            self._next = max(self._next, int(path.name[:8]) + 1)
            self._count(path, count)

    def append(self, rows: Iterable[TrialRow]) -> None:
        """Keep rows (as ``normalise`` gives them); they are on the disk when this returns.

        Raises:
            OSError: the disk refused; nothing of them is kept.
        """
        self.folder.mkdir(exist_ok=True)
        table = table_of(rows, self._added)
        self._count(self._write(table), table.num_rows)
        if sum(count for _, count in self._small) >= ROW_GROUP:
            with contextlib.suppress(OSError):  # the rows are safe; a full disk shows at the next
                self._join_small()

    def _write(self, table: pa.Table) -> Path:
        sink = pa.BufferOutputStream()
        options = pa.ipc.IpcWriteOptions(compression="zstd", use_threads=False)
        with pa.ipc.new_stream(sink, self._schema, options=options) as writer:
            writer.write_table(table)
        data = sink.getvalue().to_pybytes()
        path = self.folder / f"{self._next:08d}-{zlib.crc32(data):08x}.arrow"
        write_atomic(path, data)
        self._next += 1
        return path

    def _count(self, path: Path, rows: int) -> None:
        self.rows += rows
        if rows < ROW_GROUP:
            self._small.append((path, rows))

    def _join_small(self) -> None:
        old = [path for path, _ in self._small]
        table = pa.concat_tables([read_shard(path, self._schema) for path in old])
        self._write(table.sort_by("trial").combine_chunks())
        self._small = []
        for path in old:
            path.unlink()

    def clear(self) -> None:
        """Delete every shard: their rows are in the table."""
        for path in self.list():
            path.unlink()
        self._small = []
        self.rows = 0
        if self.folder.is_dir():
            self.folder.rmdir()


def shard_files(folder: Path) -> list[Path]:
    """The shards in a folder, oldest first; none where the folder is missing."""
    name = "[0-9]" * 8 + "-" + "[0-9a-f]" * 8 + ".arrow"
    return sorted(folder.glob(name))
