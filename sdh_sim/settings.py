"""What a user can choose about a trial: the table of its settings, checked when one is made."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

from sdh_sim.errors import SettingsError
from sdh_sim.setting_table import check, setting
from sdh_sim.user_references import (
    NAME,
    GraspSet,
    HandFolder,
    ObjectFolder,
    UserMetric,
    check_metrics,
    metrics_from,
    plain,
)

PAPER_TORQUE_FACTOR = 0.781  # Krug et al.: share of the data-sheet torque used in section IV-B
DATASHEET_TORQUE_LIMIT = (2.1, 1.4)  # [N m] spread and proximal joints, distal joints
PAPER_TORQUE_LIMIT = (
    round(DATASHEET_TORQUE_LIMIT[0] * PAPER_TORQUE_FACTOR, 4),
    round(DATASHEET_TORQUE_LIMIT[1] * PAPER_TORQUE_FACTOR, 4),
)
GRAVITY_DIRECTIONS = ("-z", "+z", "-x", "+x", "-y", "+y")
RANDOM_GRASPS, FROM_FILE = ("any", "precision"), "file"  # where grasps come from
LARGEST_TORQUE = 1000.0  # that a motor may have [N m or N]
TAXEL_THRESHOLD = 0.1  # as much as crosstalk passes on to each neighbour of a taxel
DEFAULT_HAND = "schunk_sdh2"


@dataclass(frozen=True)
class TrialSettings:
    """One trial's conditions; with a seed they decide it completely.

    Each field says what it means, what is allowed and its unit; the page Settings of the
    documentation, ``sdh-sim lift --help`` and the checks are made from these lines.

    Raises:
        SettingsError: a value that is not allowed.
    """

    object: str = field(
        metadata=setting("Name of the object.", allowed="see `sdh-sim objects`", option=False)
    )
    hand: str = field(
        default=DEFAULT_HAND,
        metadata=setting(
            "Name of the hand, or the folder of your own.",
            allowed="schunk_sdh2, parallel_jaw, or a path (in Python: its name, with hand_folder)",
            placeholder="HAND",
        ),
    )
    torque_limit: tuple[float, ...] = field(
        default=(),
        metadata=setting(
            "Motor limits of each group of the hand's motors (SDH-2: spread and proximal joints, "
            "distal joints).",
            unit="N m or N",
            allowed=f"each above 0 and at most {LARGEST_TORQUE:g}",
            shown=f"{' '.join(map(str, PAPER_TORQUE_LIMIT))} on the SDH-2, as the paper; rated "
            "ones on others",
            placeholder="LIMIT ...",
        ),
    )
    drive: str = field(
        default="yield",
        metadata=setting(
            "What a load that pushes a joint back meets. yield: the motor at its limit; hold: the "
            "friction of the gear as well; lock: a self-locking gear, which never gives way. All "
            "push with the same limit.",
            choices=("yield", "hold", "lock"),
        ),
    )
    gear_friction: float = field(
        default=0.25,
        metadata=setting(
            "With --drive hold, by how much more than its limit a motor bears, as a share of it: "
            "the friction of its gear.",
            span=(0.0, 2.0),
        ),
    )
    sensor: str = field(
        default="dsa",
        metadata=setting(
            "dsa: as the real arrays read; ideal: the pressure itself.", choices=("dsa", "ideal")
        ),
    )
    pads: str = field(
        default="all",
        metadata=setting(
            "Pads whose readings the prediction uses: all, or those with one kind of array (SDH-2: "
            "proximal, distal).",
            allowed="all, or a kind of the hand's arrays",
        ),
    )
    taxel_threshold: float = field(
        default=TAXEL_THRESHOLD,
        metadata=setting(
            "Share of its pad's largest reading that a taxel must exceed to count as in contact; "
            "what reads less is taken for crosstalk. 0: every reading counts.",
            span=(0.0, 0.9),
        ),
    )
    timestep: float = field(
        default=0.002, metadata=setting("Simulation step.", span=(1e-4, 5e-3), unit="s")
    )
    pad_modulus: float = field(
        default=1.0e6,
        metadata=setting("Young's modulus of the pads' rubber.", span=(5e4, 5e7), unit="Pa"),
    )
    pad_thickness: float = field(
        default=3.0e-3,
        metadata=setting(
            "Thickness of the pads' rubber.", span=(5e-4, 2e-2), unit="m", option=False
        ),
    )
    grasps: str = field(
        default="any",
        metadata=setting(
            "Grasps: random ones, any or precision (fingertips alone), or those of a file.",
            allowed="any, precision, or the path of a file (in Python: file, with grasp_set)",
        ),
    )
    arm: str = field(
        default="servo",
        metadata=setting(
            "servo: the arm's own joint servos; rigid: a hundred times their stiffness, "
            "so that nothing moves it; none: the hand floats on a stiff base and reaches all.",
            choices=("servo", "rigid", "none"),
        ),
    )
    support: str = field(
        default="table",
        metadata=setting(
            "What the object rests on before the lift: the table; none: it is held where it is "
            "until the fingers have closed, and its weight then acts along --gravity.",
            choices=("table", "none"),
        ),
    )
    gravity: str = field(
        default="-z",
        metadata=setting(
            "With --support none, direction of the weight in the object's frame; six: along each "
            "axis either way, one after the other, and the grasp must hold all.",
            choices=(*GRAVITY_DIRECTIONS, "six"),
        ),
    )
    lift_off: bool = field(
        default=False,
        metadata=setting(
            "Take a second snapshot when the object has left the table, with all metrics (columns "
            "liftoff_...).",
        ),
    )
    settle: str = field(
        default="none",
        metadata=setting(
            "Predict from the snapshot where the grasp settles when the table lets go, and whether "
            "it holds there (columns settled_... and q_settled); metrics: rate it there, too.",
            choices=("none", "verdict", "metrics"),
        ),
    )
    load_test: str = field(
        default="none",
        metadata=setting(
            "After the verdict load each grasp until it gives way: gravity (column q_sim), or "
            "directions for forces and moments along the hand's axes too.",
            choices=("none", "gravity", "directions"),
        ),
    )
    disturbance: str = field(
        default="none",
        metadata=setting(
            "After the hold turn the wrist 120 degrees either way, or shake the hand.",
            choices=("none", "turn", "shake"),
        ),
    )
    repeats: int = field(
        default=0,
        metadata=setting(
            "Perturbed copies of each trial, for a probability of success.", span=(0, 1000)
        ),
    )
    repeat_position: float = field(
        default=0.002,
        metadata=setting(
            "Position noise of the copies: standard deviation of the hand along each axis.",
            span=(0.0, 0.1),
            unit="m",
        ),
    )
    repeat_angle: float = field(
        default=0.02,
        metadata=setting(
            "Roll noise of the copies: standard deviation.", span=(0.0, 1.0), unit="rad"
        ),
    )
    repeat_friction: float = field(
        default=0.05,
        metadata=setting(
            "Friction noise of the copies: relative standard deviation.", span=(0.0, 0.5)
        ),
    )
    position_error: float = field(
        default=0.0,
        metadata=setting(
            "Error of the object's tracked position, as the metrics see it: standard deviation "
            "along each axis.",
            span=(0.0, 0.1),
            unit="m",
        ),
    )
    angle_error: float = field(
        default=0.0,
        metadata=setting(
            "Error of its tracked rotation: standard deviation about each axis.",
            span=(0.0, 1.0),
            unit="rad",
        ),
    )
    friction_error: float = field(
        default=0.0,
        metadata=setting(
            "Relative error of the friction that the metrics assume: standard deviation.",
            span=(0.0, 0.5),
        ),
    )
    mass_error: float = field(
        default=0.0,
        metadata=setting(
            "Relative error of the mass that the metrics assume: standard deviation.",
            span=(0.0, 0.5),
        ),
    )
    touch: bool = field(
        default=False,
        metadata=setting(
            "Correct the tracked pose by touch before any metric sees it; needs --position-error "
            "and --angle-error, what the tracker is known to be off by.",
        ),
    )
    folder: ObjectFolder | None = field(
        default=None,
        metadata=setting(
            "Folder of a user's own object; None takes the built-in one of that name.",
            option=False,
        ),
    )
    hand_folder: HandFolder | None = field(
        default=None,
        metadata=setting(
            "Folder of a user's own hand; None takes the built-in one of that name.", option=False
        ),
    )
    grasp_set: GraspSet | None = field(
        default=None,
        metadata=setting("File that the grasps come from; None: they are random.", option=False),
    )
    metrics: tuple[UserMetric, ...] = field(
        default=(),
        metadata=setting("Users' own metrics, beside the built-in ones.", option=False),
    )

    def __post_init__(self) -> None:
        try:
            limit = tuple(float(t) for t in self.torque_limit)
        except (TypeError, ValueError):
            limit = (math.nan,)
        given = self.torque_limit
        if isinstance(given, list):  # as the command line has it
            given = tuple(given)
        sdh2 = self.hand == DEFAULT_HAND and self.hand_folder is None
        if sdh2 and not limit:
            limit = PAPER_TORQUE_LIMIT
        fits = all(math.isfinite(t) and 0.0 < t <= LARGEST_TORQUE for t in limit)
        if not fits or (sdh2 and len(limit) != 2):
            raise SettingsError(
                f"torque_limit: got {given!r}; give two torques in N m, each above 0 "
                f"and at most {LARGEST_TORQUE:g}, for the proximal and the distal joints "
                f"(the paper's: {PAPER_TORQUE_LIMIT[0]} {PAPER_TORQUE_LIMIT[1]}); for other hands "
                "one for each group of motors"
            )
        if not isinstance(self.hand, str) or not NAME.fullmatch(self.hand):
            raise SettingsError(f"hand: got {self.hand!r:.80}; give the name of a hand")
        if not isinstance(self.pads, str) or not NAME.fullmatch(self.pads):
            raise SettingsError(
                f"pads: got {self.pads!r:.80}; give all, or a kind of the hand's arrays"
            )
        object.__setattr__(self, "torque_limit", limit)
        check(self)
        if self.folder is not None and not isinstance(self.folder, ObjectFolder):
            raise SettingsError(f"folder: got {self.folder!r:.80}; expected an ObjectFolder")
        if self.hand_folder is not None and not isinstance(self.hand_folder, HandFolder):
            raise SettingsError(f"hand_folder: got {self.hand_folder!r:.80}; expected a HandFolder")
        self._check_grasps()
        check_metrics(self.metrics)
        if self.touch and not (self.position_error > 0.0 and self.angle_error > 0.0):
            raise SettingsError(
                f"touch: got {self.touch!r} with position_error {self.position_error:g} and "
                f"angle_error {self.angle_error:g}; a pose that is exact needs no correction: give "
                "both errors above 0"
            )
        if self.settle != "none" and self.drive != "yield":
            raise SettingsError(
                f"settle: got {self.settle!r} with drive {self.drive!r}; the prediction takes "
                "motors that yield at their limit: set settle to none, or drive to yield"
            )
        if self.support == "table" and self.gravity != "-z":
            raise SettingsError(
                f"gravity: got {self.gravity!r}; on the table the weight acts downward, set "
                "support to none for another direction"
            )
        lifted = {"disturbance": self.disturbance != "none", "lift_off": self.lift_off}
        lifted["load_test"] = self.load_test == "directions"
        if self.support == "none" and any(lifted.values()):
            name = next(name for name, asked in lifted.items() if asked)
            raise SettingsError(
                f"{name}: got {getattr(self, name)!r}; with support none the weight itself acts in "
                "any direction and nothing is lifted: take gravity or none for the load test, none "
                "for the disturbance, and no lift-off"
            )

    def _check_grasps(self) -> None:
        if self.grasp_set is not None and not isinstance(self.grasp_set, GraspSet):
            raise SettingsError(f"grasp_set: got {self.grasp_set!r:.80}; expected a GraspSet")
        if self.grasps not in (*RANDOM_GRASPS, FROM_FILE):
            raise SettingsError(
                f"grasps: got {self.grasps!r:.200}; choose {' or '.join(RANDOM_GRASPS)}, or give "
                "the path of a file of grasps"
            )
        if (self.grasps == FROM_FILE) != (self.grasp_set is not None):
            raise SettingsError(
                f"grasp_set: got {self.grasp_set!r:.80} with grasps {self.grasps!r}; {FROM_FILE!r} "
                "needs one, and nothing else takes one"
            )

    def to_dict(self) -> dict[str, Any]:
        """The settings as plain JSON values."""
        data = dataclasses.asdict(self)
        data["torque_limit"] = list(self.torque_limit)
        data |= {"folder": plain(self.folder), "metrics": plain(self.metrics)}
        data |= {"grasp_set": plain(self.grasp_set), "hand_folder": plain(self.hand_folder)}
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
        if values.get("hand_folder") is not None:
            values["hand_folder"] = HandFolder.from_dict(values["hand_folder"])
        if values.get("grasp_set") is not None:
            values["grasp_set"] = GraspSet.from_dict(values["grasp_set"])
        if "metrics" in values:
            values["metrics"] = metrics_from(values["metrics"])
        return cls(**values)
