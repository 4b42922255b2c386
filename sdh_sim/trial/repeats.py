"""How sure a label is: the same grasp again and again, each time slightly wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cell.scene import Scene
from sdh_sim.cell.simulation import Cell
from sdh_sim.errors import Diverged
from sdh_sim.grasping.acquire import acquire
from sdh_sim.grasping.motion_plan import Course, plan_course
from sdh_sim.objects.catalogue import ObjectInfo
from sdh_sim.trial import outcome
from sdh_sim.trial.lift import lift

DRAWS = 20  # infeasible copies are drawn again, at most so often


def repeat_trial(
    scene: Scene, thing: ObjectInfo, course: Course, rng: np.random.Generator
) -> Proportion:
    """Share of perturbed copies that hold, of ``settings.repeats`` with feasible motion.

    The hand's position and roll and the friction carry noise of their own in each copy.
    """
    count = held = 0
    for _ in range(scene.settings.repeats):
        copy = perturbed(scene, thing, course, rng)
        factor = 1.0 + scene.settings.repeat_friction * float(rng.standard_normal())
        if copy is None:
            continue
        count += 1
        held += grasp_and_lift(scene, thing, copy, max(factor, 0.05))[0] == "none"
    return Proportion(held, count)


def perturbed(
    scene: Scene, thing: ObjectInfo, course: Course, rng: np.random.Generator
) -> Course | None:
    """The course with the noise of ``settings`` on the hand's position and roll.

    None where none of the draws is feasible.
    """
    settings = scene.settings
    for _ in range(DRAWS):
        plan = replace(
            course.plan,
            offset=course.plan.offset + settings.repeat_position * rng.standard_normal(3),
            roll=course.plan.roll + settings.repeat_angle * float(rng.standard_normal()),
        )
        found = plan_course(scene, thing, plan)
        if isinstance(found, Course):
            return found
    return None


def grasp_and_lift(
    scene: Scene, thing: ObjectInfo, course: Course, friction: float = 1.0
) -> tuple[str, float, float]:
    """Run a trial's grasp and lift alone.

    Args:
        scene, thing, course: as of a trial.
        friction: factor on the friction between hand and object.

    Returns:
        how it failed (``none``: it held), greatest displacement [mm] and rotation [deg] of the
        object in the hand, NaN where there was no contact or the simulation diverged.
    """
    cell = Cell(scene)
    with cell.friction_scaled(friction):
        try:
            acquire(cell, thing, course)
            if sum(cell.hand_touch()) == 0.0:
                return "no_contact", math.nan, math.nan
            moved, turned, fell = lift(cell, thing, course, cell.object_in_hand())
        except Diverged:
            return "unstable_simulation", math.nan, math.nan
    return outcome.classify(True, fell, moved, turned), moved, turned
