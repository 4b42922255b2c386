"""How sure a label is: the same grasp again and again, each time slightly wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sdh_sim import outcome
from sdh_sim.acquire import acquire
from sdh_sim.cell import Cell, Diverged
from sdh_sim.course import Course, plan_course
from sdh_sim.lifting import lift
from sdh_sim.objects import ObjectInfo
from sdh_sim.rate import Rate
from sdh_sim.scene import Scene

DRAWS = 20  # infeasible copies are drawn again, at most so often


def repeat_trial(
    scene: Scene, thing: ObjectInfo, course: Course, rng: np.random.Generator
) -> Rate:
    """Share of perturbed copies that hold, of ``settings.repeats`` with feasible motion.

    The hand's position and roll and the friction carry noise of their own in each copy.
    """
    count = held = 0
    for _ in range(scene.settings.repeats):
        copy = _perturbed(scene, thing, course, rng)
        factor = 1.0 + scene.settings.repeat_friction * float(rng.standard_normal())
        if copy is None:
            continue
        count += 1
        held += _holds(scene, thing, copy, max(factor, 0.05))
    return Rate(held, count)


def _perturbed(
    scene: Scene, thing: ObjectInfo, course: Course, rng: np.random.Generator
) -> Course | None:
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


def _holds(scene: Scene, thing: ObjectInfo, course: Course, friction: float) -> bool:
    cell = Cell(scene)
    with cell.friction_scaled(friction):
        try:
            acquire(cell, thing, course)
            if sum(cell.hand_touch()) == 0.0:
                return False
            moved, turned, fell = lift(cell, thing, course, cell.object_in_hand())
        except Diverged:
            return False
    return outcome.classify(True, fell, moved, turned) == "none"
