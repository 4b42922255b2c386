"""Touch sensitivity: the force on a fixed load cell at the first frame in which a taxel reads.

The pad moves against the button at a constant speed; the arrays are read 30 times a second.
Closed form: a taxel reads above its dead zone p₀, so the force is p₀ A / s, where A is a taxel's
area and s the share of the force on the strongest taxel, crosstalk taken off. Of a new load only
1 - c of the final reading is there at once (creep, c = 0.587), which raises p₀. A fast finger
presses harder until the next frame comes, by one frame's growth of the force at most.
"""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np

from experiments.standard_tests.album import Album
from experiments.standard_tests.contact_forces import contact_forces
from experiments.standard_tests.finger_strength import axes_along, closing_senses, meet
from experiments.standard_tests.load_objects import CELL_TOP
from experiments.standard_tests.result_lines import Line
from experiments.standard_tests.specimen import Rig, Specimen
from sdh_sim.cell import Scene
from sdh_sim.cell.contacts import forces_beside_taxels, taxel_forces
from sdh_sim.errors import Diverged
from sdh_sim.robot import Hand, hand_kinematics
from sdh_sim.sensing.tactile_sensor import (
    CREEP_REFERENCE,
    FRAME_RATE,
    SensorModel,
    TactileSensor,
    spread_pressure,
    taxel_areas,
)

DSA = SensorModel()
SPEEDS = (0.002, 0.01, 0.05)  # of the pad towards the button [m/s]
GAP = 0.002  # between them at the start [m]
TOLERANCE = 0.25  # of the slowest: spread of the gains, whole counts, one frame's growth


class FirstReading:
    """An observer that reads the arrays frame by frame until a taxel reads something.

    Attributes:
        force: on the load cell along an axis at each frame [N].
        share: of the force on the strongest taxel at the first reading, crosstalk taken off.
        area: of that taxel [m^2].
        found: at which frame that was; None before.
    """

    def __init__(self, hand: Hand, axis: np.ndarray, seed: int) -> None:
        self._sensor = TactileSensor(DSA, np.random.default_rng(seed), hand)
        self._axis, self._next = axis, 0.0
        self.force: list[float] = []
        self.share = self.area = math.nan
        self.found: int | None = None

    def after_tick(self, scene: Scene, data: mujoco.MjData, phase: str) -> None:
        """Read the arrays when a frame is due."""
        if data.time < self._next or self.found is not None:
            return
        self._next += 1.0 / FRAME_RATE
        forces = taxel_forces(scene, data)
        self._sensor.frame(forces, forces_beside_taxels(scene, data))
        pressed = float(contact_forces(scene, data).forces.sum(axis=0) @ self._axis)
        self.force.append(pressed)
        readings = self._sensor.read()
        if pressed > 0.0 and (readings > 0.0).any():
            self.found = len(self.force) - 1
            areas = taxel_areas(scene.hand)
            spread = spread_pressure(forces / areas, DSA.crosstalk, scene.hand)
            k = int(np.argmax(spread))
            self.share, self.area = float(spread[k] * areas[k] / pressed), float(areas[k])


def least_pressure() -> float:
    """Pressure of a new load from which on a taxel reads something [Pa]."""
    reference = 1.0 - DSA.creep_share * math.exp(-CREEP_REFERENCE / DSA.creep_time)
    return 1e3 * DSA.dead_zone * reference / (1.0 - DSA.creep_share)


def touch_sensitivity(specimen: Specimen, cell: Path, seed: int, album: Album) -> list[Line]:
    """The outer pad of the first finger, at every speed; empty for a hand without pads."""
    hand = specimen.hand
    finger = hand.fingers[0]
    pads = [pad for pad in hand.pads if pad.body == finger.tip]
    if not pads:
        return []
    rig, lines = specimen.rig(cell), []
    for speed in SPEEDS:
        condition = f"{pads[0].name}, {1e3 * speed:g} mm/s"
        try:
            seen = touch(rig, pads[0].name, speed, seed)
        except Diverged:
            continue
        if seen.found is None:
            note = "no taxel reads before the motor is at its limit"
            lines.append(
                Line("touch_sensitivity", specimen.name, condition, math.nan, math.nan, note=note)
            )
            continue
        closed = least_pressure() * seen.area / seen.share
        force = seen.force[seen.found]
        gained = force - (seen.force[seen.found - 1] if seen.found else 0.0)
        slow = speed == SPEEDS[0]
        if slow:
            title = f"{specimen.name}:\n{pads[0].name}"
            album.take("touch_sensitivity", title, rig.scene, rig.simulation.data)
        lines.append(
            Line("touch_sensitivity", specimen.name, condition, closed, force,
                 TOLERANCE if slow else math.nan, f"{gained:.2f} N in the last frame")
        )  # fmt: skip
    return lines


def touch(rig: Rig, pad_name: str, speed: float, seed: int) -> FirstReading:
    """Move a pad against the load cell until a taxel reads; raises Diverged."""
    scene, simulation = rig.scene, rig.simulation
    hand = scene.hand
    pad = hand.pads[hand.pad_names.index(pad_name)]
    finger = next(k for k, f in enumerate(hand.fingers) if f.tip == pad.body)
    spans = np.array([motor.span for motor in hand.motors])
    angles = np.clip(np.zeros(len(spans)), *spans.T)
    posture = hand_kinematics(hand).at(angles)
    at, turn = posture.link(pad.body)
    rows, columns = pad.array.shape
    middle, normal = pad.array.surface(0.5 * (rows - 1), 0.5 * (columns - 1))
    point, axis = at + turn @ middle, turn @ normal
    point = point + axis * (meet(rig, finger, angles, point, axis) + GAP)
    levers = posture.of_motors(posture.jacobian(pad.body, point)).T @ axis
    stops = [k for k in hand.fingers[finger].stops if abs(levers[k]) > 1e-6]
    motor = stops[-1]
    sense = np.sign(levers[motor]) if levers[motor] else closing_senses(hand)[motor]
    rig.put(angles, point + axis * CELL_TOP, axes_along(axis))
    seen = FirstReading(hand, axis, seed)
    step = np.zeros(len(angles))
    step[motor] = sense * speed * simulation.tick_time / abs(levers[motor])
    with simulation.observed_by(seen):
        for k in range(1, round(2.0 / simulation.tick_time) + 1):
            simulation.tick(hand=angles + k * step)
            if seen.found is not None:
                break
    return seen
