"""The report's page: what it consists of, and how the template makes one file of it.

The page holds its figures and its style sheet, and neither script nor font nor address of another
file. ``report.html.j2`` has one macro for each kind of part; whatever it is given is text, which
it escapes.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import ClassVar

import jinja2

from sdh_sim.report.table_cells import TableCell

TEMPLATE = "report.html.j2"
STYLE_SHEET = "report.css"


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of text."""

    kind: ClassVar[str] = "paragraph"
    text: str


@dataclass(frozen=True)
class Bullets:
    """Sentences as a list."""

    kind: ClassVar[str] = "bullets"
    sentences: Sequence[str]


@dataclass(frozen=True)
class Picture:
    """A figure.

    Attributes:
        svg: content of its SVG file.
        number: its number on the page.
        caption: below the figure.
    """

    kind: ClassVar[str] = "picture"
    svg: bytes
    number: int
    caption: str

    @property
    def svg_base64(self) -> str:
        """The figure as the address of an image contains it."""
        return base64.b64encode(self.svg).decode()


@dataclass(frozen=True)
class Table:
    """A table, set as in a paper.

    Attributes:
        caption: above the table.
        head: names of the columns.
        rows: a cell for each column.
        text_columns: columns of text, set to the left; numbers are set to the right.
        ruled_rows: rows with a thin rule above.
    """

    kind: ClassVar[str] = "table"
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | TableCell]]
    text_columns: Sequence[int] = (0,)
    ruled_rows: Sequence[int] = ()


Part = Paragraph | Bullets | Picture | Table


@dataclass(frozen=True)
class Section:
    """A heading and the parts below it."""

    title: str
    parts: Sequence[Part]


def render_page(title: str, lead: str, sections: Sequence[Section]) -> str:
    """The whole page as HTML; ``lead`` is the line below the title."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_resource),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(TEMPLATE).render(
        title=title, lead=lead, sections=sections, style_sheet=_resource(STYLE_SHEET)
    )


def _resource(name: str) -> str:
    """Text of a file beside this module, which need not lie on a disk."""
    return (files("sdh_sim.report") / name).read_text(encoding="utf-8")
