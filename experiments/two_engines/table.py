"""The table beside the run's: one row per trial and alignment, written as they are found."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

NAME = "two_engines.csv"
STRAIGHT = "straight"  # alignment of rows of MuJoCo itself with the hand lifted straight up
COLUMNS: tuple[str, ...] = (
    "trial", "object", "alignment", "success", "failure", "displacement_mm", "rotation_deg",
    "q_sim", "q_sim_capped", "seconds",
)  # fmt: skip
_LOGICAL, _WHOLE = ("success", "q_sim_capped"), ("trial",)
_TEXT = ("object", "alignment", "failure")


def append(path: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Add rows to the table, which is begun where there is none; a torn last line is ended."""
    new = not path.exists() or path.stat().st_size == 0
    torn = not new and not path.read_bytes().endswith(b"\n")
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
        if torn:
            file.write("\n")
        writer.writerows(rows)


def read(path: Path) -> list[dict[str, Any]]:
    """Rows of the table, the last one where a trial and alignment has several.

    Lines that were not written to their end are left out; no table is an empty one.
    """
    if not path.exists():
        return []
    found: dict[tuple[int, str], dict[str, Any]] = {}
    with path.open(newline="", encoding="utf-8") as file:
        for line in csv.DictReader(file):
            row = _parsed(line)
            if row is not None:
                found[row["trial"], row["alignment"]] = row
    return list(found.values())


def _parsed(line: Mapping[str, str | None]) -> dict[str, Any] | None:
    row: dict[str, Any] = {}
    try:
        for name in COLUMNS:
            text = line[name]
            if text is None:
                return None
            if name in _LOGICAL:
                row[name] = {"True": True, "False": False}[text]
            elif name in _TEXT:
                row[name] = text
            else:
                row[name] = int(text) if name in _WHOLE else float(text)
    except (KeyError, ValueError):
        return None
    return row
