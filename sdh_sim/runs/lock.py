"""One run at a time in a folder, by a lock of the operating system's: it ends with its process."""

from __future__ import annotations

import contextlib
import datetime
import errno
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from sdh_sim.errors import RunError

if sys.platform == "win32":
    import msvcrt

    def _take(file: BinaryIO) -> None:
        # Far behind the text, because a locked byte cannot be read by others.
        file.seek(1 << 20)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _take(file: BinaryIO) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


_TAKEN = (errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK)


@contextlib.contextmanager
def run_lock(path: Path) -> Iterator[None]:
    """Hold the lock file; it stays behind, empty of meaning, when its holder ends or is killed.

    Raises:
        RunError: another process holds it, or the file system has no locks.
        OSError: the file cannot be made.
    """
    with open(path, "a+b", buffering=0) as file:
        try:
            _take(file)
        except OSError as error:
            if error.errno not in _TAKEN:
                raise RunError(
                    f"cannot lock {path}: {error.strerror or error}; choose an --out on a file "
                    "system with locks"
                ) from error
            raise RunError(
                f"another run is writing into {path.parent} ({_holder(path)}); wait for its end, "
                "stop it, or choose another --out"
            ) from error
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}, since {now}\n".encode())
        yield
        file.truncate(0)


def _holder(path: Path) -> str:
    try:
        text = path.read_bytes()[:200].decode("utf-8", "replace")
    except OSError:
        text = ""
    return " ".join(text.split()) or "its process is not known"
