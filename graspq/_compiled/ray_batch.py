"""Compiled loops over many grasps; they run without the interpreter's lock."""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import compiled, entry
from graspq._compiled.ray_shooting import reach_at
from graspq._compiled.span_and_whitening import spread
from graspq._compiled.workspace import new_desk

SINGULAR, REFUSED = 9, 10


@compiled
def _body(points, widths, united, zero):
    """The columns of one grasp as a body, and the contact of each."""
    contacts = 1 if united else widths.shape[0]
    starts = np.zeros(contacts + 1, np.int64)
    owners = np.zeros(points.shape[1], np.int64)
    at = 0
    for i in range(widths.shape[0]):
        for _ in range(widths[i]):
            owners[at] = i
            at += 1
        if not united:
            starts[i + 1] = at
    starts[contacts] = at
    body = (
        points,
        starts,
        np.zeros((6, 0)),
        np.zeros((0, 6, 3)),
        np.zeros(contacts + 1, np.int64),
        zero,
        np.zeros(6),
    )
    return body, owners


@compiled
def _copy(columns, first, points):
    for r in range(6):
        for k in range(points.shape[1]):
            points[r, k] = columns[r, first + k]


@compiled
def grasp_body(columns, widths, first, begin, end, united, zero):
    """One grasp as a body: contacts begin to end, whose columns start at ``first``."""
    total = 0
    for i in range(begin, end):
        total += widths[i]
    points = np.empty((6, total))
    _copy(columns, first, points)
    return _body(points, widths[begin:end], united, zero)


@entry
def reach_many(
    columns, widths, first, contacts, united, zero, tasks, begins, ends, low, high, stop, out
):
    """q* of the grasps low to high; rows of ``out`` are status, value, lower, upper, task.

    ``zero`` is always true: a literal would be another type, and double what is compiled.
    """
    # Made here: a global would be read-only, once more another type.
    pads, nobody, forces = np.zeros((0, 6)), np.zeros(0, np.int64), np.zeros((0, 6))
    begin, end = 0, 0
    body, owners = grasp_body(columns, widths, 0, 0, 0, united, zero)
    desk = new_desk(0, 0)
    for g in range(low, high):
        # A grasp with as many columns in every contact takes the place of the one before.
        same = contacts[g + 1] - contacts[g] == end - begin
        for i in range(end - begin if same else 0):
            same = same and widths[contacts[g] + i] == widths[begin + i]
        begin, end = contacts[g], contacts[g + 1]
        if same:
            _copy(columns, first[begin], body[0])
        else:
            body, owners = grasp_body(columns, widths, first[begin], begin, end, united, zero)
            desk = new_desk(body[0].shape[1], body[1].shape[0] - 1)
        wanted = tasks[:, begins[g] : ends[g]].copy()
        status, value, lower, upper, critical, sound = reach_at(
            desk, wanted, body, pads, stop, owners, nobody, forces
        )
        if not sound and spread(body, np.empty(6), np.empty(6), np.empty((6, 6))) == 0.0:
            status = SINGULAR
        out[g, 0], out[g, 1], out[g, 2], out[g, 3] = status, value, lower, upper
        out[g, 4] = critical


@entry
def reach_one(columns, widths, united, zero, tasks, stop, forces):
    """q* of one grasp: (status, value, lower, upper, task). REFUSED leaves it to the checks."""
    if columns.shape[0] != 6 or tasks.shape[0] != 6 or tasks.shape[1] == 0:
        return REFUSED, 0.0, 0.0, 0.0, 0
    total = 0.0
    for r in range(6):
        for k in range(columns.shape[1]):
            total += abs(columns[r, k])
    for j in range(tasks.shape[1]):
        length = 0.0
        for r in range(6):
            length += abs(tasks[r, j])
        if not length > 0.0:
            return REFUSED, 0.0, 0.0, 0.0, 0
        total += length
    if not total < np.inf:
        return REFUSED, 0.0, 0.0, 0.0, 0
    pads, nobody = np.zeros((0, 6)), np.zeros(0, np.int64)
    body, owners = _body(columns, widths, united, zero)
    desk = new_desk(body[0].shape[1], body[1].shape[0] - 1)
    status, value, lower, upper, critical, sound = reach_at(
        desk, tasks, body, pads, stop, owners, nobody, forces
    )
    if not sound and spread(body, np.empty(6), np.empty(6), np.empty((6, 6))) == 0.0:
        return SINGULAR, 0.0, 0.0, 0.0, 0
    return status, value, lower, upper, critical
