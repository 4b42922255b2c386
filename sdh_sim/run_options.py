"""How a run is carried out: the table of its options, checked when one is made.

Nothing heavy is imported here: the command line reads this table for its help.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field

from sdh_sim.errors import SettingsError
from sdh_sim.setting_table import check, setting


def default_workers() -> int:
    """One worker per core that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class RunOptions:
    """How a run is carried out; none of it changes a byte of the table.

    Each field says what it means and what is allowed; the page Settings of the documentation,
    ``sdh-sim lift --help`` and the checks are made from these lines.

    Raises:
        SettingsError: a value that is not allowed, or two that exclude each other.
    """

    workers: int = field(
        default=1,
        metadata=setting("Worker processes.", span=(1, math.inf), shown="one per core"),
    )
    rerun: str = field(
        default="none",
        metadata=setting(
            "Trials that leave a rerun recording: all, failures or none.",
            choices=("all", "failures", "none"),
        ),
    )
    resume: bool = field(
        default=False,
        metadata=setting(
            "Continue the run in --out with its own settings; --trials may be raised."
        ),
    )
    overwrite: bool = field(default=False, metadata=setting("Replace the run in --out."))
    retry_errors: bool = field(
        default=False,
        metadata=setting("With --resume: run trials again that ended as error."),
    )
    executor: str = field(
        default="processes",
        metadata=setting(
            "What runs the trials: processes or dask (see also --scheduler).",
            choices=("processes", "dask"),
        ),
    )
    scheduler: str | None = field(
        default=None,
        metadata=setting(
            "Address or scheduler file of a running Dask cluster.",
            shown="a cluster on this machine",
        ),
    )
    trial_timeout: float = field(
        default=3600.0,
        metadata=setting(
            "Longest time that a trial may take before its process is ended: it is tried once "
            "more, then it is an error. Waiting, the start of a process and the compilation of "
            "the metrics do not count; inf: no limit.",
            span=(1.0, math.inf),
            unit="s",
        ),
    )
    save_every: float = field(
        default=5.0,
        metadata=setting(
            "Shortest time between two writes of the table while the run goes on.",
            unit="s",
            option=False,
        ),
    )
    command: str = field(
        default="", metadata=setting("Command line to keep in run.json.", option=False)
    )

    def __post_init__(self) -> None:
        check(self)
        if self.scheduler is not None and self.executor != "dask":
            raise SettingsError(f"scheduler: got {self.scheduler!r}; it needs --executor dask")
        if self.resume and self.overwrite:
            raise SettingsError("--resume and --overwrite exclude each other; give one of them")
        if self.retry_errors and not self.resume:
            raise SettingsError("--retry-errors continues a run; give --resume with it")
