"""Equations become MathML when the site is built, so that no page fetches a script to show them.

A hook of MkDocs: ``pymdownx.arithmatex`` marks the equations, this turns their LaTeX into MathML.
"""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert

_MARKED = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(content: str, **_: Any) -> str:
    """The page with every marked equation as MathML."""
    return _MARKED.sub(_mathml, content)


def _mathml(found: re.Match[str]) -> str:
    tag, kind, latex = found.groups()
    display = "block" if kind == "[" else "inline"
    equation = convert(html.unescape(latex).strip(), display=display)
    return f'<{tag} class="equation">{equation}</{tag}>'
