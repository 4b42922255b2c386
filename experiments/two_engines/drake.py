"""Whether the second engine is there."""

from __future__ import annotations

from importlib.util import find_spec

from experiments.command_line import fail


def need_drake() -> None:
    """Say what to install and exit with status 2 where Drake is not installed."""
    if find_spec("pydrake") is None:
        fail('the second engine, Drake, is not installed: pip install -e ".[crosscheck]"')
