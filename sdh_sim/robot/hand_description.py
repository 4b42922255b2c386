"""A hand as its folder describes it: motors, fingers, tactile pads, closings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from sdh_sim.errors import SettingsError
from sdh_sim.robot.closing import Closing, check_posture
from sdh_sim.robot.pads import Frame, Pad, TaxelArray
from sdh_sim.user_references import HandFolder


@dataclass(frozen=True)
class Motor:
    """One motor.

    Attributes:
        name: of the actuator in the model.
        group: motors of a group share a torque limit of the settings.
        rated: torque or force that it is built for [N m or N].
        speed: greatest [rad/s or m/s].
        closing_speed: of the fastest motor in a user's own closing [rad/s or m/s].
        span: least and greatest position [rad or m].
        finger: index of the finger whose closing ratio it follows.
        flexes: sense in which it bends a finger, +1 or -1; 0: it does not.
        kp, kv: gains of its servo instead of the model's [N m/rad or N/m; the same times s]; None:
            the model's.
    """

    name: str
    group: str
    rated: float
    speed: float
    closing_speed: float
    span: tuple[float, float]
    finger: int
    flexes: int
    kp: float | None = None
    kv: float | None = None


@dataclass(frozen=True)
class Coupling:
    """A joint that follows another, which the model leaves out.

    Attributes:
        joint: that follows.
        leader: that it follows.
        ratio: its position over the leader's.
    """

    joint: str
    leader: str
    ratio: float


@dataclass(frozen=True)
class JointDynamics:
    """What a model may lack that was made for another simulation.

    Attributes:
        damping: of the joint [N m s/rad or N s/m]; None: the model's.
        armature: inertia of what turns with it [kg m^2 or kg]; None: the model's.
        frictionloss: dry friction [N m or N]; None: the model's.
    """

    damping: float | None
    armature: float | None
    frictionloss: float | None


@dataclass(frozen=True)
class Finger:
    """Parts of the hand that the object stops together.

    Attributes:
        name: of the finger.
        bodies: that it begins with; what hangs on them belongs to it.
        stops: motors that count as stopped by the object when their torque says so, by index.
        tip: body at its end.
        tip_position: the end in the frame of that body (3,) [m].
        pad_ahead: how far its pad lies before the line to the tip [m].
    """

    name: str
    bodies: tuple[str, ...]
    stops: tuple[int, ...]
    tip: str
    tip_position: tuple[float, ...]
    pad_ahead: float


@dataclass(frozen=True)
class Reach:
    """Where random grasps put the hand with one closing.

    Attributes:
        centre: where the fingers meet, along the palm's x [m].
        depth: from the palm to the grasp centre along its z, at least and at most [m].
        precision_depth: the same for fingertip grasps; None: the closing makes none.
    """

    centre: float
    depth: tuple[float, float]
    precision_depth: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class Hand:
    """A hand.

    Attributes:
        name: of the hand.
        model: MJCF file.
        palm: body whose frame is the hand frame, z out of the palm.
        groups: names of the motors' groups, in the order of the setting ``torque_limit``.
        motors, fingers, pads: in the order of every array.
        closings: by name.
        reaches: of the closings that random grasps take, by name.
        joints: dynamics of joints instead of the model's, by name.
        couplings: of joints, which the model leaves out.
        palm_frame: where the palm is in another body; None: it is a body of the model.
        folder: reference to a user's folder; None: a built-in hand.
        made: model of a user's folder, to be copied; None: ``model`` is read.
    """

    name: str
    model: Path
    palm: str
    groups: tuple[str, ...]
    motors: tuple[Motor, ...]
    fingers: tuple[Finger, ...]
    pads: tuple[Pad, ...]
    closings: Mapping[str, Closing]
    reaches: Mapping[str, Reach]
    joints: Mapping[str, JointDynamics] = field(default_factory=dict)
    couplings: tuple[Coupling, ...] = ()
    palm_frame: Frame | None = None
    folder: HandFolder | None = None
    made: mujoco.MjSpec | None = None

    @cached_property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(motor.name for motor in self.motors)

    @cached_property
    def finger_names(self) -> tuple[str, ...]:
        """Names of the fingers."""
        return tuple(finger.name for finger in self.fingers)

    @cached_property
    def pad_names(self) -> tuple[str, ...]:
        """Names of the pads."""
        return tuple(pad.name for pad in self.pads)

    @cached_property
    def arrays(self) -> dict[str, TaxelArray]:
        """The kinds of tactile arrays, by name, in the order of the pads."""
        return {pad.array.kind: pad.array for pad in self.pads}

    @cached_property
    def pad_kinds(self) -> np.ndarray:
        """Of each pad, which of ``arrays`` it has, by place (pads,)."""
        kinds = list(self.arrays)
        return np.array([kinds.index(pad.array.kind) for pad in self.pads], dtype=np.int64)

    @cached_property
    def pad_offsets(self) -> np.ndarray:
        """Where each pad begins in the flat tactile vector, and its length at the end."""
        return np.cumsum([0, *(pad.array.live.size for pad in self.pads)])

    @property
    def tactile_size(self) -> int:
        """Length of the flat tactile vector: every place of every array, row by row."""
        return int(self.pad_offsets[-1])

    def by_kind(self, flat: np.ndarray) -> dict[str, np.ndarray]:
        """The flat tactile vector as an array (pads, rows, columns) for each kind."""
        found: dict[str, list[np.ndarray]] = {kind: [] for kind in self.arrays}
        for pad, start in zip(self.pads, self.pad_offsets[:-1], strict=True):
            values = flat[start : start + pad.array.live.size]
            found[pad.array.kind].append(values.reshape(pad.array.shape))
        return {kind: np.array(arrays) for kind, arrays in found.items()}

    def torque_limits(self, limit: Sequence[float]) -> np.ndarray:
        """Limits of the motors (n,) [N m or N] from those of the groups, in their order.

        Raises:
            SettingsError: not as many as there are groups.
        """
        if len(limit) != len(self.groups):
            raise SettingsError(
                f"torque_limit: got {len(limit)} for the hand {self.name}; give "
                f"{len(self.groups)}: {', '.join(self.groups)}"
            )
        of_group = dict(zip(self.groups, limit, strict=True))
        return np.array([of_group[motor.group] for motor in self.motors])

    def check(self, limit: Sequence[float], pads: str) -> None:
        """Raise SettingsError where settings do not fit the hand.

        Args:
            limit: of the groups of motors [N m or N]; empty: the rated ones.
            pads: ``all``, or the kind of array whose pads a prediction uses.
        """
        self.torque_limits(limit or self.rated_limits)
        if pads not in ("all", *self.arrays):
            raise SettingsError(
                f"pads: got {pads!r:.80}; the hand {self.name} has "
                f"{', '.join(('all', *self.arrays))}"
            )

    def group_limits(self, of_motors: Sequence[float] | np.ndarray) -> tuple[float, ...]:
        """Limits of the groups [N m or N] from those of the motors (n,)."""
        groups = [motor.group for motor in self.motors]
        return tuple(float(of_motors[groups.index(group)]) for group in self.groups)

    @cached_property
    def rated_limits(self) -> tuple[float, ...]:
        """Limits of the groups that the motors are built for [N m or N], the least of each."""
        return tuple(
            min(motor.rated for motor in self.motors if motor.group == group)
            for group in self.groups
        )

    def closing(self, name: str) -> Closing:
        """The closing of that name; raises SettingsError where there is none."""
        if name not in self.closings:
            raise SettingsError(
                f"preshape: got {name!r:.80}; choose one of {', '.join(self.closings)}"
            )
        return self.closings[name]

    def closing_between(self, open: object, closed: object) -> Closing:
        """The closing between two postures of a user's own.

        Args:
            open, closed: positions of the motors in their order (n,) [rad or m].

        Raises:
            SettingsError: not a finite number for each motor within its range, or no finger flexes.
        """
        ranges = np.array([motor.span for motor in self.motors])
        ends = [
            check_posture(what, given, self.motor_names, ranges)
            for what, given in (("open", open), ("closed", closed))
        ]
        travel = ends[1] - ends[0]
        squeezes = travel * [motor.flexes for motor in self.motors] > 0.0
        if not squeezes.any():
            raise SettingsError(
                "closed: no finger joint flexes between open and closed, so the hand would not "
                "grip; give a closed posture whose joints are bent further than the open one's"
            )
        speeds = np.array([motor.closing_speed for motor in self.motors])
        rate = 1.0 / float((np.abs(travel) / speeds).max())
        return Closing("", ends[0], travel, rate, squeezes, self.motor_fingers, ranges)

    @cached_property
    def joined_fingers(self) -> np.ndarray:
        """Which fingers a common motor stops, each with itself (fingers, fingers) bool."""
        stops = [set(finger.stops) for finger in self.fingers]
        joined = np.array([[not a.isdisjoint(b) for b in stops] for a in stops])
        return joined | np.eye(len(stops), dtype=bool)

    @cached_property
    def motor_fingers(self) -> np.ndarray:
        """Index of the finger whose closing ratio each motor follows (n,)."""
        return np.array([motor.finger for motor in self.motors])
