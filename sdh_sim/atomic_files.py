"""Files that are whole or not there, whatever crash, kill or full disk comes in between."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


@contextlib.contextmanager
def atomic_file(path: Path) -> Iterator[BinaryIO]:
    """A file to write that takes the place of ``path`` in one step when the block ends.

    It is on the disk before this returns. Where the block raises, the file that was there stays as
    it was; a kill leaves at most ``path`` plus ``.tmp`` beside it.

    Raises:
        OSError: the disk refused; the file that was there stays as it was.
    """
    temporary = path.with_name(path.name + ".tmp")
    try:
        with open(temporary, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    if hasattr(os, "O_DIRECTORY"):  # the rename itself must outlive a power cut too
        folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def write_atomic(path: Path, data: bytes) -> None:
    """Replace the file's content in one step, on the disk before this returns.

    Raises:
        OSError: the disk refused; the file that was there stays as it was.
    """
    with atomic_file(path) as file:
        file.write(data)
