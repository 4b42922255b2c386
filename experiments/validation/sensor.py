"""Check of the tactile arrays' creep: published slopes, and the law behind them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.validation.friction import clamp
from experiments.validation.result_rows import Result, Row
from experiments.validation.rigs import HONEST, Spoil
from sdh_sim.cell.contacts import taxel_forces
from sdh_sim.sensing import SensorModel, TactileSensor
from sdh_sim.sensing.tactile_sensor import FRAME_RATE

# Slope of the sum of counts [1/N] at a time after contact [s], published for a distal pad.
PUBLISHED = {0.5: 2810.0, 3.0: 4513.0, 10.0: 5074.0}


def sensor_creep(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Readings of pads that hold a box still, over time since contact.

    A standard linear solid under a step of pressure p reads p (1 - a exp(-t / T)) of its final
    value; the two parameters are fitted to three published slopes.
    """
    scene, rest = clamp((1.6401, 1.0934))
    forces = taxel_forces(scene, rest)
    forces *= 5.0 / forces.sum()  # far from the clip
    model = SensorModel(noise=0.0, gain_spread=0.0, dead_zone=0.0)
    creeping = replace(model, creep_time=model.creep_time * spoil.creep)
    sensor = TactileSensor(creeping, np.random.default_rng(0))
    times, sums = [], []
    for frame in range(1, round(10.0 * FRAME_RATE) + 1):
        sensor.frame(forces)
        times.append(frame / FRAME_RATE)
        sums.append(float(sensor.read().sum()) * model.gain)
    rows = [
        Row(
            f"sum of counts per newton, {t:g} s", "1/N", slope,
            float(np.interp(t, times, sums)) / forces.sum(), 0.03,
            "two parameters fit three slopes; whole counts per taxel",
        )
        for t, slope in PUBLISHED.items()
    ]  # fmt: skip
    for t in (1.0,) if short else (1.0, 2.0, 5.0):
        late = 1.0 - model.creep_share * np.exp(-t / model.creep_time)
        final = 1.0 - model.creep_share * np.exp(-10.0 / model.creep_time)
        rows.append(Row(
            f"share of the reading at 10 s after {t:g} s", "1", late / final,
            float(np.interp(t, times, sums)) / sums[-1], 0.01,
            "whole counts per taxel",
        ))  # fmt: skip
    return Result(tuple(rows), {"time": np.array(times), "counts": np.array(sums)})
