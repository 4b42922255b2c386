"""Dots that each stand for one trial: drawn like any other, and found again in the finished figure.

The page lays a transparent mark over each of them, which says what trial it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sdh_sim.analysis.cases import Case
from sdh_sim.analysis.comparison import name_of
from sdh_sim.report.table_cells import MINUS, object_name

POINTS = 72.0  # an inch, as in the figures' SVG
MOST = 3000  # trials of a report whose dots answer; more would make its page too heavy


class Dot(NamedTuple):
    """Where a trial is drawn in a figure.

    Attributes:
        x, y: from the figure's upper left corner [points].
        case: number of the trial's ``Case``.
        metric: column that is drawn.
    """

    x: float
    y: float
    case: int
    metric: str


class TrialDots(Line2D):
    """Dots of some trials, one each; ``cases`` are their numbers."""

    def __init__(
        self, x: np.ndarray, y: np.ndarray, cases: Sequence[Case], metric: str, **style: Any
    ) -> None:
        given: dict[str, Any] = {"linestyle": ""} | style
        super().__init__(x, y, **given)
        assert len(cases) in (0, len(x)), "a dot without its trial"
        self.cases = [case.number for case in cases]
        self.metric = metric


def draw_trials(
    axes: Axes, x: np.ndarray, y: np.ndarray, cases: Sequence[Case], metric: str, **style: Any
) -> None:
    """Draw trials as dots.

    Args:
        axes: where.
        x, y: (n,) data.
        cases: the n trials; none where they are not known.
        metric: column that is drawn.
        style: of the dots.
    """
    axes.add_line(TrialDots(x, y, cases, metric, **style))
    axes.autoscale_view()


def answering(cases: Sequence[Case]) -> tuple[Case, ...]:
    """The trials whose dots answer: all with an outcome, or none if they are many."""
    return tuple(case for case in cases if case.usable) if len(cases) <= MOST else ()


def select(cases: Sequence[Case], chosen: np.ndarray) -> list[Case]:
    """Those of n trials that a mask (n,) chooses; none where they are not known."""
    return [case for case, wanted in zip(cases, chosen, strict=True) if wanted] if cases else []


def dots_of(figure: Figure) -> list[Dot]:
    """Every trial's dot in a figure that has been drawn, axes by axes, from left to right."""
    found = []
    scale, height = POINTS / figure.dpi, figure.get_figheight() * POINTS
    for axes in figure.axes:
        dots = []
        for line in axes.lines:
            if isinstance(line, TrialDots) and line.cases:
                data = np.column_stack(line.get_data())
                for (x, y), case in zip(axes.transData.transform(data), line.cases, strict=True):
                    dots.append(Dot(float(x * scale), float(height - y * scale), case, line.metric))
        found += sorted(dots, key=lambda dot: (round(dot.x, 1), round(dot.y, 1), dot.case))
    return found


def say(case: Case, metrics: Sequence[str]) -> str:
    """What a trial's dot says in a line: which it is, what was predicted and what came of it."""
    text = f"{object_name(case.object)}, trial {case.trial}, seed {case.seed}: "
    text += ", ".join(f"{name_of(m)} {value_text(case.scores[m])}" for m in metrics)
    if case.q_sim is not None:
        text += f", q_sim {'at least ' if case.capped else ''}{value_text(case.q_sim)}"
    return " ".join(f"{text}; {outcome(case)}".split())  # one line, whatever the object's name


def outcome(case: Case) -> str:
    """What became of a trial, in a word or two."""
    return "held" if case.success else case.failure.replace("_", " ")


def value_text(value: float | None) -> str:
    """A load [weights] to two digits behind the point; a word where there is none."""
    if value is None:
        return "none"
    return f"{value:.2f}".replace("-", MINUS).replace("inf", "∞")
