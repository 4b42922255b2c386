"""Compiled loop of ε over many grasps; it runs without the interpreter's lock."""

from __future__ import annotations

from graspq._compiled.inscribed_ball import ball, room
from graspq._compiled.jit import entry
from graspq._compiled.ray_batch import grasp_body


@entry
def ball_many(columns, widths, first, contacts, united, zero, low, high, facets, vertices, out):
    """ε of the grasps low to high; rows of ``out`` are status, value."""
    work = room(facets, vertices)
    for g in range(low, high):
        begin, end = contacts[g], contacts[g + 1]
        body, _ = grasp_body(columns, widths, first[begin], begin, end, united, zero)
        status, _, value = ball(body, 0.0, work)
        out[g, 0], out[g, 1] = status, value
