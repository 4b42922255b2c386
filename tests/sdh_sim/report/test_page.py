"""The page and its tables: parts as HTML, text escaped, numbers as they are to be read."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser

import pytest

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.report.page import Bullets, Paragraph, Picture, Section, Table, render_page
from sdh_sim.report.table_cells import TableCell, number, object_name, p_value, percent, threshold

HOSTILE = """<script>alert("x")</script> & 'y' {{ 7 * 7 }} </style>"""


class Outline(HTMLParser):
    """The tags of a page with their attributes, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.texts.append(data)


def part(page: str) -> str:
    """What lies below the only heading of a page."""
    found = re.search(r"</h2>\n(.*)\n</section>", page, re.DOTALL)
    assert found is not None
    return found[1]


def test_a_page_is_a_whole_document_with_its_style_sheet():
    page = render_page("Title", "Lead", [Section("One", []), Section("Two", [])])
    assert page.startswith('<!doctype html>\n<html lang="en">\n')
    assert page.endswith("</html>\n")
    assert '<h1>Title</h1>\n<p class="lead">Lead</p>\n' in page
    assert re.findall("<h2>(.*)</h2>", page) == ["One", "Two"]
    (style,) = re.findall("<style>(.*?)</style>", page, re.DOTALL)
    assert '"Bitstream Charter"' in style  # the style sheet's own quotes stay
    assert style.count("{") == style.count("}") > 15


def test_sentences_and_figures():
    page = render_page("", "", [Section("", [Paragraph("a"), Bullets(["b", "c"])])])
    assert part(page) == '<p>a</p>\n<ul class="key">\n<li>b</li>\n<li>c</li>\n</ul>'
    page = render_page("", "", [Section("", [Picture(b"<svg/>", 3, "What it shows.")])])
    encoded = base64.b64encode(b"<svg/>").decode()
    assert f'alt="What it shows." src="data:image/svg+xml;base64,{encoded}"' in page
    assert "<figcaption><b>Figure 3.</b> What it shows.</figcaption>" in page


def test_a_table_cell_by_cell():
    rows = [["box", "q*", "1"], ["", "ε", TableCell("2", "1–3")]]
    table = Table("Caption.", ["object", "metric", "n"], rows, (0, 1), ruled_rows=[1])
    assert part(render_page("", "", [Section("", [table])])).splitlines() == [
        '<div class="wide"><table>',
        "<caption>Caption.</caption>",
        '<thead><tr><th scope="col" class="text">object</th>'
        '<th scope="col" class="text">metric</th><th scope="col">n</th></tr></thead>',
        "<tbody>",
        '<tr><td class="text">box</td><td class="text">q*</td><td>1</td></tr>',
        '<tr class="rule"><td class="text"></td><td class="text">ε</td>'
        "<td>2 <small>(1–3)</small></td></tr>",
        "</tbody>",
        "</table></div>",
    ]


def test_whatever_the_page_is_given_is_text():
    parts = [
        Paragraph(HOSTILE),
        Bullets([HOSTILE]),
        Picture(b"<svg/>", 1, HOSTILE),
        Table(HOSTILE, [HOSTILE], [[HOSTILE], [TableCell(HOSTILE, HOSTILE)]]),
    ]
    page = render_page(HOSTILE, HOSTILE, [Section(HOSTILE, parts)])
    harmless = render_page("", "", [Section("", [
        Paragraph(""), Bullets([""]), Picture(b"<svg/>", 1, ""),
        Table("", [""], [[""], [TableCell("", "x")]]),
    ])])  # fmt: skip
    outline = Outline(page)
    assert [tag for tag, _ in outline.tags] == [tag for tag, _ in Outline(harmless).tags]
    (alt,) = (attributes["alt"] for tag, attributes in outline.tags if tag == "img")
    assert alt == HOSTILE
    # Title, heading, lead, section, paragraph, bullet, two captions, head, three times in cells.
    assert "".join(outline.texts).count(HOSTILE) == 12


@pytest.mark.parametrize(
    ("cell", "text", "detail"),
    [
        (percent(Proportion(1, 2)), "50", "9–91"),
        (percent(Proportion(0, 0)), "–", ""),
        (number(None, (0.0, 1.0)), "–", ""),
        (number(0.5), "0.50", ""),
        (number(-0.25, (-0.5, 0.125), 3), "−0.250", "−0.500 to 0.125"),
        (number(0.75, (0.5, 1.0)), "0.75", "0.50–1.00"),
        (threshold(1.23456, 0.0, 12.0), "1.23", "0–12"),
        (threshold(0.5, float("-inf"), 1.0), "0.5", "−∞ to 1"),
    ],
)
def test_numbers_in_tables(cell, text, detail):
    assert cell == TableCell(text, detail)


def test_names_and_p_values():
    assert object_name("oval_bottle") == "oval bottle"
    assert [p_value(p) for p in (1.0, 0.0123, 0.00012)] == ["1.000", "0.012", "1.2e−04"]
