"""Numbers and names as the tables show them."""

from __future__ import annotations

from dataclasses import dataclass

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.thresholds import LOWEST

DASH = "–"
MINUS = "−"


@dataclass(frozen=True)
class TableCell:
    """A text and, small in brackets behind it, a detail such as an interval."""

    text: str
    detail: str = ""


def percent(proportion: Proportion) -> TableCell:
    """A proportion in percent with its interval; a dash where it is undefined."""
    if proportion.value is None or proportion.interval is None:
        return TableCell(DASH)
    low, high = proportion.interval
    return TableCell(f"{100 * proportion.value:.0f}", f"{100 * low:.0f}–{100 * high:.0f}")


def number(
    value: float | None, bounds: tuple[float, float] | None = None, digits: int = 2
) -> TableCell:
    """A number with its interval; a dash where it is undefined."""
    if value is None:
        return TableCell(DASH)
    text = f"{value:.{digits}f}".replace("-", MINUS)
    if bounds is None:
        return TableCell(text)
    joint = "–" if min(bounds) >= 0 else " to "
    return TableCell(text, joint.join(f"{b:.{digits}f}" for b in bounds).replace("-", MINUS))


def threshold(value: float, low: float, high: float) -> TableCell:
    """A threshold and its range."""
    joint = "–" if low >= 0 else " to "
    return TableCell(_edge(value), f"{_edge(low)}{joint}{_edge(high)}")


def _edge(value: float) -> str:
    if value <= LOWEST:  # every score exceeds it, or every one but -inf
        return f"{MINUS}∞"
    return f"{value:.3g}".replace("-", MINUS).replace("inf", "∞")


def signed(value: float, digits: int = 3) -> str:
    """A number with its sign."""
    return f"{value:+.{digits}f}".replace("-", MINUS)


def p_value(p: float) -> str:
    """A test's p-value, small ones by their power of ten."""
    return f"{p:.3f}" if p >= 0.001 else f"{p:.1e}".replace("-", MINUS)


def object_name(group: str) -> str:
    """An object's name, or ``overall``, in a sentence or a table."""
    return group.replace("_", " ")
