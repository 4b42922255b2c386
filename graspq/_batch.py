"""Compiled loops over many grasps; they run without the interpreter's lock."""

from __future__ import annotations

import numpy as np

from graspq._desk import new_desk
from graspq._flat import spread
from graspq._jit import compiled, entry
from graspq._ray import reach_at

SINGULAR, REFUSED = 9, 10


@compiled
def grasp_body(columns, widths, first, begin, end, united, zero):
    """One grasp as a body: contacts begin to end, whose columns start at ``first``."""
    total = 0
    for i in range(begin, end):
        total += widths[i]
    points = np.empty((6, total))
    for r in range(6):
        for k in range(total):
            points[r, k] = columns[r, first + k]
    contacts = 1 if united else end - begin
    starts = np.zeros(contacts + 1, np.int64)
    owners = np.zeros(total, np.int64)
    at = 0
    for i in range(begin, end):
        owners[at:at + widths[i]] = i - begin
        at += widths[i]
        if not united:
            starts[i - begin + 1] = at
    starts[contacts] = total
    body = (points, starts, np.zeros((6, 0)), np.zeros((0, 6, 3)),
            np.zeros(contacts + 1, np.int64), zero, np.zeros(6))
    return body, owners


@compiled
def _place(columns, first, widths, body, owners):
    """Put the next grasp in the place of one with as many contacts and columns."""
    points, starts = body[0], body[1]
    for r in range(6):
        for k in range(points.shape[1]):
            points[r, k] = columns[r, first + k]
    at = 0
    for i in range(widths.shape[0]):
        for k in range(at, at + widths[i]):
            owners[k] = i
        at += widths[i]
        if starts.shape[0] > 2:
            starts[i + 1] = at


@entry
def reach_many(columns, widths, first, contacts, united, zero, tasks, begins, ends, low, high, stop,
               out):
    """q* of the grasps low to high; rows of ``out`` are status, value, lower, upper, task.

    ``zero`` is always true: a literal would be another type, and double what is compiled.
    """
    # Made here: a global would be read-only, once more another type.
    pads, nobody, forces = np.zeros((0, 6)), np.zeros(0, np.int64), np.zeros((0, 6))
    begin, end, total = 0, 0, -1
    body, owners = grasp_body(columns, widths, 0, 0, 0, united, zero)
    desk = new_desk(0, 0)
    for g in range(low, high):
        same = contacts[g + 1] - contacts[g] == end - begin
        begin, end = contacts[g], contacts[g + 1]
        count = first[end] - first[begin]
        if same and count == total:
            _place(columns, first[begin], widths[begin:end], body, owners)
        else:
            total = count
            body, owners = grasp_body(columns, widths, first[begin], begin, end, united, zero)
            desk = new_desk(total, body[1].shape[0] - 1)
        wanted = tasks[:, begins[g]:ends[g]].copy()
        status, value, lower, upper, critical, sound = reach_at(
            desk, wanted, body, pads, stop, owners, nobody, forces)
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
    body, owners = grasp_body(columns, widths, 0, 0, widths.shape[0], united, zero)
    desk = new_desk(body[0].shape[1], body[1].shape[0] - 1)
    status, value, lower, upper, critical, sound = reach_at(
        desk, tasks, body, pads, stop, owners, nobody, forces)
    if not sound and spread(body, np.empty(6), np.empty(6), np.empty((6, 6))) == 0.0:
        return SINGULAR, 0.0, 0.0, 0.0, 0
    return status, value, lower, upper, critical
