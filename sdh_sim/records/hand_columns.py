"""Columns whose shape is that of the hand: motors and tactile arrays.

``COLUMNS`` has those of the SDH-2. A table of another hand has the same columns with other lengths,
a column ``tactile_<kind>`` for each kind of its arrays, and one that names it; where its joints do
not follow from its motors, one with their positions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import pyarrow as pa

from sdh_sim.records.column import Column
from sdh_sim.records.trial_row import COLUMNS, TACTILE_UNIT

HAND_NAME = "hand"
JOINTS = "joint_positions"
TACTILE = "tactile_"
_TACTILE = re.compile(TACTILE + r"[a-z][a-z0-9_]{0,47}")
_OWN = {column.name for column in COLUMNS}


class HandShape(NamedTuple):
    """What the columns need to know of a hand.

    Attributes:
        motors: number of its motors.
        arrays: pads, rows and columns of each kind of array.
        joints: number of its joints where some are passive, otherwise 0.
    """

    motors: int
    arrays: Mapping[str, tuple[int, int, int]]
    joints: int = 0


def is_hand_column(name: str) -> bool:
    """Whether a column is one that tables of other hands have besides ours."""
    known = name in (HAND_NAME, JOINTS)
    return known or (name not in _OWN and _TACTILE.fullmatch(name) is not None)


def hand_column(name: str, shape: tuple[int, ...] | None = None) -> Column:
    """The column of that name, for which ``is_hand_column``; without its shape where None."""
    if name == HAND_NAME:
        return Column(name, pa.string(), "", "name of the hand; without the column the SDH-2")
    if name == JOINTS:
        meaning = "positions of all joints of a hand with passive ones, at the snapshot"
        return Column(name, pa.float64(), "rad or m", meaning, shape or (0,), per_hand=True)
    kind = name.removeprefix(TACTILE)
    meaning = f"arrays {kind} at the snapshot: pad, row, column"
    return Column(name, pa.float32(), TACTILE_UNIT, meaning, shape or (0, 0, 0), per_hand=True)


def hand_columns(shape: HandShape) -> tuple[Column, ...]:
    """The columns of another hand: those of ours that differ, and those that it has besides."""
    motors = [c.with_shape((shape.motors,)) for c in COLUMNS if c.per_hand]
    tactile = [hand_column(TACTILE + kind, size) for kind, size in shape.arrays.items()]
    joints = [hand_column(JOINTS, (shape.joints,))] if shape.joints else []
    return (*motors, hand_column(HAND_NAME), *joints, *tactile)


def as_in(schema: pa.Schema, column: Column) -> Column:
    """The column with the shape that it has in a file, where that is up to the hand."""
    if not column.per_hand or schema.names.count(column.name) != 1:
        return column
    shape, kind = [], schema.field(column.name).type
    while pa.types.is_fixed_size_list(kind):
        shape.append(kind.list_size)
        kind = kind.value_type
    return column.with_shape(tuple(shape)) if len(shape) == len(column.shape) else column
