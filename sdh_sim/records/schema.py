"""The schema of ``trials.parquet``: one row per trial, the columns of ``TrialRow``.

Users' metrics, other hands and other moments than the snapshot add columns of their own; what
writes a table is told which. Array columns are fixed-size lists, so that pandas, polars and DuckDB
open the file as it is.

What a snapshot fills in is there once for each moment that the run looked at: under its own name
for the snapshot on the table, behind ``LIFT_OFF`` for that at lift-off. What settling predicts is
in columns of its own (``settling_columns``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.hand_columns import JOINTS, TACTILE, as_in, hand_column, is_hand_column
from sdh_sim.records.settling_columns import SETTLED, SETTLED_METRICS, SETTLING, where_settled
from sdh_sim.records.trial_row import COLUMNS, TACTILE_UNIT
from sdh_sim.records.user_columns import added_column, added_in, is_added

FORMAT = "sdh-sim trials 1"
_BY_NAME = {column.name: column for column in COLUMNS}
LIFT_OFF = "liftoff_"
SNAPSHOT = (
    *("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand", "epsilon_linf", "epsilon_l1"),
    *("volume_linf", "volume_l1", "q_reason", "contacts", "perceived_pose_hand"),
    *("sensed_force_n", "unsensed_force_n", "unsensed_contact", "joint_angles_rad"),
    *("motor_torque_nm", "tactile_proximal", "tactile_distal", "object_pose_hand"),
    "hand_pose_world",
)
"""What a snapshot fills in, beside tactile arrays of other hands and users' metrics."""
_OWN = (
    Column("rise_mm", pa.float64(), "mm", "how far the hand has risen since the first snapshot"),
    Column("on_table", pa.bool_(), "", "the object still touches the table"),
    Column("displacement_mm", pa.float64(), "mm", "object motion in the hand since the snapshot"),
    Column("rotation_deg", pa.float64(), "deg", "object rotation in the hand since the snapshot"),
)
_MOMENT = {c.name: c for c in COLUMNS if c.name in SNAPSHOT} | {c.name: c for c in _OWN}


def all_columns(added: Sequence[Column] = ()) -> tuple[Column, ...]:
    """All columns of a table: ours and the added ones, which may be ours in another shape."""
    return tuple(({c.name: c for c in COLUMNS} | {c.name: c for c in added}).values())


def schema_of(added: Sequence[Column] = ()) -> pa.Schema:
    """Schema of a table with all columns and the added ones."""
    return pa.schema(
        [column.field for column in all_columns(added)],
        metadata={"format": FORMAT, "tactile_unit": TACTILE_UNIT},
    )


SCHEMA = schema_of()


def column_named(name: str) -> Column:
    """The column of that name, one of ours or an added one; KeyError where there is none."""
    if is_hand_column(name):
        return hand_column(name)
    if is_moment_column(name):
        return moment_column(name)
    return added_column(name) if is_added(name) else _BY_NAME[name]


def columns_in(schema: pa.Schema) -> tuple[Column, ...]:
    """All columns of a table of ours with those that its file has besides."""
    hand = [hand_column(name) for name in dict.fromkeys(schema.names) if is_hand_column(name)]
    more = (*hand, *added_in(schema), *moments_in(schema))
    return tuple(as_in(schema, column) for column in (*COLUMNS, *more))


def is_moment_column(name: str) -> bool:
    """Whether a column is one of another moment, seen or predicted."""
    if name in SETTLING:
        return True
    if name.startswith(SETTLED):
        base = name.removeprefix(SETTLED)
        return base in SETTLED_METRICS or is_added(base)
    if not name.startswith(LIFT_OFF):
        return False
    name = name.removeprefix(LIFT_OFF)
    array = name == JOINTS or name.startswith(TACTILE)
    return name in _MOMENT or is_added(name) or (array and is_hand_column(name))


def moment_column(name: str) -> Column:
    """The column of that name, for which ``is_moment_column``."""
    if name in SETTLING:
        return SETTLING[name]
    if name.startswith(SETTLED):
        base = name.removeprefix(SETTLED)
        known = base in SETTLED_METRICS
        return where_settled(SETTLED_METRICS[base] if known else added_column(base))
    base = name.removeprefix(LIFT_OFF)
    if base in _MOMENT:
        return _at_lift_off(_MOMENT[base])
    return _at_lift_off(added_column(base) if is_added(base) else hand_column(base))


def lift_off_columns(added: Sequence[Column]) -> tuple[Column, ...]:
    """The columns of the moment of lift-off.

    Args:
        added: columns of the run's table besides ours, or ours in another shape.
    """
    known = _MOMENT | {c.name: c for c in added if c.name in _MOMENT}
    more = [c for c in added if is_moment_column(LIFT_OFF + c.name) and c.name not in _MOMENT]
    return tuple(_at_lift_off(column) for column in (*known.values(), *more))


def settling_columns(added: Sequence[Column], metrics: bool) -> tuple[Column, ...]:
    """The columns of settling.

    Args:
        added: columns of the run's table besides ours.
        metrics: those of the metrics where the grasp settles, too.
    """
    if not metrics:
        return tuple(SETTLING.values())
    users = (column for column in added if is_added(column.name))
    return (*SETTLING.values(), *map(where_settled, (*SETTLED_METRICS.values(), *users)))


def moments_in(schema: pa.Schema) -> tuple[Column, ...]:
    """The columns of other moments that a file has."""
    return tuple(moment_column(n) for n in dict.fromkeys(schema.names) if is_moment_column(n))


def _at_lift_off(column: Column) -> Column:
    meaning = column.meaning.replace("at the snapshot", "").strip()
    return replace(column, name=LIFT_OFF + column.name, meaning=f"at lift-off: {meaning}")
