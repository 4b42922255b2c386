"""Lift and hold, watching how far the object moves in the hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sdh_sim.cell import Simulation
from sdh_sim.grasping import MotionPlan
from sdh_sim.grasping.motion_plan import LIFT_HEIGHT
from sdh_sim.robot.palm_motion import at, minimum_jerk
from sdh_sim.trial.outcome import Motion, watch

LIFT_TIME, HOLD_TIME = 1.5, 2.0  # [s]
# Until the object has left the table the hand rises slowly; it has left when it has not touched for
# so long. One that still touches when the hand has risen by the largest rise has moved in the hand
# by more than a held object may (or stands on an edge): nothing is won by waiting longer.
RISE_SPEED = 0.013  # [m/s]
LARGEST_RISE = 0.012  # [m]
OFF_FOR = 0.1  # [s]
REST = 0.5  # [s] before the snapshot at lift-off


def rise(simulation: Simulation, motion: MotionPlan, before: np.ndarray) -> tuple[Motion, float]:
    """Raise the hand until the object has left the table, and come to rest.

    Args:
        simulation: at the snapshot.
        motion: with the arm's path.
        before: pose of the object in the hand at the snapshot (7,).

    Returns:
        the motion in the hand so far, and the share of the lift's path that is behind.

    Raises:
        Diverged: the simulation did.
    """
    risen = [0.0]
    moved = watch(simulation, before, _rising(simulation, motion, risen))
    return moved, risen[0]


def _rising(simulation: Simulation, motion: MotionPlan, risen: list[float]) -> Iterator[np.ndarray]:
    """References of the arm; ``risen`` receives the share of the path that is behind.

    An object that sinks back to the table while the hand rests is raised further.
    """
    simulation.phase = "lift-off"
    step, largest = simulation.tick_time * RISE_SPEED / LIFT_HEIGHT, LARGEST_RISE / LIFT_HEIGHT
    while risen[0] < largest:
        free = 0
        while risen[0] < largest and free * simulation.tick_time < OFF_FOR:
            risen[0] = min(risen[0] + step, largest)
            yield at(motion.lift, risen[0])
            free = 0 if simulation.on_table() else free + 1
        for _ in range(round(REST / simulation.tick_time)):
            yield at(motion.lift, risen[0])
        if not simulation.on_table():
            return


def lift(
    simulation: Simulation, motion: MotionPlan, before: np.ndarray, risen: float = 0.0
) -> Motion:
    """Lift and hold.

    Args:
        simulation: at the snapshot, or where ``rise`` left it.
        motion: with the arm's path.
        before: pose of the object in the hand at the snapshot (7,).
        risen: share of the path that is behind.

    Raises:
        Diverged: the simulation did.
    """
    return watch(simulation, before, _references(simulation, motion, risen))


def _references(simulation: Simulation, motion: MotionPlan, risen: float) -> Iterator[np.ndarray]:
    duration = simulation.scene.palm_motion.duration(motion.lift, LIFT_TIME)
    for k in range(1, round((duration + HOLD_TIME) / simulation.tick_time) + 1):
        share = k * simulation.tick_time / duration
        simulation.phase = "lift" if share <= 1.0 else "hold"
        yield at(motion.lift, risen + (1.0 - risen) * minimum_jerk(share))
