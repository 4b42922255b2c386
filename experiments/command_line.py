"""How the experiments take their options: what cannot be used is one line, and exit status 2."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import NoReturn


def fail(message: str) -> NoReturn:
    """Print the experiment's name and one line to the error stream, and exit with status 2.

    Args:
        message: what came, what was expected, what to do.
    """
    script = Path(sys.argv[0])
    name = script.parent.name if script.stem == "__main__" else script.stem
    print(f"{name}: {' '.join(message.split())}", file=sys.stderr)
    raise SystemExit(2)


class Parser(argparse.ArgumentParser):
    """An argument parser that says in one line what is wrong.

    Args:
        description: the experiment's docstring, of which the first line is shown.
    """

    def __init__(self, description: str | None) -> None:
        super().__init__(description=(description or "").partition("\n")[0], allow_abbrev=False)

    def error(self, message: str) -> NoReturn:
        """Print the message as one line and exit with status 2."""
        fail(message)


def at_least(parser: argparse.ArgumentParser, options: argparse.Namespace, **least: int) -> None:
    """Refuse whole numbers below the least that makes sense, by the name of their option."""
    for name, value in least.items():
        if getattr(options, name) < value:
            option = name.replace("_", "-")
            parser.error(f"--{option} must be at least {value}, got {getattr(options, name)}")
