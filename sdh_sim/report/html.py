"""A self-contained page: no script, no font, no address outside the file."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from sdh_sim.analysis.proportion import Proportion

DASH = "–"
MINUS = "−"

_CSS = """
:root { color-scheme: light; }
body { max-width: 58rem; margin: 2.5rem auto 4rem; padding: 0 1.2rem; color: #1a1a1a;
  background: #fff; font: 1.02rem/1.5 Charter, "Bitstream Charter", Cambria, Georgia,
  "DejaVu Serif", serif; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .6rem; }
p.lead { color: #444; margin-top: 0; }
ul.key { padding-left: 1.2rem; }
ul.key li { margin: .25rem 0; }
figure { margin: 1.6rem 0; text-align: center; }
figure img { max-width: 100%; height: auto; }
figcaption, caption { font-size: .9rem; line-height: 1.4; color: #333; text-align: left;
  max-width: 48rem; margin: .5rem auto 0; }
caption { caption-side: top; margin: 0 0 .5rem; padding: 0 0 .4rem; }
div.wide { overflow-x: auto; margin: 1.4rem 0; }
table { border-collapse: collapse; margin: 0 auto; font-size: .84rem; line-height: 1.35;
  font-variant-numeric: tabular-nums lining-nums; border-top: 1.6px solid #222;
  border-bottom: 1.6px solid #222; }
th { font-weight: 600; border-bottom: 1px solid #222; vertical-align: bottom; }
th, td { padding: .22rem .5rem; text-align: right; white-space: nowrap; }
th.text, td.text { text-align: left; }
tr.rule td { border-top: 1px solid #bbb; }
td small { color: #666; font-size: .92em; }
a { color: #0b4f8a; }
@media print { body { margin: 0; max-width: none; } figure, table { break-inside: avoid; } }
"""


@dataclass(frozen=True)
class Section:
    """A heading and the parts below it, each already HTML."""

    title: str
    parts: tuple[str, ...]


def page(title: str, lead: str, sections: Sequence[Section]) -> str:
    """The whole document; title and lead are plain text."""
    body = "\n".join(
        f"<section>\n<h2>{escape(s.title)}</h2>\n" + "\n".join(s.parts) + "\n</section>"
        for s in sections
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_CSS}</style>\n</head>\n<body>\n"
        f'<h1>{escape(title)}</h1>\n<p class="lead">{escape(lead)}</p>\n{body}\n</body>\n</html>\n'
    )


def paragraph(text: str) -> str:
    """Plain text as a paragraph."""
    return f"<p>{escape(text)}</p>"


def bullets(lines: Sequence[str]) -> str:
    """Plain sentences as a list."""
    return '<ul class="key">' + "".join(f"<li>{escape(line)}</li>" for line in lines) + "</ul>"


def picture(svg: Path, number: int, caption: str) -> str:
    """An SVG file embedded, with a numbered caption in plain text."""
    data = base64.b64encode(svg.read_bytes()).decode()
    return (
        f'<figure id="figure-{number}"><img alt="{escape(caption, quote=True)}" '
        f'src="data:image/svg+xml;base64,{data}">'
        f"<figcaption><b>Figure {number}.</b> {escape(caption)}</figcaption></figure>"
    )


@dataclass(frozen=True)
class Cell:
    """A number with its interval, shown small beside it."""

    text: str
    small: str = ""

    def html(self) -> str:
        """The cell's content."""
        small = f" <small>({escape(self.small)})</small>" if self.small else ""
        return escape(self.text) + small


def table(
    caption: str,
    head: Sequence[str],
    rows: Sequence[Sequence[str | Cell]],
    text: Sequence[int] = (0,),
    rules: Sequence[int] = (),
) -> str:
    """A table in the manner of a paper.

    Args:
        caption: plain text.
        head: names of the columns.
        rows: cells.
        text: columns set to the left.
        rules: rows with a thin rule above.
    """

    def line(cells: Sequence[str | Cell], tag: str, kind: str = "") -> str:
        found = []
        for k, cell in enumerate(cells):
            inner = cell.html() if isinstance(cell, Cell) else escape(cell)
            left = ' class="text"' if k in text else ""
            found.append(f"<{tag}{left}>{inner}</{tag}>")
        return f"<tr{kind}>" + "".join(found) + "</tr>"

    body = "\n".join(
        line(row, "td", ' class="rule"' if k in rules else "") for k, row in enumerate(rows)
    )
    return (
        f'<div class="wide"><table><caption>{escape(caption)}</caption>\n<thead>'
        f"{line(head, 'th')}</thead>\n<tbody>\n{body}\n</tbody></table></div>"
    )


def percent(rate: Proportion) -> Cell:
    """A share in percent with its interval."""
    if rate.value is None or rate.interval is None:
        return Cell(DASH)
    low, high = rate.interval
    return Cell(f"{100 * rate.value:.0f}", f"{100 * low:.0f}–{100 * high:.0f}")


def number(value: float | None, bounds: tuple[float, float] | None = None, digits: int = 2) -> Cell:
    """A number with its interval; a dash where it is undefined."""
    if value is None:
        return Cell(DASH)
    text = f"{value:.{digits}f}".replace("-", MINUS)
    if bounds is None:
        return Cell(text)
    joint = "–" if min(bounds) >= 0 else " to "
    return Cell(text, joint.join(f"{b:.{digits}f}" for b in bounds).replace("-", MINUS))


def name(group: str) -> str:
    """An object's name in a sentence or a table."""
    return group.replace("_", " ")
