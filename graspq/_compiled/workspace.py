"""Compiled: what ray shooting works with, made once and used for many tasks and grasps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspq._compiled.jit import compiled
from graspq._compiled.simd_lanes import off_identity, product
from graspq._compiled.small_matrices import invert

REAL, PAD, ARTIFICIAL = 0, 1, 2
# Up to this many columns, all are listed for a quick answer; of more, this many blocks of eight
# per body, with those that ever were the best.
MANY, SLOTS = 256, 8
# Rows of the sheet; the first six are the basis, a vertex per column.
INVERSE, DIRECTIONS, WEIGHTS, SCRATCH, SIZE, TASK, SHEET = 6, 12, 18, 19, 27, 28, 29
# Rows of eight lanes; the first six are the transposed inverse. The listed columns come last, in
# blocks of eight columns and so of six rows.
COLUMN, SHARE, SPARE, ROOM = 6, 7, 8, 14
# Rows of the places, a column per body: the atoms that were chosen, those kept, the number of
# listed columns, the block where they begin, and the atoms of the six vertices.
CHOICE, KEPT, COUNT, FIRST, PICKS, PLACES = 0, 1, 2, 3, 4, 10
CLOSE = 1e-9


class Desk(NamedTuple):
    """A basis of six vertices, the columns that are asked first, and scratch.

    Few arrays, as all are handed from function to function: vectors of six on a ``sheet``,
    ``lanes`` of eight, ``kinds`` of the six vertices, ``places`` per body, ``names`` of the
    listed columns, and scratch for a ``score`` per column.
    """

    sheet: np.ndarray
    lanes: np.ndarray
    kinds: np.ndarray
    places: np.ndarray
    names: np.ndarray
    score: np.ndarray


@compiled
def new_desk(columns, bodies):
    """A desk for sets of so many columns and bodies."""
    blocks = columns // 8 + bodies if columns <= MANY else SLOTS * bodies
    return Desk(
        np.empty((SHEET, 6)),
        np.empty(8 * ROOM + 48 * blocks),
        np.empty(6, np.int64),
        np.empty((PLACES, bodies), np.int64),
        np.empty(8 * blocks, np.int64),
        np.empty(columns),
    )


@compiled
def clear(desk, body):
    """Get ready for another set: no basis to start warm from, and its columns listed if few."""
    points, starts = body[0], body[1]
    lanes, names, places = desk.lanes, desk.names, desk.places
    for r in range(6):
        desk.kinds[r] = ARTIFICIAL
    if points.shape[1] > MANY:
        for i in range(places.shape[1]):
            places[FIRST, i], places[COUNT, i] = SLOTS * i, 0
        return
    at = 0
    for i in range(places.shape[1]):
        begin, count = starts[i], starts[i + 1] - starts[i]
        places[FIRST, i], places[COUNT, i] = at, count
        for block in range((count + 7) >> 3):
            for k in range(8):
                # The last column once more fills the last block up.
                column = begin + min(8 * block + k, count - 1)
                names[8 * at + k] = column
                for r in range(6):
                    lanes[8 * ROOM + 48 * at + 8 * r + k] = points[r, column]
            at += 1


@compiled
def remember(desk, points):
    """List the chosen columns where there are too many to list all; whether any was new."""
    lanes, names, places = desk.lanes, desk.names, desk.places
    grown = False
    for i in range(places.shape[1]):
        pick, begin, count = places[CHOICE, i], 8 * places[FIRST, i], places[COUNT, i]
        if pick < 0 or count == 8 * SLOTS:
            continue
        known = False
        for k in range(begin, begin + count):
            known = known or names[k] == pick
        if not known:
            # The first of a block fills all of it.
            at = begin + count
            for k in range(at, at + 1 if count & 7 else at + 8):
                names[k] = pick
                for r in range(6):
                    lanes[8 * ROOM + 48 * (k >> 3) + 8 * r + (k & 7)] = points[r, pick]
            places[COUNT, i] += 1
            grown = True
    return grown


@compiled
def to_lanes(desk):
    """Copy the inverse to the lanes."""
    lanes, sheet = desk.lanes, desk.sheet
    for c in range(6):
        for r in range(6):
            lanes[8 * c + r] = sheet[INVERSE + r, c]
        lanes[8 * c + 6] = 0.0
        lanes[8 * c + 7] = 0.0


@compiled
def from_lanes(desk):
    """Copy the lanes to the inverse."""
    lanes, sheet = desk.lanes, desk.sheet
    for r in range(6):
        for c in range(6):
            sheet[INVERSE + r, c] = lanes[8 * c + r]


@compiled
def refactor(desk):
    """Invert the basis; False when there is no inverse."""
    return invert(desk.sheet[0:6], desk.sheet[INVERSE : INVERSE + 6])


@compiled
def refresh(desk):
    """Make the inverse that of the basis up to round-off; False when there is none.

    Newton's step X + (I - X B) X squares what pivots have left of I - X B; where that is not
    small enough, the basis is inverted anew.
    """
    sheet, lanes = desk.sheet, desk.lanes
    to_lanes(desk)
    for c in range(6):
        product(
            lanes,
            SPARE + c,
            0,
            (sheet[0, c], sheet[1, c], sheet[2, c], sheet[3, c], sheet[4, c], sheet[5, c]),
        )
    if not off_identity(lanes, SPARE) <= CLOSE:
        return refactor(desk)
    for c in range(6):
        # Column c of 2 X - (X B) X.
        x = (
            lanes[8 * c],
            lanes[8 * c + 1],
            lanes[8 * c + 2],
            lanes[8 * c + 3],
            lanes[8 * c + 4],
            lanes[8 * c + 5],
        )
        product(lanes, COLUMN, SPARE, x)
        for r in range(6):
            sheet[INVERSE + r, c] = 2.0 * x[r] - lanes[8 * COLUMN + r]
    return True
