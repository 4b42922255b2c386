"""What the command line of ``lift`` asks for. Nothing heavy is imported: help reads this table."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sdh_sim.run_options import RunOptions, default_workers
from sdh_sim.setting_table import check, setting, settings_of
from sdh_sim.settings import TrialSettings

TRIALS, COPIES, SEED = 20, 1, 0  # of a run that says nothing else


@dataclass(frozen=True)
class LiftRequest:
    """What ``lift`` is asked for; what was left out is None or empty.

    Attributes:
        settings: fields of TrialSettings that were given, by name.
        options: how to run.

    Raises:
        SettingsError: no such preset.
    """

    # Text, since Path("") is the current folder: an empty variable in a script would fill it.
    out: str = field(
        metadata=setting("Folder of the run, for example runs/box.", placeholder="FOLDER")
    )
    object: tuple[str, ...] = field(
        default=(),
        metadata=setting(
            'Object to lift, or the folder of your own; give it again for more, or "all". See: '
            "sdh-sim objects"
        ),
    )
    trials: int | None = field(
        default=None,
        metadata=setting(
            "Trials per object; of each grasp, where they come from a file.",
            shown=f"{TRIALS}; {COPIES} of each grasp",
            allowed="at least 1",
        ),
    )
    seed: int | None = field(
        default=None,
        metadata=setting("Seed that decides every trial.", shown=f"{SEED}", allowed="at least 0"),
    )
    preset: str | None = field(
        default=None,
        metadata=setting(
            "paper: fingertip grasps until each object has the paper's share of stable and "
            "unstable ones. fast: a time step of 4 ms, to explore.",
            choices=("paper", "fast"),
        ),
    )
    metric: tuple[str, ...] = field(
        default=(),
        metadata=setting(
            "Metric of your own: module:function, file.py:function or an installed entry point; "
            "give it again for more."
        ),
    )
    settings: Mapping[str, Any] = field(default_factory=dict)
    options: RunOptions = field(default_factory=RunOptions)

    def __post_init__(self) -> None:
        check(self)

    @classmethod
    def from_command_line(cls, given: Mapping[str, Any]) -> LiftRequest:
        """The request of the options that were given, by name; raises SettingsError."""
        options = {"workers": default_workers(), **_part(RunOptions, given)}
        own = _part(cls, given)
        for name in ("object", "metric"):
            own[name] = tuple(own.get(name, ()))
        return cls(
            **own,
            settings=_part(TrialSettings, given),
            options=RunOptions(**options, command=shlex.join(["sdh-sim", *sys.argv[1:]])),
        )


def _part(table: type, given: Mapping[str, Any]) -> dict[str, Any]:
    options = {name for name, line in settings_of(table).items() if line.option}
    return {name: value for name, value in given.items() if name in options}
