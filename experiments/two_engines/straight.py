"""The trial's own engine with the hand lifted along a straight line, without an arm.

MuJoCo's constraints leave out how fast their directions turn: while the joints of an arm turn, what
the hand holds is pressed aside and slips a little, in proportion to the square of their speed.
A hand that slides upwards has nothing that turns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import mujoco
import numpy as np

from experiments.two_engines.start import Start
from sdh_sim.cell import Scene, Simulation, scene_of
from sdh_sim.grasping.motion_plan import LIFT_HEIGHT
from sdh_sim.poses import rotation_of
from sdh_sim.robot.palm_motion import minimum_jerk
from sdh_sim.trial.lift import HOLD_TIME
from sdh_sim.trial.outcome import Motion, watch

UP = 2  # number of the base's joint along the world's z


def straight_lift(start: Start, change: Callable[[Scene], Scene] = lambda scene: scene) -> Motion:
    """Lift and hold in MuJoCo from the snapshot, the hand on a base that slides upwards.

    Args:
        start: the snapshot.
        change: makes another scene of the usual one, such as with another friction.

    Raises:
        Diverged: the simulation did.
    """
    scene = change(scene_of(replace(start.scene.settings, arm="none")))
    simulation = Simulation(scene)
    data = simulation.data
    mujoco.mj_resetData(scene.model, data)
    base = scene.palm_motion.reach(start.palm[:3], rotation_of(start.palm[3:]))
    assert base is not None  # a floating hand reaches all
    data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = base
    for here, there in zip(scene.hand_qpos, start.scene.hand_qpos, strict=True):
        data.qpos[here] = start.qpos[there]
    data.qpos[scene.object_qpos : scene.object_qpos + 7] = start.obj
    data.ctrl[scene.motors] = start.references
    mujoco.mj_forward(scene.model, data)
    references = _rising(simulation, base, start.lift_time)
    return watch(simulation, simulation.object_in_hand(), references)


def _rising(simulation: Simulation, base: np.ndarray, duration: float) -> Iterator[np.ndarray]:
    for k in range(1, round((duration + HOLD_TIME) / simulation.tick_time) + 1):
        reference = base.copy()
        reference[UP] += LIFT_HEIGHT * minimum_jerk(k * simulation.tick_time / duration)
        yield reference
