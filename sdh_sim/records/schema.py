"""The table of a run, ``trials.parquet``: one row per trial, its columns listed here and only here.

Users' metrics add columns of their own at the end (``columns``); what writes a table is told which.

A row is a plain ``dict`` from column name to value. Array columns are fixed-size lists, so that
pandas, polars and DuckDB open the file as it is; ``stack`` gives them back as one numpy array.
"""

from __future__ import annotations

from collections.abc import Sequence

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.user_columns import added_column, added_in, is_added

FAILURES = ("none", "no_contact", "dropped", "slipped", "rotated", "unstable_simulation", "error")
"""How a trial ended. ``none`` is a success. ``unstable_simulation`` (the simulation diverged) and
``error`` (the trial raised, or its process died, twice) tell nothing about the grasp: comparisons
leave both out and count them. An ``error`` row has no values but trial, object and seed."""
NO_TRUTH = ("unstable_simulation", "error")
"""Failures that tell nothing about the grasp."""
TACTILE_UNIT = "kPa"
FORMAT = "sdh-sim trials 1"


_INT, _REAL, _TEXT, _FLAG = pa.int64(), pa.float64(), pa.string(), pa.bool_()

COLUMNS: tuple[Column, ...] = (
    Column("trial", _INT, "", "number of the trial in its run", required=True),
    Column("object", _TEXT, "", "name of the object model", required=True),
    Column("seed", _INT, "", "seed that decides the trial", required=True),
    Column("success", _FLAG, "", "the object was lifted and held", required=True),
    Column("failure", _TEXT, "", "one of " + ", ".join(FAILURES), required=True),
    Column("displacement_mm", _REAL, "mm", "object motion in the hand frame since the snapshot"),
    Column("rotation_deg", _REAL, "deg", "object rotation in the hand frame since the snapshot"),
    Column("q_linf", _REAL, "", "task scaling under the L-infinity bound"),
    Column("q_l1", _REAL, "", "task scaling under the L1 bound"),
    Column("q_capability", _REAL, "", "task scaling within what shared motors could do"),
    Column("q_held", _REAL, "", "task scaling with saturated motors at their torque, else -inf"),
    Column("q_whole_hand", _REAL, "", "as q_capability, with all that touches, felt or not"),
    Column("epsilon_linf", _REAL, "", "epsilon of the same wrench sets, L-infinity, 1 N = 1 N m"),
    Column("epsilon_l1", _REAL, "", "epsilon of the same wrench sets, L1, 1 N = 1 N m"),
    Column("volume_linf", _REAL, "N^3 (N m)^3", "volume, hard contacts, L-infinity; null above 3"),
    Column("volume_l1", _REAL, "N^3 (N m)^3", "volume, hard contacts, L1; null above 3"),
    Column("q_reason", _TEXT, "", "why q is 0 or missing, empty otherwise"),
    Column("contacts", _INT, "", "pads with readings that the prediction used"),
    Column("q_sim", _REAL, "", "weights the grasp held in the load test, by the simulation"),
    Column("q_sim_capped", _FLAG, "", "the load test ended at its largest load; q_sim is that"),
    Column(
        "load_at_failure",
        _REAL,
        "N, N m",
        "load along +x -x +y -y +z -z and moment about x y z of the hand at failure; inf: none",
        (9,),
    ),
    Column("disturbance_failure", _TEXT, "", "failure of the disturbance test after the lift"),
    Column("disturbance_displacement_mm", _REAL, "mm", "object motion in it"),
    Column("disturbance_rotation_deg", _REAL, "deg", "object rotation in it"),
    Column("repeats", _INT, "", "perturbed copies of the trial that ran"),
    Column("success_probability", _REAL, "", "share of them that held"),
    Column("success_low", _REAL, "", "lower end of its 95 % Wilson interval"),
    Column("success_high", _REAL, "", "upper end of its 95 % Wilson interval"),
    Column(
        "perceived_pose_hand",
        _REAL,
        "m, quaternion",
        "object pose in the hand frame that the metrics saw: x y z qw qx qy qz",
        (7,),
    ),
    Column("perceived_mass_kg", _REAL, "kg", "mass that the metrics assumed"),
    Column("perceived_friction", _REAL, "", "friction that the metrics assumed"),
    Column("sensed_force_n", _REAL, "N", "sum of normal forces on taxels at the snapshot"),
    Column("unsensed_force_n", _REAL, "N", "the same on palm, edges and backs, which no pad feels"),
    Column("unsensed_contact", _FLAG, "", "such a contact bears force at the snapshot"),
    Column("surplus", _FLAG, "", "beyond its share of a preset: not compared; null without one"),
    Column("mass_kg", _REAL, "kg", "mass of the object"),
    Column("friction", _REAL, "", "friction coefficient of the object"),
    Column("torque_limit_nm", _REAL, "N m", "torque limit of each motor", (7,)),
    Column("joint_angles_rad", _REAL, "rad", "motor angles at the snapshot", (7,)),
    Column("motor_torque_nm", _REAL, "N m", "motor torques at the snapshot", (7,)),
    Column("peak_torque_nm", _REAL, "N m", "largest motor torques of the whole trial", (7,)),
    Column(
        "tactile_proximal",
        pa.float32(),
        TACTILE_UNIT,
        "proximal pads at the snapshot: finger, row, column",
        (3, 14, 6),
    ),
    Column(
        "tactile_distal",
        pa.float32(),
        TACTILE_UNIT,
        "distal pads at the snapshot: finger, row, column",
        (3, 13, 6),
    ),
    Column(
        "object_pose_hand",
        _REAL,
        "m, quaternion",
        "object pose in the hand frame at the snapshot: x y z qw qx qy qz",
        (7,),
    ),
    Column(
        "hand_pose_world",
        _REAL,
        "m, quaternion",
        "hand frame in the world at the snapshot: x y z qw qx qy qz",
        (7,),
    ),
    Column("approach", _TEXT, "", "side or top"),
    Column("preshape", _TEXT, "", "preshape of the fingers"),
    Column("plan_azimuth_rad", _REAL, "rad", "direction of approach about the vertical"),
    Column("plan_roll_rad", _REAL, "rad", "roll of the hand about its approach axis"),
    Column("plan_tilt_rad", _REAL, "rad", "tilt of the approach off the horizontal or vertical"),
    Column("plan_depth_m", _REAL, "m", "palm frame to grasp centre along the palm's z"),
    Column("plan_height_m", _REAL, "m", "height of the grasp"),
    Column("plan_offset_m", _REAL, "m", "position error of the approach", (3,)),
    Column("object_yaw_rad", _REAL, "rad", "yaw of the object on the table"),
    Column("resampled_unreachable", _INT, "", "grasps drawn before that the arm cannot reach"),
    Column("resampled_colliding", _INT, "", "grasps drawn before that collide at the start"),
    Column("sim_seconds", _REAL, "s", "simulated time"),
)
"""Every column in the table's order; a new column is one line here."""

_BY_NAME = {column.name: column for column in COLUMNS}


def schema_of(added: Sequence[Column] = ()) -> pa.Schema:
    """Schema of a table with all columns and the added ones."""
    return pa.schema(
        [column.field for column in (*COLUMNS, *added)],
        metadata={"format": FORMAT, "tactile_unit": TACTILE_UNIT},
    )


SCHEMA = schema_of()


def column_named(name: str) -> Column:
    """The column of that name, one of ours or an added one; KeyError where there is none."""
    return added_column(name) if is_added(name) else _BY_NAME[name]


def columns_in(schema: pa.Schema) -> tuple[Column, ...]:
    """All columns of a table of ours with those that its file has besides."""
    return (*COLUMNS, *added_in(schema))
