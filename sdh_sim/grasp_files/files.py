"""Reading and writing files of grasps, whatever their format; the name's ending tells which."""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from sdh_sim.atomic_files import write_atomic
from sdh_sim.errors import GraspFileError, one_line
from sdh_sim.grasp_files import isaac_grasp, tables
from sdh_sim.grasp_files.grasp_entry import (
    EntryError,
    FormatError,
    GraspEntry,
    entry_of,
    show,
    text_of,
)
from sdh_sim.user_references import GraspSet

MAX_BYTES = 64 << 20
MAX_GRASPS = 100_000
_TABLES = {".parquet": tables.read_parquet, ".csv": tables.read_csv, ".json": tables.read_json}
_YAML = (".yaml", ".yml")
ENDINGS = (*_TABLES, *_YAML)


def read_grasps(path: str | Path, objects: Sequence[str] = ()) -> list[GraspEntry]:
    """The grasps of a file.

    Args:
        path: of a table (.parquet, .csv, .json) or of isaac_grasp YAML (.yaml, .yml).
        objects: names that grasps may be for; a file that names no object takes one alone. Empty:
            any names, of a file that has them.

    Raises:
        GraspFileError: the file, or a grasp in it, cannot be used.
    """
    path = Path(path)
    return _entries(path, _content(path), objects)


def find_grasp_set(path: str | Path, objects: Sequence[str] = ()) -> tuple[GraspSet, list[Any]]:
    """The reference to a file, and its grasps; arguments and errors as ``read_grasps``."""
    path = Path(os.path.abspath(Path(path).expanduser()))
    if not str(path).isprintable():
        raise GraspFileError(f"grasps: {show(str(path), 400)}: the path must be printable")
    data = _content(path)
    entries = _entries(path, data, objects)
    return GraspSet(str(path), hashlib.sha256(data).hexdigest()), entries


def read_grasp_set(reference: GraspSet, objects: Sequence[str]) -> list[GraspEntry]:
    """The grasps of a file that a run refers to.

    Args:
        reference: of the run.
        objects: of the run.

    Raises:
        GraspFileError: the file is missing, has changed or cannot be used.
    """
    path = Path(reference.path)
    data = _content(path)
    if hashlib.sha256(data).hexdigest() != reference.sha256:
        raise GraspFileError(
            f"grasps: {path} has changed since the run began; bring the file back, or start a run "
            "of its own with another --out"
        )
    return _entries(path, data, objects)


def _entries(path: Path, data: bytes, objects: Sequence[str]) -> list[GraspEntry]:
    with _about(path):
        entries: list[GraspEntry] = []
        numbers: Counter[str] = Counter()
        taken: set[tuple[str, str]] = set()
        for where, row in _rows(path, data):
            try:
                name = text_of(row, "object") or _only(objects)
                entry = entry_of(row, name, f"grasp_{numbers[name]}")
            except EntryError as error:
                raise FormatError(f"{where} {error}") from error
            if objects and entry.object not in objects:
                raise FormatError(
                    f"{where} is for {show(entry.object)}; the objects are {', '.join(objects)}: "
                    "remove the row, or give its --object too"
                )
            if (entry.object, entry.name) in taken:
                raise FormatError(
                    f"{where} is the second {show(entry.name)} of {entry.object}; give each grasp "
                    "of an object a name of its own"
                )
            taken.add((entry.object, entry.name))
            numbers[entry.object] += 1
            entries.append(entry)
        if not entries:
            raise FormatError("holds no grasp; give at least one")
        return entries


def _rows(path: Path, data: bytes) -> Iterator[tuple[str, Mapping[str, Any]]]:
    ending = path.suffix.lower()
    if ending in _YAML:
        yield from isaac_grasp.read_rows(data, MAX_GRASPS)
        return
    for number, row in enumerate(_TABLES[ending](data, MAX_GRASPS), start=1):
        yield f"row {number}", row


def _only(objects: Sequence[str]) -> str:
    if len(objects) != 1:
        many = f"there are {len(objects)}: {', '.join(objects)}" if objects else "none is given"
        raise EntryError(f"names no object, and {many}; add a column object, or give one --object")
    return objects[0]


@contextlib.contextmanager
def _about(path: Path) -> Iterator[None]:
    """What is wrong with the content becomes an error that names the file."""
    try:
        yield
    except FormatError as error:
        # Messages quote the file: no control characters, no change of writing direction.
        text = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in str(error))
        raise GraspFileError(f"grasps: {path}: {one_line(text, 600)}") from error
    except MemoryError as error:
        raise GraspFileError(f"grasps: {path}: takes more memory than there is") from error


def _content(path: Path) -> bytes:
    """The bytes of a file, at most ``MAX_BYTES``; raises GraspFileError."""
    check_ending(path)
    try:
        # Opening a pipe would wait for ever and a device has no end: hence flag and check.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with open(handle, "rb") as file:
            if not stat.S_ISREG(os.fstat(handle).st_mode):
                raise GraspFileError(f"grasps: {path} is not a file; give a file of grasps")
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, GraspFileError):
            raise
        reason = getattr(error, "strerror", None) or "not a path"
        raise GraspFileError(
            f"grasps: cannot read {show(str(path), 400)}: {reason}; give a file of grasps"
        ) from error
    if len(data) > MAX_BYTES:
        raise GraspFileError(
            f"grasps: {path} has more than {MAX_BYTES} bytes, the most that is read; split it"
        )
    return data


def check_ending(path: Path) -> None:
    """Raise GraspFileError unless the name's ending tells a format."""
    if path.suffix.lower() not in ENDINGS:
        raise GraspFileError(
            f"grasps: got {show(path.name)}; expected a name that ends in {', '.join(ENDINGS)}"
        )


def write_grasps(entries: Iterable[GraspEntry], path: str | Path) -> None:
    """Write grasps so that they can be read again, to the last bit; the file is whole or not there.

    Args:
        entries: the grasps.
        path: of the file; its ending (.parquet, .csv, .json, .yaml, .yml) tells the format. YAML
            holds the grasps of one object.

    Raises:
        GraspFileError: another ending, too many grasps, or those of several objects in YAML.
        OSError: the disk refused; the file that was there stays as it was.
    """
    path, entries = Path(path), list(entries)
    check_ending(path)
    if len(entries) > MAX_GRASPS:
        raise GraspFileError(
            f"grasps: {path} would hold {len(entries)} grasps; allowed are {MAX_GRASPS}: write "
            "fewer, those of one object for example"
        )
    match path.suffix.lower():
        case ".parquet":
            data = tables.write_parquet(entries)
        case ".csv":
            data = tables.write_csv(entries)
        case ".json":
            data = tables.write_json(entries)
        case _:
            objects = list(dict.fromkeys(entry.object for entry in entries))
            if len(objects) > 1:
                raise GraspFileError(
                    f"grasps: {path} would hold grasps of {', '.join(objects)}; isaac_grasp YAML "
                    "has one object: choose one, or write .parquet, .csv or .json"
                )
            data = isaac_grasp.write_text(entries, "".join(objects)).encode()
    write_atomic(path, data)
