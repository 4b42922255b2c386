"""What comes back of one trial that a worker ran."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdh_sim.records import TrialRow


@dataclass(frozen=True)
class JobResult:
    """What comes back of a job: a row, or the reason why there is none.

    Attributes:
        row: the finished row, or None.
        wall_seconds: time the trial took [s].
        diverged: state by name where the simulation diverged, else None.
        error: one line on what went wrong. Text, because an exception that cannot be unpickled
            would take the worker down.
        details: traceback, or what is known of a dead process.
        refused: it is not the trial's fault (a file could not be written, other versions): the run
            has to stop.
    """

    row: TrialRow | None
    wall_seconds: float = 0.0
    diverged: dict[str, np.ndarray] | None = None
    error: str = ""
    details: str = ""
    refused: bool = False
