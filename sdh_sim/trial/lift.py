"""Lift and hold, watching how far the object moves in the hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sdh_sim.cell import Simulation
from sdh_sim.grasping import MotionPlan
from sdh_sim.robot import along
from sdh_sim.trial.outcome import Motion, watch

LIFT_TIME, HOLD_TIME = 1.5, 2.0  # [s]


def lift(simulation: Simulation, motion: MotionPlan, before: np.ndarray) -> Motion:
    """Lift and hold.

    Args:
        simulation: at the snapshot.
        motion: with the arm's path.
        before: pose of the object in the hand at the snapshot (7,).

    Raises:
        Diverged: the simulation did.
    """
    return watch(simulation, before, _references(simulation, motion))


def _references(simulation: Simulation, motion: MotionPlan) -> Iterator[np.ndarray]:
    duration = simulation.scene.palm_motion.duration(motion.lift, LIFT_TIME)
    for k in range(1, round((duration + HOLD_TIME) / simulation.tick_time) + 1):
        share = k * simulation.tick_time / duration
        simulation.phase = "lift" if share <= 1.0 else "hold"
        yield along(motion.lift, share)
