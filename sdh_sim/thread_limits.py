"""One numerical thread per process: workers share no cores, and sums keep their order."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)


def limit_threads() -> None:
    """Ask for one thread where the user asked for nothing; call it before numpy is imported."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")


@contextlib.contextmanager
def limited_children() -> Iterator[None]:
    """Processes started inside the block compute with one thread; this process is left alone."""
    added = [name for name in VARIABLES if name not in os.environ]
    limit_threads()
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)
