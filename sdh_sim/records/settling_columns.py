"""Columns of what is predicted for when the table lets go; tables have them where a run asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.trial_row import COLUMNS
from sdh_sim.records.user_columns import added_column, is_added

SETTLED = "settled_"
_REAL, _FLAG = pa.float64(), pa.bool_()
_OWN = (
    Column("settled", _FLAG, "", "predicted: without the table it settles within 10 mm and 10 deg"),
    Column(SETTLED + "displacement_mm", _REAL, "mm", "predicted object motion in the hand by then"),
    Column(SETTLED + "rotation_deg", _REAL, "deg", "predicted object rotation in the hand by then"),
    Column(SETTLED + "object_pose_hand", _REAL, "m, quaternion",
           "predicted object pose in the hand frame then: x y z qw qx qy qz", (7,)),
    Column("q_settled", _REAL, "", "weights the grasp bears by settling, as q_sim counts them"),
    Column("q_settled_capped", _FLAG, "", "its load ramp ended at the largest load"),
)  # fmt: skip
_BY_NAME = {column.name: column for column in _OWN}
_METRICS = (
    *("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand", "epsilon_linf", "epsilon_l1"),
    *("volume_linf", "volume_l1", "contacts"),
)
_OF_METRICS = {column.name: column for column in COLUMNS if column.name in _METRICS}


def is_settling_column(name: str) -> bool:
    """Whether a column is one of settling."""
    base = name.removeprefix(SETTLED)
    known = base in _OF_METRICS or is_added(base)
    return name in _BY_NAME or (name.startswith(SETTLED) and known)


def settling_column(name: str) -> Column:
    """The column of that name, for which ``is_settling_column``."""
    if name in _BY_NAME:
        return _BY_NAME[name]
    base = name.removeprefix(SETTLED)
    return _where_settled(_OF_METRICS[base] if base in _OF_METRICS else added_column(base))


def settling_columns(added: Sequence[Column], metrics: bool) -> tuple[Column, ...]:
    """The columns of settling.

    Args:
        added: columns of the run's table besides ours.
        metrics: those of the metrics where the grasp settles, too.
    """
    if not metrics:
        return _OWN
    users = [column for column in added if is_added(column.name)]
    return (*_OWN, *map(_where_settled, (*_OF_METRICS.values(), *users)))


def _where_settled(column: Column) -> Column:
    meaning = f"where the grasp settles: {column.meaning}"
    return replace(column, name=SETTLED + column.name, meaning=meaning)
