"""The page Contributing is ``CONTRIBUTING.md``, which lies where people look for it.

A hook of MkDocs: it puts the text into the page and makes its links relative to ``docs``.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

_SOURCE = Path(__file__).resolve().parents[2] / "CONTRIBUTING.md"


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """The text of a page; that of the page Contributing comes from the file."""
    if page.file.src_uri != "contributing.md":
        return markdown
    return re.sub(r"\]\(docs/", "](", _SOURCE.read_text(encoding="utf-8"))
