"""Lines of the report: a quantity by its protocol, in closed form, simulated, and measured."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rich.table import Table

UNITS = {
    "finger_strength": "N",
    "grasp_strength": "N",
    "slip_resistance": "N",
    "touch_sensitivity": "N",
}
"""Unit of each protocol's quantities."""
TITLES = {
    "finger_strength": "Finger strength: greatest force of a fingertip on a load cell",
    "grasp_strength": "Grasp strength: force between the halves of a cylinder",
    "slip_resistance": "Slip resistance: pull along the axis of a cylinder",
    "touch_sensitivity": "Touch sensitivity: force at the first frame with a reading",
}


@dataclass(frozen=True)
class Line:
    """One quantity of one specimen.

    Attributes:
        protocol: key of UNITS.
        specimen: its name.
        condition: what was done; with the protocol, the key of a measured value.
        closed: what theory gives; NaN where it says nothing.
        simulated: what came out; NaN where the test could not be done.
        tolerance: relative, between them; NaN where none is claimed.
        note: why a test could not be done, or what the closed form is.
    """

    protocol: str
    specimen: str
    condition: str
    closed: float
    simulated: float
    tolerance: float = math.nan
    note: str = ""

    @property
    def deviation(self) -> float:
        """Simulated over closed, less 1."""
        return self.simulated / self.closed - 1.0 if abs(self.closed) > 1e-6 else math.nan

    @property
    def agrees(self) -> bool | None:
        """Whether both agree within the tolerance; None where none is claimed."""
        if math.isnan(self.tolerance) or math.isnan(self.deviation):
            return None
        return abs(self.deviation) <= self.tolerance


HEADS = ("protocol", "specimen", "condition", "unit", "closed_form", "simulated", "deviation",
         "tolerance", "measured", "note")  # fmt: skip


def csv_of(lines: Iterable[Line], measured: Mapping[tuple[str, str], float]) -> str:
    """All lines as a table of values separated by commas."""
    rows = [",".join(HEADS)]
    for x in lines:
        value = measured.get((x.protocol, x.condition), math.nan)
        numbers = (x.closed, x.simulated, x.deviation, x.tolerance, value)
        texts = ["" if math.isnan(v) else f"{v:.6g}" for v in numbers]
        words = [x.protocol, x.specimen, x.condition, UNITS[x.protocol]]
        rows.append(",".join(f'"{w}"' if "," in w else w for w in [*words, *texts, x.note]))
    return "\n".join(rows) + "\n"


def tables_of(lines: Iterable[Line], measured: Mapping[tuple[str, str], float]) -> list[Table]:
    """A table for each protocol: a line for each condition of each specimen."""
    lines, found = list(lines), []
    for protocol, title in TITLES.items():
        own = [x for x in lines if x.protocol == protocol]
        if not own:
            continue
        table = Table(title=f"{title} [{UNITS[protocol]}]", title_justify="left")
        for head in ("hand", "condition", "closed form", "simulated", "deviation %"):
            table.add_column(head, justify="left" if head in ("hand", "condition") else "right")
        if measured:
            table.add_column("measured", justify="right")
            table.add_column("measured / simulated", justify="right")
        table.add_column("note")
        last = ""
        for x in own:
            value = measured.get((x.protocol, x.condition), math.nan)
            beside = (_text(value), _text(value / x.simulated)) if measured else ()
            mark = "" if x.agrees is not False else " !"
            table.add_row(
                x.specimen if x.specimen != last else "", x.condition, _text(x.closed),
                _text(x.simulated), _text(100.0 * x.deviation, 1) + mark, *beside, x.note,
            )  # fmt: skip
            last = x.specimen
        found.append(table)
    return found


def _text(value: float, digits: int = 2) -> str:
    if math.isnan(value):
        return "-"
    return f"{0.0 if abs(value) < 0.5 * 10.0**-digits else value:.{digits}f}"
