"""What a user can choose about a trial, checked at the door."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from dataclasses import dataclass
from typing import Any

from sdh_sim.errors import SettingsError
from sdh_sim.user_references import ObjectFolder, UserMetric, check_metrics, metrics_from, plain

PAPER_TORQUE_FACTOR = 0.781  # Krug et al.: share of the data-sheet torque used in section IV-B
DATASHEET_TORQUE_LIMIT = (2.1, 1.4)  # [N m] spread and proximal joints, distal joints
PAPER_TORQUE_LIMIT = (
    round(DATASHEET_TORQUE_LIMIT[0] * PAPER_TORQUE_FACTOR, 4),
    round(DATASHEET_TORQUE_LIMIT[1] * PAPER_TORQUE_FACTOR, 4),
)

SENSORS = ("dsa", "ideal")
PADS = ("all", "distal")
LOAD_TESTS = ("none", "gravity", "directions")
DISTURBANCES = ("none", "turn", "shake")
ARMS = ("servo", "rigid")
GRASPS = ("any", "precision")

CHOICES = {
    "sensor": SENSORS,
    "pads": PADS,
    "arm": ARMS,
    "grasps": GRASPS,
    "load_test": LOAD_TESTS,
    "disturbance": DISTURBANCES,
}
RANGES = {
    "timestep": (1e-4, 5e-3, "s"),
    "pad_modulus": (5e4, 5e7, "Pa"),
    "pad_thickness": (5e-4, 2e-2, "m"),
    "repeats": (0, 1000, ""),
    "repeat_position": (0.0, 0.1, "m"),
    "repeat_angle": (0.0, 1.0, "rad"),
    "repeat_friction": (0.0, 0.5, ""),
    "position_error": (0.0, 0.1, "m"),
    "angle_error": (0.0, 1.0, "rad"),
    "friction_error": (0.0, 0.5, ""),
    "mass_error": (0.0, 0.5, ""),
}


@dataclass(frozen=True)
class TrialSettings:
    """One trial's conditions; with a seed they decide it completely.

    Attributes:
        object: name of an object model (``sdh-sim objects`` lists them).
        torque_limit: motor torque limits [N m]: (spread and proximal joints, distal joints).
        sensor: ``dsa`` reads as the real arrays do, ``ideal`` the pressure itself.
        pads: pads whose readings the prediction uses: ``all`` six or the ``distal`` three.
        timestep: simulation step [s].
        pad_modulus: Young's modulus of the pad rubber [Pa].
        pad_thickness: thickness of the pad rubber [m].
        grasps: ``any``, or ``precision`` for fingertip grasps alone.
        arm: ``servo`` for the arm's own joint servos, ``rigid`` for a hundred times their
            stiffness.
        load_test: after the verdict scale the weight until the object gives way (``gravity``);
            ``directions`` tries forces and moments along the hand's axes too.
        disturbance: after the hold ``turn`` the wrist by 120 degrees either way, or ``shake`` it.
        repeats: perturbed copies of the trial that give a probability of success.
        repeat_position: standard deviation of the copies' hand position along each axis [m].
        repeat_angle: standard deviation of the copies' roll [rad].
        repeat_friction: relative standard deviation of the copies' friction.
        position_error: standard deviation of the tracked object's position along each axis [m], as
            the metrics see it.
        angle_error: standard deviation of its rotation about each axis [rad].
        friction_error: relative standard deviation of the friction that the metrics assume.
        mass_error: relative standard deviation of the mass that they assume.
        folder: of a user's object; None takes the object model of that name.
        metrics: users' metrics, beside the built-in ones.

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
    grasps: str = "any"
    arm: str = "servo"
    load_test: str = "none"
    disturbance: str = "none"
    repeats: int = 0
    repeat_position: float = 0.002
    repeat_angle: float = 0.02
    repeat_friction: float = 0.05
    position_error: float = 0.0
    angle_error: float = 0.0
    friction_error: float = 0.0
    mass_error: float = 0.0
    folder: ObjectFolder | None = None
    metrics: tuple[UserMetric, ...] = ()

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
        for name, choices in CHOICES.items():
            _choice(name, getattr(self, name), choices)
        for name, (low, high, unit) in RANGES.items():
            _range(name, getattr(self, name), low, high, unit)
        if isinstance(self.repeats, bool) or not isinstance(self.repeats, int):
            raise SettingsError(f"repeats: got {self.repeats!r}; give a whole number, 0 to 1000")
        if self.folder is not None and not isinstance(self.folder, ObjectFolder):
            raise SettingsError(f"folder: got {self.folder!r:.80}; expected an ObjectFolder")
        check_metrics(self.metrics)

    def to_dict(self) -> dict[str, Any]:
        """The settings as plain JSON values."""
        data = dataclasses.asdict(self)
        data["torque_limit"] = list(self.torque_limit)
        data |= {"folder": plain(self.folder), "metrics": plain(self.metrics)}
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
        if values.get("folder") is not None:
            values["folder"] = ObjectFolder.from_dict(values["folder"])
        if "metrics" in values:
            values["metrics"] = metrics_from(values["metrics"])
        return cls(**values)


def _choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise SettingsError(f"{name}: got {value!r}; choose one of {', '.join(choices)}")


def _range(name: str, value: object, low: float, high: float, unit: str) -> None:
    if not isinstance(value, (int, float)) or not (low <= value <= high):
        allowed = f"{low:g} to {high:g} {unit}".rstrip()
        raise SettingsError(f"{name}: got {value!r}; allowed is {allowed}")
