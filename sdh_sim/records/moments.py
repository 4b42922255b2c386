"""Columns of other moments of a trial than the snapshot before the lift.

What a snapshot fills in is there once for each moment: under its own name for the snapshot on the
table, behind a prefix for another moment: lift-off, which is simulated, and where the grasp settles
without the table, which is predicted. Tables have these columns where the run asked for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.hand_columns import JOINTS, TACTILE, hand_column, is_hand_column
from sdh_sim.records.trial_row import COLUMNS
from sdh_sim.records.user_columns import added_column, is_added

LIFT_OFF, SETTLED = "liftoff_", "settled_"
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
_BY_NAME = {c.name: c for c in COLUMNS if c.name in SNAPSHOT} | {c.name: c for c in _OWN}
_REAL, _FLAG = pa.float64(), pa.bool_()
_SETTLING = (
    Column("settled", _FLAG, "", "predicted: without the table it settles within 10 mm and 10 deg"),
    Column(SETTLED + "displacement_mm", _REAL, "mm", "predicted object motion in the hand by then"),
    Column(SETTLED + "rotation_deg", _REAL, "deg", "predicted object rotation in the hand by then"),
    Column(SETTLED + "object_pose_hand", _REAL, "m, quaternion",
           "predicted object pose in the hand frame then: x y z qw qx qy qz", (7,)),
    Column("q_settled", _REAL, "", "weights the grasp bears by settling, as q_sim counts them"),
    Column("q_settled_capped", _FLAG, "", "its load ramp ended at the largest load"),
)  # fmt: skip
_SETTLING_NAMES = {column.name: column for column in _SETTLING}
_SETTLED_METRICS = (*SNAPSHOT[: SNAPSHOT.index("q_reason")], "contacts")


def is_moment_column(name: str) -> bool:
    """Whether a column is one of another moment."""
    if name in _SETTLING_NAMES:
        return True
    if name.startswith(SETTLED):
        base = name.removeprefix(SETTLED)
        return base in _SETTLED_METRICS or is_added(base)
    if not name.startswith(LIFT_OFF):
        return False
    name = name.removeprefix(LIFT_OFF)
    array = name == JOINTS or name.startswith(TACTILE)
    return name in _BY_NAME or is_added(name) or (array and is_hand_column(name))


def moment_column(name: str) -> Column:
    """The column of that name, for which ``is_moment_column``."""
    if name in _SETTLING_NAMES:
        return _SETTLING_NAMES[name]
    if name.startswith(SETTLED):
        base = name.removeprefix(SETTLED)
        return _where_settled(_BY_NAME[base] if base in _BY_NAME else added_column(base))
    base = name.removeprefix(LIFT_OFF)
    if base in _BY_NAME:
        return _at_lift_off(_BY_NAME[base])
    return _at_lift_off(added_column(base) if is_added(base) else hand_column(base))


def lift_off_columns(added: Sequence[Column]) -> tuple[Column, ...]:
    """The columns of the moment of lift-off.

    Args:
        added: columns of the run's table besides ours, or ours in another shape.
    """
    known = _BY_NAME | {c.name: c for c in added if c.name in _BY_NAME}
    more = [c for c in added if is_moment_column(LIFT_OFF + c.name) and c.name not in _BY_NAME]
    return tuple(_at_lift_off(column) for column in (*known.values(), *more))


def settling_columns(added: Sequence[Column], metrics: bool) -> tuple[Column, ...]:
    """The columns of settling.

    Args:
        added: columns of the run's table besides ours.
        metrics: those of the metrics where the grasp settles, too.
    """
    if not metrics:
        return _SETTLING
    users = [column for column in added if is_added(column.name)]
    known = [_BY_NAME[name] for name in _SETTLED_METRICS]
    return (*_SETTLING, *map(_where_settled, (*known, *users)))


def moments_in(schema: pa.Schema) -> tuple[Column, ...]:
    """The columns of other moments that a file has."""
    return tuple(moment_column(n) for n in dict.fromkeys(schema.names) if is_moment_column(n))


def _at_lift_off(column: Column) -> Column:
    meaning = column.meaning.replace("at the snapshot", "").strip()
    return replace(column, name=LIFT_OFF + column.name, meaning=f"at lift-off: {meaning}")


def _where_settled(column: Column) -> Column:
    meaning = f"where the grasp settles: {column.meaning}"
    return replace(column, name=SETTLED + column.name, meaning=meaning)
