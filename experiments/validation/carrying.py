"""Check of motion: an object in the hand while the arm speeds up and slows down."""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.validation.result_rows import Result, Row
from experiments.validation.rigs import HONEST, Spoil, timestep_in_use
from sdh_sim.cell import Scene, Simulation, build_scene
from sdh_sim.grasping import MotionPlan
from sdh_sim.robot import along
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from sdh_sim.trial.lift import LIFT_TIME

# Held through the lift, with and without help from parts of the hand that have no taxels.
GRASPS = (("cylindrical_bottle", 1), ("oval_bottle", 2), ("spray_bottle", 1), ("spray_bottle", 2))
# Held as well, but sliding: where an object comes to a stop hangs on more than the integrator.
SLIDING = (("box", 1), ("cylindrical_bottle", 0))
FINEST = 0.0005  # time step that the others are compared with [s]
LABEL = 10_000.0  # motion that decides the label [µm]
PER_STEP = 0.003  # of it that the place may be off per millisecond of time step
SAMPLE = 0.02  # [s]


def _scene(name: str, timestep: float, implicit: bool) -> Scene:
    scene = build_scene(TrialSettings(name, timestep=timestep))
    if implicit:
        scene.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return scene


def _path(scene: Scene, motion: MotionPlan, state: np.ndarray) -> np.ndarray:
    """Places of the object in the hand (n, 3) [m] through the lift, from one state of the grasp."""
    simulation = Simulation(scene)
    simulation.restore(state)
    duration = simulation.scene.palm_motion.duration(motion.lift, LIFT_TIME)
    places = [simulation.object_in_hand()[:3]]
    for k in range(1, round(duration / simulation.tick_time) + 1):
        simulation.tick(along(motion.lift, k * simulation.tick_time / duration))
        places.append(simulation.object_in_hand()[:3])
    times = simulation.tick_time * np.arange(len(places))
    wanted = np.arange(0.0, duration, SAMPLE)
    return np.column_stack([np.interp(wanted, times, axis) for axis in np.array(places).T])


def carry(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """The way of a held object in the hand through the lift, under other time steps.

    All variants start from the same state of the same grasp. An integrator that takes damping
    implicitly changes the accelerations that the contact solver chose; what a damped arm is held
    back by, the object is not, and slips by that much over the rate at which friction decays,
    in proportion to the time step. Shown for contrast in the picture. Grasps that slide are noted,
    not judged.
    """
    usual = timestep_in_use.get()
    steps = (usual,) if short else (0.001, 0.002, 0.004)
    rows, curves = [], {}
    for name, seed in GRASPS[:1] if short else GRASPS + SLIDING:
        trial = Trial(TrialSettings(name, timestep=usual), seed, scene=_scene(name, usual, False))
        trial.acquire()
        motion, state = trial.motion, trial.simulation.save()
        finest = _path(_scene(name, FINEST, False), motion, state)
        ways = {}
        for step in steps:
            ways[step] = _path(_scene(name, step, spoil.implicit), motion, state)
            off = float(np.linalg.norm(ways[step] - finest, axis=1).max())
            rows.append(Row(
                f"{name}, seed {seed}: place in the lift, dt {1e3 * step:g} ms", "µm", 0.0,
                1e6 * off, PER_STEP * 1e3 * step,
                "first order in the time step; 10 mm decide the label", scale=LABEL,
                judged=(name, seed) not in SLIDING,
            ))  # fmt: skip
        implicit = _path(_scene(name, usual, True), motion, state)
        curves[f"{name}, seed {seed}"] = (finest, ways, implicit)
    return Result(tuple(rows), {"ways": curves, "implicit": usual})
