"""How much load a grasp holds: a quasi-static ramp of force or moment until the object gives way.

This is the simulated counterpart of q*: the factor by which the object's weight can be scaled
before it slips in the hand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdh_sim.cell import Simulation
from sdh_sim.poses import rotate
from sdh_sim.sensing import GRAVITY
from sdh_sim.trial import outcome

# Motion in the hand that counts as giving way [mm, deg]: since the grasp was made, as in the lift;
# for loads beside the weight of a lifted object, since they began to grow.
LIMITS = (outcome.MAX_DISPLACEMENT_MM, outcome.MAX_ROTATION_DEG)
LIFTED_LIMITS = (2.0, 2.0)
COARSE, FINE = 0.5, 0.06  # growth of the load per second, as a share of it (of the weight below 1)
STEP_BACK = 0.85  # the fine ramp starts where the load was this share of the coarse result
SETTLE = 0.3  # [s] for the hand to find its balance without table or weight
CAP = 20.0  # loads beyond this many weights are not looked for
MOMENT_ARM = 0.1  # a pure moment of weight times this arm counts as load 1 [m]

# Force and moment at the centre of mass per unit of load, in the hand frame.
DIRECTIONS = {
    "+x": (1, 0, 0, 0, 0, 0), "-x": (-1, 0, 0, 0, 0, 0),
    "+y": (0, 1, 0, 0, 0, 0), "-y": (0, -1, 0, 0, 0, 0),
    "+z": (0, 0, 1, 0, 0, 0), "-z": (0, 0, -1, 0, 0, 0),
    "mx": (0, 0, 0, 1, 0, 0), "my": (0, 0, 0, 0, 1, 0), "mz": (0, 0, 0, 0, 0, 1),
}  # fmt: skip


WORLD_DOWN = np.array([0.0, 0.0, -1.0])


class _Load(NamedTuple):
    """What grows in a ramp.

    Attributes:
        wrench: force and moment at the centre of mass per unit of load, in weights (6,).
        in_hand: in the axes of the hand; else of the world.
        carried: of the load applied, what gravity does itself.
        point: of the object, where a force in the axes of the world acts: from the centre of mass
            in the object's axes (3,) [m]; None: there.
    """

    wrench: np.ndarray
    in_hand: bool
    carried: float
    point: np.ndarray | None = None


@dataclass(frozen=True)
class Failure:
    """Where a ramp ended.

    Attributes:
        load: load at which the object gave way, in weights (moments: weight times MOMENT_ARM).
        capped: the object held the largest load that is looked for; ``load`` is that one.
    """

    load: float
    capped: bool


def gravity_factor(
    simulation: Simulation,
    speed: float = 1.0,
    down: np.ndarray = WORLD_DOWN,
    point: np.ndarray | None = None,
) -> Failure:
    """Take the table away and let the object's weight grow from nothing until it gives way (q_sim).

    It has given way when it has moved further in the hand than a held object may in the lift,
    since the start: the same for grasps that the lift finds to hold and for those that fail.

    Args:
        simulation: at rest with the object in the hand, as at the snapshot; left anywhere.
        speed: factor on the rates of the ramps, to show that they do not matter.
        down: direction of the weight in the world (3,), of length 1.
        point: of the object where the weight acts, to ask for other centres of mass: from the
            object's own in its axes (3,) [m]; None: there.

    Returns:
        load: the factor, 0 when the object moves even without weight.

    Raises:
        Diverged: the simulation did.
    """
    simulation.phase = "load"
    by_gravity = 1.0 if simulation.scene.model.opt.gravity.any() else 0.0
    load = _Load(np.concatenate((down, np.zeros(3))), False, by_gravity, point)
    with simulation.without_table():
        _apply(simulation, load, 0.0)
        before = simulation.object_in_hand()
        simulation.wait(SETTLE)
        limit = _Limit(before, *LIMITS)
        if limit.exceeded(simulation):
            return Failure(0.0, False)
        return _two_ramps(simulation, load, speed, limit)


def direction_loads(simulation: Simulation, speed: float = 1.0) -> np.ndarray:
    """Load at failure along every entry of DIRECTIONS, beside the weight.

    Args:
        simulation: at rest with the object lifted; left as it came.
        speed: as in ``gravity_factor``.

    Returns:
        forces [N] and moments [N m] (9,), inf where the cap was reached.
    """
    simulation.phase = "load"
    state, loads = simulation.save(), []
    weight = simulation.scene.obj.mass_kg * GRAVITY
    for name, direction in DIRECTIONS.items():
        simulation.restore(state)
        wrench = np.array(direction, dtype=float)
        wrench[3:] *= MOMENT_ARM
        limit = _Limit(simulation.object_in_hand(), *LIFTED_LIMITS)
        result = _two_ramps(simulation, _Load(wrench, True, 0.0), speed, limit)
        unit = weight * MOMENT_ARM if name.startswith("m") else weight
        loads.append(math.inf if result.capped else result.load * unit)
    simulation.restore(state)
    return np.array(loads)


class _Limit(NamedTuple):
    """Motion of the object in the hand that counts as giving way.

    Attributes:
        before: pose in the hand that it counts from (7,).
        displacement_mm, rotation_deg: greatest motion that is none.
    """

    before: np.ndarray
    displacement_mm: float
    rotation_deg: float

    def exceeded(self, simulation: Simulation) -> bool:
        """Whether the object has moved further."""
        now, com = simulation.object_in_hand(), simulation.scene.obj.com_m
        return outcome.gave_way(self.before, now, com, self.displacement_mm, self.rotation_deg)


def _two_ramps(simulation: Simulation, load: _Load, speed: float, limit: _Limit) -> Failure:
    """A quick ramp finds where to look, a slow one from shortly before it finds the load.

    Args:
        simulation: with the object in the hand.
        load: what grows.
        speed: factor on both rates.
        limit: what counts as giving way.
    """
    states = [(0.0, simulation.save())]
    coarse = _ramp(simulation, load, 0.0, COARSE * speed, limit, states)
    if coarse.capped:
        return coarse
    before = [s for s in states if s[0] <= STEP_BACK * coarse.load]
    lower, state = max(before, default=states[0], key=lambda s: s[0])
    simulation.restore(state)
    return _ramp(simulation, load, lower, FINE * speed, limit, None)


def _ramp(
    simulation: Simulation,
    load: _Load,
    size: float,
    rate: float,
    limit: _Limit,
    states: list[tuple[float, np.ndarray]] | None,
) -> Failure:
    """Let the load grow until the object gives way; ``states`` takes states on the way."""
    while size < CAP:
        size += rate * max(size, 1.0) * simulation.tick_time
        _apply(simulation, load, size)
        simulation.tick()
        if limit.exceeded(simulation):
            return Failure(size, False)
        if states is not None and size > 1.05 * states[-1][0] + 0.02:
            states.append((size, simulation.save()))
    return Failure(CAP, True)


def _apply(simulation: Simulation, load: _Load, size: float) -> None:
    """Put a load on the object's centre of mass [weights]."""
    data, scene = simulation.data, simulation.scene
    weight = scene.obj.mass_kg * GRAVITY
    unit = load.wrench * (weight * (size - load.carried))
    if load.in_hand:
        hand = simulation.pose(scene.palm)[3:]
        unit = np.concatenate((rotate(hand, unit[:3]), rotate(hand, unit[3:])))
    if load.point is not None:
        arm = rotate(data.xquat[scene.object_body], load.point)
        unit[3:] += np.cross(arm, load.wrench[:3]) * (weight * size)
    data.xfrc_applied[scene.object_body] = unit
