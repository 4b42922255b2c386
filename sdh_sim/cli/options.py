"""Command-line options made from tables of settings."""

from __future__ import annotations

import functools
import inspect
import typing
from collections.abc import Callable
from typing import Annotated, Any

import typer

from sdh_sim.setting_table import Setting, settings_of


def options_from(*tables: type) -> Callable[[Callable[..., None]], Callable[[], None]]:
    """Give a command an option for every setting of the tables that the command line has.

    The command is called with what the user gave, by name, and nothing else. What was left out has
    the default of the table, of a preset or of the run that is continued: the command decides.
    """
    lines = [line for table in tables for line in settings_of(table).values() if line.option]

    def decorate(command: Callable[..., None]) -> Callable[[], None]:
        @functools.wraps(command)
        def with_options(**values: Any) -> None:
            given = {n: v for n, v in values.items() if v is not None and v is not False}
            command(**given)

        # Typer asks for the signature, which is then not the wrapped command's.
        parameters = [_parameter(line) for line in lines]
        vars(with_options)["__signature__"] = inspect.Signature(parameters)
        return with_options

    return decorate


def _parameter(line: Setting) -> inspect.Parameter:
    kind, default = line.type, None
    if typing.get_origin(kind) is tuple and typing.get_args(kind)[-1] is ...:
        kind = list[typing.get_args(kind)[0]]  # an option that may be given again
    if line.required:
        default = inspect.Parameter.empty
    elif kind is bool:
        default = False
    else:
        kind = kind | None
    option = typer.Option(
        line.flag,
        help=line.help,
        show_default=line.default_text or False,
        metavar=line.placeholder or None,
    )
    return inspect.Parameter(
        line.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=default,
        annotation=Annotated[kind, option],
    )
