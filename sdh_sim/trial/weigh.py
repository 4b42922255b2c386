"""Put an object's weight into the hand without lifting anything, and see whether it stays."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sdh_sim.cell import Simulation
from sdh_sim.sensing import GRAVITY
from sdh_sim.trial.lift import HOLD_TIME
from sdh_sim.trial.outcome import Motion, watch

RAMP_TIME = 0.5  # [s] over which the weight grows


def weigh(simulation: Simulation, down: np.ndarray, before: np.ndarray) -> Motion:
    """Let the weight grow along a direction, and hold.

    Args:
        simulation: at the snapshot of a scene without table and gravity.
        down: direction of the weight in the world (3,), of length 1.
        before: pose of the object in the hand at the snapshot (7,).

    Raises:
        Diverged: the simulation did.
    """
    return watch(simulation, before, _references(simulation, down))


def _references(simulation: Simulation, down: np.ndarray) -> Iterator[np.ndarray]:
    scene, data = simulation.scene, simulation.data
    weight = scene.obj.mass_kg * GRAVITY * down
    still = data.ctrl[scene.arm_motors].copy()
    ticks = round((RAMP_TIME + HOLD_TIME) / simulation.tick_time)
    for k in range(1, ticks + 1):
        share = min(1.0, k * simulation.tick_time / RAMP_TIME)
        simulation.phase = "weigh" if share < 1.0 else "hold"
        data.xfrc_applied[scene.object_body, :3] = share * weight
        yield still
