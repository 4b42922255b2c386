"""How the commands print: tables on stdout, progress and warnings on stderr."""

from __future__ import annotations

import sys
from collections.abc import Collection

from rich import box
from rich.console import Console
from rich.table import Table

_FILE_WIDTH = 120  # a file or a pipe has no width of its own; tables should not fold there


def output() -> Console:
    """The console of results."""
    return _console(stderr=False)


def errors() -> Console:
    """The console of progress and warnings."""
    return _console(stderr=True)


def _console(stderr: bool) -> Console:
    stream = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr, width=None if stream.isatty() else _FILE_WIDTH, highlight=False)


def plain_table(*columns: str, text: Collection[int] = (0,)) -> Table:
    """A table with a rule below its head; columns at the positions ``text`` are set to the left."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for position, name in enumerate(columns):
        table.add_column(name, justify="left" if position in text else "right")
    return table
