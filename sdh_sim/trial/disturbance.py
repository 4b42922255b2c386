"""After the lift: turn the wrist or shake the hand, and see whether the object stays."""

from __future__ import annotations

import itertools
import math

import numpy as np

from sdh_sim.cell import Simulation
from sdh_sim.robot import along
from sdh_sim.trial.outcome import Motion, watch

TURN = math.radians(120)  # of the wrist, either way
TURN_TIME = 1.5  # [s] for 120 degrees
SHAKE_AMPLITUDE, SHAKE_FREQUENCY, SHAKE_TIME = 0.02, 2.0, 2.0  # [m], [Hz], [s]; peak 3.2 m/s^2
STILL = 0.5  # [s] to wait at the end


def disturb(simulation: Simulation, kind: str) -> Motion:
    """Turn (``turn``: joint 6 by +120, -120 and back) or shake (``shake``: along the hand's x).

    Args:
        simulation: with the object lifted.
        kind: ``turn`` or ``shake``.

    Returns:
        motion of the object in the hand since the start.

    Raises:
        Diverged: the simulation did.
    """
    simulation.phase = kind
    start = simulation.data.ctrl[simulation.scene.arm_motors].copy()
    references = _turn(start, simulation) if kind == "turn" else _shake(start, simulation)
    return watch(simulation, simulation.object_in_hand(), references)


def _turn(start: np.ndarray, simulation: Simulation) -> list[np.ndarray]:
    references = []
    corners = [0.0, TURN, -TURN, 0.0]
    for a, b in itertools.pairwise(corners):
        path = np.array([start, start])
        path[:, 5] += (a, b)
        ticks = round(TURN_TIME * abs(b - a) / TURN / simulation.tick_time)
        references += [along(path, k / ticks) for k in range(1, ticks + 1)]
    return references + [references[-1]] * round(STILL / simulation.tick_time)


def _shake(start: np.ndarray, simulation: Simulation) -> list[np.ndarray]:
    arm = simulation.scene.palm_motion
    position, rotation = arm.palm_pose(start)
    sideways = SHAKE_AMPLITUDE * rotation[:, 0]
    ends = [arm.solve(position + sign * sideways, rotation, start) for sign in (-1.0, 1.0)]
    if ends[0] is None or ends[1] is None:  # at the edge of the arm's reach: shake joint 1 alone
        swing = SHAKE_AMPLITUDE / max(float(np.linalg.norm(position[:2])), SHAKE_AMPLITUDE)
        ends = [start.copy(), start.copy()]
        ends[0][0] -= swing
        ends[1][0] += swing
    ticks = round(SHAKE_TIME / simulation.tick_time)
    references = []
    for k in range(1, ticks + 1):
        t = k * simulation.tick_time
        ramp = min(1.0, 2.0 * t, 2.0 * (SHAKE_TIME - t))  # swells and fades over half a second
        s = ramp * math.sin(2 * math.pi * SHAKE_FREQUENCY * t)
        references.append(start + s * ((ends[1] if s > 0 else ends[0]) - start) * np.sign(s))
    return references + [start] * round(STILL / simulation.tick_time)
