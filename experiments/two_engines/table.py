"""Tables beside a run, one row after the other as it is found; a stop spoils none of them."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sdh_sim.errors import RecordError

STRAIGHT = "straight"  # alignment of rows of MuJoCo itself with the hand lifted straight up
_LOGICAL = {"True": True, "False": False}


@dataclass(frozen=True)
class RowTable:
    """A CSV file in the folder of a run.

    Attributes:
        name: of the file.
        columns: kinds of their values, by name.
        key: columns that tell rows apart.
    """

    name: str
    columns: Mapping[str, type[str] | type[int] | type[float] | type[bool]]
    key: Sequence[str]

    def append(self, run: Path, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows; the file is begun where there is none, and a torn last line is taken off."""
        path = run / self.name
        whole = _whole_lines(path)
        with path.open("ab") as file:
            file.truncate(len(whole))
        with path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(self.columns), lineterminator="\n")
            if not whole:
                writer.writeheader()
            writer.writerows(rows)

    def read(self, run: Path) -> list[dict[str, Any]]:
        """All rows, of those with the same key the last.

        A line that was not written to its end is left out; no file is an empty table.

        Raises:
            RecordError: the file has other columns, or a line that this cannot have written.
        """
        found: dict[tuple[Any, ...], dict[str, Any]] = {}
        lines = csv.DictReader(_whole_lines(run / self.name).decode().splitlines())
        if lines.fieldnames is not None and list(lines.fieldnames) != list(self.columns):
            raise RecordError(
                f"{run / self.name} has other columns than this version writes: move it away, and "
                "it is made again"
            )
        for line in lines:
            try:
                row = {
                    name: _LOGICAL[line[name]] if kind is bool else kind(line[name])
                    for name, kind in self.columns.items()
                }
            except (KeyError, TypeError, ValueError):
                raise RecordError(
                    f"{run / self.name}, line {lines.line_num}: not a row of this table; take the "
                    "line out, and it is made again"
                ) from None
            found[tuple(row[name] for name in self.key)] = row
        return list(found.values())


def _whole_lines(path: Path) -> bytes:
    """What a file holds up to the end of its last whole line; nothing where there is none."""
    if not path.exists():
        return b""
    text = path.read_bytes()
    return text[: text.rfind(b"\n") + 1]


LABELS = RowTable(
    "two_engines.csv",
    {
        "trial": int, "object": str, "alignment": str, "success": bool, "failure": str,
        "displacement_mm": float, "rotation_deg": float, "q_sim": float, "q_sim_capped": bool,
        "seconds": float,
    },
    ("trial", "alignment"),
)  # fmt: skip
"""One row per trial and alignment."""
