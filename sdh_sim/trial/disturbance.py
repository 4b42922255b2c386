"""After the lift: turn the wrist or shake the hand, and see whether the object stays."""

from __future__ import annotations

import itertools
import math

import numpy as np

from sdh_sim.cell.simulation import Cell
from sdh_sim.objects.catalogue import ObjectInfo
from sdh_sim.robot.arm import along, arm_kinematics
from sdh_sim.trial import outcome

TURN = math.radians(120)  # of the wrist, either way
TURN_TIME = 1.5  # [s] for 120 degrees
SHAKE_AMPLITUDE, SHAKE_FREQUENCY, SHAKE_TIME = 0.02, 2.0, 2.0  # [m], [Hz], [s]; peak 3.2 m/s^2
STILL = 0.5  # [s] to wait at the end


def disturb(cell: Cell, thing: ObjectInfo, kind: str) -> tuple[float, float, bool]:
    """Turn (``turn``: joint 6 by +120, -120 and back) or shake (``shake``: along the hand's x).

    Args:
        cell: with the object lifted.
        thing: the object.
        kind: ``turn`` or ``shake``.

    Returns:
        greatest displacement [mm] and rotation [deg] of the object in the hand since the start,
        and whether it ended on the table or left the hand.

    Raises:
        Diverged: the simulation did.
    """
    cell.phase = kind
    start = cell.data.ctrl[cell.scene.arm_motors].copy()
    before = cell.object_in_hand()
    moved = turned = 0.0
    for reference in _turn(start, cell) if kind == "turn" else _shake(start, cell):
        cell.tick(reference)
        step = outcome.motion(before, cell.object_in_hand(), thing.com_m)
        moved, turned = max(moved, step[0]), max(turned, step[1])
        if moved > outcome.GONE_MM:
            return moved, turned, True
    return moved, turned, cell.on_table()


def _turn(start: np.ndarray, cell: Cell) -> list[np.ndarray]:
    references = []
    corners = [0.0, TURN, -TURN, 0.0]
    for a, b in itertools.pairwise(corners):
        path = np.array([start, start])
        path[:, 5] += (a, b)
        ticks = round(TURN_TIME * abs(b - a) / TURN / cell.tick_time)
        references += [along(path, k / ticks) for k in range(1, ticks + 1)]
    return references + [references[-1]] * round(STILL / cell.tick_time)


def _shake(start: np.ndarray, cell: Cell) -> list[np.ndarray]:
    arm = arm_kinematics()
    position, rotation = arm.palm_pose(start)
    sideways = SHAKE_AMPLITUDE * rotation[:, 0]
    ends = [arm.solve(position + sign * sideways, rotation, start) for sign in (-1.0, 1.0)]
    if ends[0] is None or ends[1] is None:  # at the edge of the arm's reach: shake joint 1 alone
        swing = SHAKE_AMPLITUDE / max(float(np.linalg.norm(position[:2])), SHAKE_AMPLITUDE)
        ends = [start.copy(), start.copy()]
        ends[0][0] -= swing
        ends[1][0] += swing
    ticks = round(SHAKE_TIME / cell.tick_time)
    references = []
    for k in range(1, ticks + 1):
        t = k * cell.tick_time
        ramp = min(1.0, 2.0 * t, 2.0 * (SHAKE_TIME - t))  # swells and fades over half a second
        s = ramp * math.sin(2 * math.pi * SHAKE_FREQUENCY * t)
        references.append(start + s * ((ends[1] if s > 0 else ends[0]) - start) * np.sign(s))
    return references + [start] * round(STILL / cell.tick_time)
