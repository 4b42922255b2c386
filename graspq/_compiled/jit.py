"""How the library compiles: entries are kept on disk where a folder can be written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(function: Callable[..., Any] | None = None, **more: Any) -> Any:
    """Compile a part of an entry, without the interpreter's lock; with or without options.

    Parts are not kept by themselves: that would compile each to machine code of its own.
    """

    def wrap(plain: Callable[..., Any]) -> Any:
        return njit(nogil=True, error_model="numpy", **more)(plain)

    return wrap if function is None else wrap(function)


def entry(function: Callable[..., Any]) -> Any:
    """Compile what Python calls, and keep it on disk.

    Numba keeps the result beside the source, or in the user's cache folder when that is
    read-only (``NUMBA_CACHE_DIR`` names another); with neither, each process compiles anew.
    """
    try:
        return njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:
        return njit(nogil=True, error_model="numpy")(function)
