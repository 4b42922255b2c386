"""One trial's row, its columns declared here and only here.

What makes a row sets attributes, so that a misspelt column is found by a type checker; what reads
tables may also treat a row as a mapping from column name to value. Users' metrics add columns of
their own (``user_columns``).
"""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
import pyarrow as pa

from sdh_sim.records.column import Column

FAILURES = (
    *("none", "no_contact", "dropped", "slipped", "rotated"),
    *("unstable_simulation", "error", "infeasible"),
)
"""How a trial ended. ``none`` is a success. ``infeasible`` (a given grasp is out of reach or in
collision), ``unstable_simulation`` (the simulation diverged) and ``error`` (the trial raised, or
its process died, twice) tell nothing about the grasp: comparisons leave them out and count them.
An ``error`` row has no values but trial, object and seed."""
NO_TRUTH = ("unstable_simulation", "error", "infeasible")
"""Failures that tell nothing about the grasp."""
TACTILE_UNIT = "kPa"

_INT, _REAL, _SINGLE = pa.int64(), pa.float64(), pa.float32()
_TEXT, _FLAG = pa.string(), pa.bool_()


def _column(
    type: pa.DataType,
    unit: str,
    meaning: str,
    shape: tuple[int, ...] = (),
    required: bool = False,
    per_hand: bool = False,
) -> Any:
    """A field that is a column; the arguments are those of ``Column``."""
    about = {"type": type, "unit": unit, "meaning": meaning, "shape": shape, "required": required}
    return field(default=None, metadata={"column": {**about, "per_hand": per_hand}})


def _motor_column(unit: str, meaning: str) -> Any:
    """A field that is a column with a number for each motor, seven on the SDH-2."""
    return _column(_REAL, unit, meaning, (7,), per_hand=True)


