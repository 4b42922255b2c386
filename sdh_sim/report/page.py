"""The report's page: what it consists of, and how the template makes one file of it.

The page holds its figures, its style sheet and its script, and neither font nor address of another
file. ``report.html.j2`` has one macro for each kind of part; whatever it is given is text, which
it escapes. Without the script all is there to be read: it makes tables sortable, and moves among
the marks of a figure by keys.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import ClassVar, NamedTuple

import jinja2

from sdh_sim.report.table_cells import TableCell

TEMPLATE = "report.html.j2"
STYLE_SHEET = "report.css"
SCRIPT = "report.js"


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


class Mark(NamedTuple):
    """A dot of a figure that says what it is.

    Attributes:
        x, y: from the figure's upper left corner [points].
        case: number of the trial; its dots in other figures have the same.
        text: what it says.
        command: how to look at it; empty where there is no way.
    """

    x: float
    y: float
    case: int
    text: str
    command: str


@dataclass(frozen=True)
class Picture:
    """A figure.

    Attributes:
        svg: content of its SVG file.
        number: its number on the page.
        caption: below the figure.
        marks: dots that say what they are.
        size: width and height [points], needed with marks.
        numbers: name of the table with the figure's numbers, or empty.
    """

    kind: ClassVar[str] = "picture"
    svg: bytes
    number: int
    caption: str
    marks: Sequence[Mark] = ()
    size: tuple[float, float] = (0.0, 0.0)
    numbers: str = ""

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
        name: of the table, unlike any other's on the page; figures refer to it.
        folded: shown only when it is opened.
    """

    kind: ClassVar[str] = "table"
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | TableCell]]
    text_columns: Sequence[int] = (0,)
    ruled_rows: Sequence[int] = ()
    name: str = ""
    folded: bool = False


class Exhibit(NamedTuple):
    """One trial that a list shows.

    Attributes:
        text: what it is.
        command: how to look at it; empty where there is no way.
        jpeg: its picture; empty for none.
        note: such as why there is no picture.
    """

    text: str
    command: str = ""
    jpeg: bytes = b""
    note: str = ""

    @property
    def jpeg_base64(self) -> str:
        """The picture as the address of an image contains it."""
        return base64.b64encode(self.jpeg).decode()


@dataclass(frozen=True)
class Exhibits:
    """Trials as a numbered list, with pictures where there are some."""

    kind: ClassVar[str] = "exhibits"
    entries: Sequence[Exhibit]


Part = Paragraph | Bullets | Picture | Table | Exhibits


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
        title=title,
        lead=lead,
        sections=sections,
        style_sheet=_resource(STYLE_SHEET),
        script=_resource(SCRIPT),
    )


def _resource(name: str) -> str:
    """Text of a file beside this module, which need not lie on a disk."""
    return (files("sdh_sim.report") / name).read_text(encoding="utf-8")
