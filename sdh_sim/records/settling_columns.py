"""Columns of what is predicted for when the table lets go; tables have them where a run asked."""

from __future__ import annotations

from dataclasses import replace

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.trial_row import COLUMNS

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
SETTLING = {column.name: column for column in _OWN}
"""What every run that asks for settling has, by name."""
_METRICS = (
    *("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand", "epsilon_linf", "epsilon_l1"),
    *("volume_linf", "volume_l1", "contacts"),
)
SETTLED_METRICS = {column.name: column for column in COLUMNS if column.name in _METRICS}
"""What is there once more for where the grasp settles, beside users' metrics."""


def where_settled(column: Column) -> Column:
    """The column of a metric, for where the grasp settles."""
    meaning = f"where the grasp settles: {column.meaning}"
    return replace(column, name=SETTLED + column.name, meaning=meaning)