@dataclass(eq=False, kw_only=True)
class TrialRow(MutableMapping[str, Any]):
    """What is known of one trial; a value that is missing is None.

    As a mapping it has every column, in the order of the table, and the columns of users' metrics
    behind them. ``COLUMNS`` tells type, unit, shape and meaning of each field.

    Attributes:
        user_columns: values of users' metrics by column name; ``normalise`` refuses other names.
    """

    trial: int | None = _column(_INT, "", "number of the trial in its run", required=True)
    object: str | None = _column(_TEXT, "", "name of the object model", required=True)
    seed: int | None = _column(_INT, "", "seed that decides the trial", required=True)
    success: bool | None = _column(_FLAG, "", "the object was lifted and held", required=True)
    failure: str | None = _column(_TEXT, "", "one of " + ", ".join(FAILURES), required=True)
    infeasible_reason: str | None = _column(_TEXT, "", "why a given grasp could not be tried")
    displacement_mm: float | None = _column(
        _REAL, "mm", "object motion in the hand frame since the snapshot"
    )
    rotation_deg: float | None = _column(
        _REAL, "deg", "object rotation in the hand frame since the snapshot"
    )
    q_linf: float | None = _column(_REAL, "", "task scaling under the L-infinity bound")
    q_l1: float | None = _column(_REAL, "", "task scaling under the L1 bound")
    q_capability: float | None = _column(
        _REAL, "", "task scaling within what shared motors could do"
    )
    q_held: float | None = _column(
        _REAL, "", "task scaling with saturated motors at their torque, else -inf"
    )
    q_whole_hand: float | None = _column(
        _REAL, "", "as q_capability, with all that touches, felt or not"
    )
    epsilon_linf: float | None = _column(
        _REAL, "", "epsilon of the same wrench sets, L-infinity, 1 N = 1 N m"
    )
    epsilon_l1: float | None = _column(
        _REAL, "", "epsilon of the same wrench sets, L1, 1 N = 1 N m"
    )
    volume_linf: float | None = _column(
        _REAL, "N^3 (N m)^3", "volume, soft contacts at their centres, L-infinity; null above 3"
    )
    volume_l1: float | None = _column(
        _REAL, "N^3 (N m)^3", "volume, soft contacts at their centres, L1; null above 3"
    )
    q_reason: str | None = _column(_TEXT, "", "why q is 0 or missing, empty otherwise")
    contacts: int | None = _column(_INT, "", "pads with readings that the prediction used")
    q_sim: float | None = _column(
        _REAL, "", "weights the grasp held in the load test, by the simulation"
    )
    q_sim_capped: bool | None = _column(
        _FLAG, "", "the load test ended at its largest load; q_sim is that"
    )
    load_at_failure: np.ndarray | None = _column(
        _REAL,
        "N, N m",
        "load along +x -x +y -y +z -z and moment about x y z of the hand at failure; inf: none",
        (9,),
    )
    gravity: str | None = _column(
        _TEXT, "", "direction of the weight without a table, in the object's frame; or six"
    )
    direction_displacement_mm: np.ndarray | None = _column(
        _REAL, "mm", "object motion under its weight along -z +z -x +x -y +y; NaN: not tried", (6,)
    )
    direction_rotation_deg: np.ndarray | None = _column(
        _REAL, "deg", "object rotation under its weight along the same directions", (6,)
    )
    direction_q_sim: np.ndarray | None = _column(
        _REAL, "", "weights the grasp held along the same directions", (6,)
    )
    disturbance_failure: str | None = _column(
        _TEXT, "", "failure of the disturbance test after the lift"
    )
    disturbance_displacement_mm: float | None = _column(_REAL, "mm", "object motion in it")
    disturbance_rotation_deg: float | None = _column(_REAL, "deg", "object rotation in it")
    repeats: int | None = _column(_INT, "", "perturbed copies of the trial that ran")
    success_probability: float | None = _column(_REAL, "", "share of them that held")
    success_low: float | None = _column(_REAL, "", "lower end of its 95 % Wilson interval")
    success_high: float | None = _column(_REAL, "", "upper end of its 95 % Wilson interval")
    perceived_pose_hand: np.ndarray | None = _column(
        _REAL,
        "m, quaternion",
        "object pose in the hand frame that the metrics saw: x y z qw qx qy qz",
        (7,),
    )
    perceived_mass_kg: float | None = _column(_REAL, "kg", "mass that the metrics assumed")
    perceived_friction: float | None = _column(_REAL, "", "friction that the metrics assumed")
    taxel_threshold: float | None = _column(
        _REAL, "", "share of a pad's largest reading above which the metrics counted a taxel"
    )
    sensed_force_n: float | None = _column(
        _REAL, "N", "sum of the normal forces that taxels feel at the snapshot"
    )
    unsensed_force_n: float | None = _column(
        _REAL, "N", "the same on palm, edges, backs and rubber off the arrays, which no taxel feels"
    )
    unsensed_contact: bool | None = _column(_FLAG, "", "such a contact bears force at the snapshot")
    surplus: bool | None = _column(
        _FLAG, "", "beyond its share of a preset: not compared; null without one"
    )
    mass_kg: float | None = _column(_REAL, "kg", "mass of the object")
    friction: float | None = _column(_REAL, "", "friction coefficient of the object")
    torque_limit_nm: np.ndarray | None = _motor_column("N m", "torque limit of each motor")
    joint_angles_rad: np.ndarray | None = _motor_column("rad", "motor angles at the snapshot")
    motor_torque_nm: np.ndarray | None = _motor_column("N m", "motor torques at the snapshot")
    peak_torque_nm: np.ndarray | None = _motor_column(
        "N m", "largest motor torques of the whole trial"
    )
    tactile_proximal: np.ndarray | None = _column(
        _SINGLE, TACTILE_UNIT, "proximal pads at the snapshot: finger, row, column", (3, 14, 6)
    )
    tactile_distal: np.ndarray | None = _column(
        _SINGLE, TACTILE_UNIT, "distal pads at the snapshot: finger, row, column", (3, 13, 6)
    )
    object_pose_hand: np.ndarray | None = _column(
        _REAL,
        "m, quaternion",
        "object pose in the hand frame at the snapshot: x y z qw qx qy qz",
        (7,),
    )
    hand_pose_world: np.ndarray | None = _column(
        _REAL, "m, quaternion", "hand frame in the world at the snapshot: x y z qw qx qy qz", (7,)
    )
    approach: str | None = _column(_TEXT, "", "side or top")
    preshape: str | None = _column(_TEXT, "", "preshape of the fingers")
    plan_azimuth_rad: float | None = _column(
        _REAL, "rad", "direction of approach about the vertical"
    )
    plan_roll_rad: float | None = _column(_REAL, "rad", "roll of the hand about its approach axis")
    plan_tilt_rad: float | None = _column(
        _REAL, "rad", "tilt of the approach off the horizontal or vertical"
    )
    plan_depth_m: float | None = _column(
        _REAL, "m", "palm frame to grasp centre along the palm's z"
    )
    plan_height_m: float | None = _column(_REAL, "m", "height of the grasp")
    plan_offset_m: np.ndarray | None = _column(_REAL, "m", "position error of the approach", (3,))
    object_yaw_rad: float | None = _column(_REAL, "rad", "yaw of the object on the table")
    plan_palm_pose_object: np.ndarray | None = _column(
        _REAL,
        "m, quaternion",
        "planned palm frame in the object's frame: x y z qw qx qy qz",
        (7,),
    )
    plan_opening: float | None = _column(_REAL, "", "closing ratio during the approach")
    plan_open_rad: np.ndarray | None = _motor_column(
        "rad", "motor angles of the closing at ratio 0"
    )
    plan_closed_rad: np.ndarray | None = _motor_column(
        "rad", "motor angles of the closing at ratio 1"
    )
    grasp_name: str | None = _column(_TEXT, "", "name of a grasp from a file")
    grasp_copy: int | None = _column(_INT, "", "number of the trial among those of its grasp")
    grasp_confidence: float | None = _column(_REAL, "", "what the file says of the grasp")
    resampled_unreachable: int | None = _column(
        _INT, "", "grasps drawn before that the arm cannot reach"
    )
    resampled_colliding: int | None = _column(
        _INT, "", "grasps drawn before that collide at the start"
    )
    sim_seconds: float | None = _column(_REAL, "s", "simulated time")
    user_columns: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        if name in _NAMES:
            return getattr(self, name)
        return self.user_columns[name]

    def __setitem__(self, name: str, value: Any) -> None:
        if name in _NAMES:
            setattr(self, name, value)
        else:
            self.user_columns[name] = value

    def __delitem__(self, name: str) -> None:
        if name in _NAMES:
            setattr(self, name, None)
        else:
            del self.user_columns[name]

    def __iter__(self) -> Iterator[str]:
        yield from _NAMES
        yield from self.user_columns

    def __len__(self) -> int:
        return len(_NAMES) + len(self.user_columns)


COLUMNS: tuple[Column, ...] = tuple(
    Column(name=f.name, **f.metadata["column"]) for f in fields(TrialRow) if "column" in f.metadata
)
"""Every column in the table's order; a new column is one field of ``TrialRow``."""
_NAMES = {column.name: column for column in COLUMNS}
