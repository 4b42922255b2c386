"""What a user can choose about a trial, checked at the door."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from dataclasses import dataclass
from typing import Any

PAPER_TORQUE_FACTOR = 0.781  # Krug et al.: share of the data-sheet torque used in section IV-B
DATASHEET_TORQUE_LIMIT = (2.1, 1.4)  # [N m] spread and proximal joints, distal joints
PAPER_TORQUE_LIMIT = (
    round(DATASHEET_TORQUE_LIMIT[0] * PAPER_TORQUE_FACTOR, 4),
    round(DATASHEET_TORQUE_LIMIT[1] * PAPER_TORQUE_FACTOR, 4),
)

SENSORS = ("dsa", "ideal")
PADS = ("all", "distal")


class SettingsError(ValueError):
    """A setting that cannot be used; the message names it, what came and what would do."""


@dataclass(frozen=True)
class TrialSettings:
    """One trial's conditions; with a seed they decide it completely.

    Attributes:
        object: name of an object model (``sdh-sim objects`` lists them).
        torque_limit: motor torque limits [N m]: (spread and proximal joints, distal joints).
        sensor: ``dsa`` reads pressures through dead zone, clip and 12 bit; ``ideal`` does not.
        pads: pads whose readings the prediction uses: ``all`` six or the ``distal`` three.
        timestep: simulation step [s].
        pad_modulus: Young's modulus of the pad rubber [Pa].
        pad_thickness: thickness of the pad rubber [m].

    Raises:
        SettingsError: a value out of range.
    """

    object: str
    torque_limit: tuple[float, float] = PAPER_TORQUE_LIMIT
    sensor: str = "dsa"
    pads: str = "all"
    timestep: float = 0.002
    pad_modulus: float = 1.0e6
    pad_thickness: float = 3.0e-3

    def __post_init__(self) -> None:
        try:
            limit = tuple(float(t) for t in self.torque_limit)
        except (TypeError, ValueError):
            limit = ()
        if len(limit) != 2 or not all(math.isfinite(t) and 0.0 < t <= 100.0 for t in limit):
            raise SettingsError(
                f"torque_limit: got {self.torque_limit!r}; give two torques in N m, each above 0 "
                f"and at most 100, for the proximal and the distal joints "
                f"(the paper's: {PAPER_TORQUE_LIMIT[0]} {PAPER_TORQUE_LIMIT[1]})"
            )
        object.__setattr__(self, "torque_limit", limit)
        _choice("sensor", self.sensor, SENSORS)
        _choice("pads", self.pads, PADS)
        _range("timestep", self.timestep, 1e-4, 5e-3, "s")
        _range("pad_modulus", self.pad_modulus, 5e4, 5e7, "Pa")
        _range("pad_thickness", self.pad_thickness, 5e-4, 2e-2, "m")

    def to_dict(self) -> dict[str, Any]:
        """The settings as plain JSON values."""
        data = dataclasses.asdict(self)
        data["torque_limit"] = list(self.torque_limit)
        return data

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> TrialSettings:
        """Settings from ``to_dict``'s output; an unknown or missing key raises SettingsError."""
        known = {f.name for f in dataclasses.fields(cls)}
        unknown = sorted(set(data) - known)
        if unknown:
            raise SettingsError(
                f"unknown setting {unknown[0]!r}; known are {', '.join(sorted(known))}"
            )
        if "object" not in data:
            raise SettingsError("setting 'object' is missing")
        values = dict(data)
        if "torque_limit" in values:
            with contextlib.suppress(TypeError):  # the constructor names the fault
                values["torque_limit"] = tuple(values["torque_limit"])
        return cls(**values)


def _choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise SettingsError(f"{name}: got {value!r}; choose one of {', '.join(choices)}")


def _range(name: str, value: object, low: float, high: float, unit: str) -> None:
    if not isinstance(value, (int, float)) or not (low <= value <= high):
        raise SettingsError(f"{name}: got {value!r}; allowed is {low:g} to {high:g} {unit}")
