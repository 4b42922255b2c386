"""The page of the documentation with every setting, made from the tables of settings.

    python -m sdh_sim.cli.settings_page > docs/settings.md

A test says when the page is not what this prints.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

from sdh_sim.cli.lift_request import LiftRequest
from sdh_sim.run_options import RunOptions
from sdh_sim.setting_table import Setting, settings_of
from sdh_sim.settings import TrialSettings

_HEAD = """# Settings

Every option of `sdh-sim lift`, with its default and what is allowed. This page is made from the
tables in the source that make the checks and the command's help, by
`python -m sdh_sim.cli.settings_page`.

`--resume` takes what is left out from the run that it continues, not from here. A name without
dashes is for Python alone.
"""
_TABLES = (
    ("What to lift", "", LiftRequest),
    (
        "One trial",
        "With the seed, these decide a trial completely; `run.json` keeps them. In Python they are "
        'the fields of `TrialSettings`: `TrialSettings("box", load_test="gravity")`.',
        TrialSettings,
    ),
    (
        "The run",
        "No trial depends on these. In Python they are arguments of `run_campaign`: "
        "`run_campaign(plan, out, workers=4, resume=True)`; there `workers` is 1 where it is left "
        "out. [Campaigns](campaigns.md) tells what happens when a run is stopped, killed or "
        "continued.",
        RunOptions,
    ),
)


def page() -> str:
    """The page as Markdown."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield _HEAD
    for number, (title, text, table) in enumerate(_TABLES):
        yield from (f"## {title}", "", *([textwrap.fill(text, 100), ""] if text else []))
        yield "| setting | default | allowed | meaning |"
        yield "|---|---|---|---|"
        yield from map(_row, settings_of(table).values())
        if number + 1 < len(_TABLES):
            yield ""


def _row(line: Setting) -> str:
    name = line.flag if line.option else line.name
    default = "required" if line.required else line.default_text
    unit = f" {line.unit}" if line.unit else ""
    allowed = line.allowed_text + unit if line.allowed_text else ""
    cells = (f"`{name}`", default + unit if default else "", allowed, line.meaning)
    return "|" + "|".join(f" {cell} " if cell else " " for cell in cells) + "|"


if __name__ == "__main__":
    print(page(), end="")
