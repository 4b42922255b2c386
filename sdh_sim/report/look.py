"""How to look at a trial of a report: the command, and a picture where one is wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sdh_sim.analysis.cases import Case


@dataclass(frozen=True)
class Look:
    """What whoever asks for a report knows of its runs.

    Attributes:
        command: shows a trial; empty where it is known of no run.
        names: of the runs, by ``Case.source``.
        photograph: a trial as JPEG, or why there is none, in one line.
        photographs: how many of the worst mispredictions get one.
        hint: how to get pictures, a sentence; empty where they come unasked.
    """

    command: Callable[[Case], str] = lambda case: ""
    names: tuple[str, ...] = ()
    photograph: Callable[[Case], bytes | str] | None = None
    photographs: int = 0
    hint: str = ""
