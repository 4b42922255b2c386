"""How much load a grasp holds: a quasi-static ramp of force or moment until the object gives way.

This is the simulated counterpart of q*: the factor by which the object's weight can be scaled
before it slips in the hand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from sdh_sim.cell.simulation import Cell
from sdh_sim.objects.catalogue import ObjectInfo
from sdh_sim.sensing.perceived_grasp import GRAVITY
from sdh_sim.trial import outcome

# Motion in the hand since the start of a ramp that counts as giving way [mm, deg]. A grasp that
# takes its load over from the table settles first, and is judged as in the lift.
HELD_LIMITS = (2.0, 2.0)
TAKEN_LIMITS = (outcome.MAX_DISPLACEMENT_MM, outcome.MAX_ROTATION_DEG)
COARSE, FINE = 0.5, 0.06  # growth of the load per second, as a share of it (of the weight below 1)
STEP_BACK = 0.85  # the fine ramp starts where the load was this share of the coarse result
SETTLE = 0.3  # [s] for the hand to find its balance without table or weight
CAP = 20.0  # loads beyond this many weights are not looked for
MOMENT_ARM = 0.1  # a pure moment of weight times this arm counts as load 1 [m]

# Force and moment at the centre of mass per unit of load, in the hand frame; down is the world's.
DIRECTIONS = {
    "down": None,
    "+x": (1, 0, 0, 0, 0, 0), "-x": (-1, 0, 0, 0, 0, 0),
    "+y": (0, 1, 0, 0, 0, 0), "-y": (0, -1, 0, 0, 0, 0),
    "+z": (0, 0, 1, 0, 0, 0), "-z": (0, 0, -1, 0, 0, 0),
    "mx": (0, 0, 0, 1, 0, 0), "my": (0, 0, 0, 0, 1, 0), "mz": (0, 0, 0, 0, 0, 1),
}  # fmt: skip


@dataclass(frozen=True)
class Failure:
    """Where a ramp ended.

    Attributes:
        load: load at which the object gave way, in weights (moments: weight times MOMENT_ARM).
        capped: the object held the largest load that is looked for; ``load`` is that one.
    """

    load: float
    capped: bool


def gravity_factor(cell: Cell, thing: ObjectInfo, start: float, speed: float = 1.0) -> Failure:
    """Scale the object's weight from ``start`` upwards until it gives way (q_sim).

    Args:
        cell: at rest with the object in the hand; left anywhere.
        thing: the object.
        start: 1 with the object's weight in the hand; 0 to take the table away and let the
            weight grow from nothing.
        speed: factor on the rates of the ramps, to show that they do not matter.

    Returns:
        load: the factor, 0 when the object moves even without weight.

    Raises:
        Diverged: the simulation did.
    """
    cell.phase = "load"
    if start > 0.0:
        return _two_ramps(cell, thing, "down", start, start, speed)
    with cell.without_table():
        _apply(cell, thing, "down", 0.0 - 1.0)
        before = cell.object_in_hand()
        cell.wait(SETTLE)
        if outcome.gave_way(before, cell.object_in_hand(), thing.com_m, *TAKEN_LIMITS):
            return Failure(0.0, False)
        return _two_ramps(cell, thing, "down", 0.0, 1.0, speed, before)


def direction_loads(cell: Cell, thing: ObjectInfo, speed: float = 1.0) -> np.ndarray:
    """Load at failure along every entry of DIRECTIONS but the first, beside the weight.

    Args:
        cell: at rest with the object lifted; left as it came.
        thing: the object.
        speed: as in ``gravity_factor``.

    Returns:
        forces [N] and moments [N m] (9,), inf where the cap was reached.
    """
    cell.phase = "load"
    state, loads = cell.save(), []
    weight = thing.mass_kg * GRAVITY
    for name in list(DIRECTIONS)[1:]:
        cell.restore(state)
        result = _two_ramps(cell, thing, name, 0.0, 0.0, speed)
        unit = weight * MOMENT_ARM if name.startswith("m") else weight
        loads.append(math.inf if result.capped else result.load * unit)
    cell.restore(state)
    return np.array(loads)


def _two_ramps(
    cell: Cell, thing: ObjectInfo, name: str, start: float, carried: float, speed: float,
    taken: np.ndarray | None = None,
) -> Failure:  # fmt: skip
    """A quick ramp finds where to look, a slow one from shortly before it finds the load.

    Args:
        cell, thing, name: what and where.
        start: load at the beginning.
        carried: of the load applied, what gravity does itself.
        speed: factor on both rates.
        taken: pose at which the object stood when the hand began to take its weight over.
    """
    reference, limits = (
        (cell.object_in_hand(), HELD_LIMITS) if taken is None else (taken, TAKEN_LIMITS)
    )
    marks = [(start, cell.save())]
    coarse = _ramp(cell, thing, name, start, carried, COARSE * speed, reference, limits, marks)
    if coarse.capped:
        return coarse
    back = max((m for m in marks if m[0] <= STEP_BACK * coarse.load), default=marks[0],
               key=lambda m: m[0])  # fmt: skip
    cell.restore(back[1])
    return _ramp(cell, thing, name, back[0], carried, FINE * speed, reference, limits, None)


def _ramp(
    cell: Cell, thing: ObjectInfo, name: str, load: float, carried: float, rate: float,
    reference: np.ndarray, limits: tuple[float, float],
    marks: list[tuple[float, np.ndarray]] | None,
) -> Failure:  # fmt: skip
    while load < CAP:
        load += rate * max(load, 1.0) * cell.tick_time
        _apply(cell, thing, name, load - carried)
        cell.tick()
        if outcome.gave_way(reference, cell.object_in_hand(), thing.com_m, *limits):
            return Failure(load, False)
        if marks is not None and load > 1.05 * marks[-1][0] + 0.02:
            marks.append((load, cell.save()))
    return Failure(CAP, True)


def _apply(cell: Cell, thing: ObjectInfo, name: str, load: float) -> None:
    """Put a load on the object's centre of mass [weights]."""
    data, scene = cell.data, cell.scene
    weight = thing.mass_kg * GRAVITY * load
    wrench = data.xfrc_applied[scene.object]
    wrench[:] = 0.0
    direction = DIRECTIONS[name]
    if direction is None:
        wrench[2] = -weight
        return
    hand = data.xquat[scene.palm]
    unit = np.array(direction, dtype=float) * weight
    unit[3:] *= MOMENT_ARM
    mujoco.mju_rotVecQuat(wrench[:3], unit[:3], hand)
    mujoco.mju_rotVecQuat(wrench[3:], unit[3:], hand)
