"""How the library compiles, and keeps what it compiled.

An *entry* is what Python calls. Its callers give arrays of one kind, so it is compiled once, at its
first call, and kept on disk. A *part* is called by entries and other parts alone; it becomes
machine code inside the entries that use it, and stays a plain function for Python.

Numba keeps an entry beside its source, or in the user's cache folder where that is read-only
(``NUMBA_CACHE_DIR`` names another). It looks at the entry's own file alone to see whether what it
kept is still valid, so here the name that an entry is kept under also holds a digest of every file
of its folder, which its parts may come from: code of another version is never found. A folder that
cannot be written, or a damaged file in it, costs time and nothing else.

Processes that need the same entry at once do not all compile it: one does, holding a lock on the
entry's source file, and the others wait for what it keeps. The lock ends with its process; one that
stands still holds the others up for ``PATIENCE`` at most.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import hashlib
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows
    fcntl: Any = None

from numba import njit, typeof
from numba.extending import register_jitable

# The interpreter's lock is not held; a division by zero gives an infinity, as in C; nobody calls
# from C.
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
PATIENCE = 120.0  # [s]
NOTE = "graspq: compiling {name} for the first time on this machine; this takes some seconds"


@functools.cache
def digest_of(folder: Path) -> str:
    """Return a short digest of the names and contents of a folder's Python files."""
    total = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        total.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return total.hexdigest()[:12]


def compiled(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Make a part: with or without options of Numba's, as ``fastmath``."""

    def wrap(plain: Callable[..., Any]) -> Any:
        return register_jitable(**OPTIONS, **options)(plain)

    return wrap if function is None else wrap(function)


def entry(function: Callable[..., Any]) -> Entry:
    """Make an entry of a function."""
    return Entry(function)


class Entry:
    """A function that is compiled, or read from disk, when it is called first."""

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(self, function)
        # Numba names the files after it. Parts come from the entry's own folder.
        self._source = Path(function.__code__.co_filename)
        digest = digest_of(self._source.parent)
        function.__qualname__ = f"{function.__name__}_{digest}"
        self._function = function
        self._kernel: Any = None
        self._lock = threading.Lock()

    def __call__(self, *args: Any) -> Any:
        if self._kernel is None:
            with self._lock:
                if self._kernel is None:
                    self._kernel = self._ready(tuple(typeof(a) for a in args))
        return self._kernel(*args)

    @property
    def busy(self) -> bool:
        """Whether another process compiles it now, as far as can be told."""
        if self._kernel is not None:
            return False
        with _lock(self._source) as mine:
            return not mine

    def _ready(self, signature: tuple[Any, ...]) -> Any:
        """The compiled function, from disk where it is there."""
        name = self._function.__qualname__
        try:
            # RuntimeError without a folder that can be written.
            kernel = njit(cache=True, **OPTIONS)(self._function)
        except RuntimeError:
            _tell(self._function.__name__)
            return self._uncached(signature)
        kept = _kept(kernel, name)
        if not kept:
            _tell(self._function.__name__)
        try:
            # What another process has kept by the time the lock is free is read, not compiled.
            with _lock(self._source, 0.0 if kept else PATIENCE), _no_collection():
                kernel.compile(signature)
            return kernel
        except Exception:
            # A full disk and a damaged file raise whatever they happen to raise. The files go, so
            # that the next process finds none; an error in the code itself comes once more below.
            for path in _kept(kernel, name):
                with contextlib.suppress(OSError):
                    path.unlink()
            return self._uncached(signature)

    def _uncached(self, signature: tuple[Any, ...]) -> Any:
        kernel = njit(**OPTIONS)(self._function)
        with _no_collection():
            kernel.compile(signature)
        return kernel


@contextlib.contextmanager
def _lock(path: Path, patience: float = 0.0) -> Iterator[bool]:
    """Hold a file's lock in the block; False where another process kept it for so long [s].

    Where there are no such locks the block runs without one, as if it had it.
    """
    if fcntl is None:
        yield True
        return
    with contextlib.ExitStack() as stack:
        try:
            file = stack.enter_context(open(path, "rb"))
        except OSError:
            yield True
            return
        deadline = time.monotonic() + patience
        while (free := _try_lock(file.fileno())) is False and time.monotonic() < deadline:
            time.sleep(0.05)
        yield free is not False


def _try_lock(number: int) -> bool | None:
    """Take the lock of an open file: whether it was free, None where there are no locks."""
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


@contextlib.contextmanager
def _no_collection() -> Iterator[None]:
    """Keep the cyclic garbage collector from going through all that a compiler builds."""
    on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if on:
            gc.enable()


def _kept(kernel: Any, name: str) -> list[Path]:
    """The files on disk that hold an entry."""
    folder = Path(kernel.stats.cache_path)
    return [p for p in folder.glob(f"*{name}*") if p.suffix in (".nbi", ".nbc")]


def _tell(name: str) -> None:
    """Tell a person who waits why; programs and log files are told nothing."""
    if sys.stderr is not None and sys.stderr.isatty():
        print(NOTE.format(name=name), file=sys.stderr, flush=True)
