"""How sure a label is: the same grasp again and again, each time slightly wrong."""

from __future__ import annotations

import numpy as np

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cell import Scene
from sdh_sim.grasping import MotionPlan, try_grasp
from sdh_sim.records import NO_TRUTH
from sdh_sim.trial.trial import Trial

DRAWS = 20  # infeasible copies are drawn again, at most so often
LEAST_FRICTION = 0.05  # of a copy, as a share of the object's


def repeat_trial(trial: Trial, rng: np.random.Generator) -> Proportion:
    """Share of perturbed copies of a trial that hold, of those with a feasible motion and an end.

    The hand's position and roll and the friction carry noise of their own in each of the
    ``settings.repeats`` copies. A copy whose simulation diverges says nothing and is not counted.
    """
    settings = trial.settings
    count = held = 0
    for _ in range(settings.repeats):
        motion = perturbed(trial.scene, trial.motion, rng)
        factor = 1.0 + settings.repeat_friction * float(rng.standard_normal())
        if motion is None:
            continue
        copy = Trial(settings, trial.seed, scene=trial.scene, motion=motion)
        with copy.simulation.friction_scaled(max(factor, LEAST_FRICTION)):
            failure, _ = copy.grasp_and_lift()
        if failure in NO_TRUTH:
            continue
        count += 1
        held += failure == "none"
    return Proportion(held, count)


def perturbed(scene: Scene, motion: MotionPlan, rng: np.random.Generator) -> MotionPlan | None:
    """The motion with the noise of the scene's settings on the hand's position and roll.

    None where none of the draws is feasible.
    """
    settings, grasp = scene.settings, motion.grasp
    for _ in range(DRAWS):
        offset = settings.repeat_position * rng.standard_normal(3)
        roll = settings.repeat_angle * float(rng.standard_normal())
        found = try_grasp(scene, grasp.moved(offset, roll))
        if isinstance(found, MotionPlan):
            return found
    return None
