"""What a grasp does in Drake from its snapshot on: the lift and the load ramp of the trials."""

from __future__ import annotations

from collections.abc import Iterator

from experiments.two_engines.engine import DrakeSimulation
from sdh_sim.grasping.motion_plan import LIFT_HEIGHT
from sdh_sim.robot.palm_motion import minimum_jerk
from sdh_sim.trial.lift import HOLD_TIME, LIFT_TIME
from sdh_sim.trial.load_test import CAP, COARSE, FINE, LIMITS, SETTLE, STEP_BACK, Failure
from sdh_sim.trial.outcome import Motion, gave_way, moved_between

FURTHEST = (20.0, 20.0)  # motion beyond which an object is not followed: it has failed [mm, deg]


def lift(simulation: DrakeSimulation, duration: float = LIFT_TIME) -> Motion:
    """Lift and hold from the snapshot.

    Args:
        simulation: at the snapshot.
        duration: of the lift [s].

    Returns:
        the motion in the hand; one beyond ``FURTHEST`` counts as fallen and is not followed.

    Raises:
        Diverged: the simulation did.
    """
    before, com = simulation.object_in_hand(), simulation.made.scene.obj.com_m
    moved = turned = 0.0
    for height in _heights(simulation, duration):
        if simulation.made.alignment.lift:
            simulation.tick(rise=height)
        else:
            simulation.tick(table=-height)
        step = moved_between(before, simulation.object_in_hand(), com)
        moved, turned = max(moved, step[0]), max(turned, step[1])
        if moved > FURTHEST[0] or turned > FURTHEST[1]:
            return Motion(moved, turned, True)
    return Motion(moved, turned, simulation.on_table())


def _heights(simulation: DrakeSimulation, duration: float) -> Iterator[float]:
    for k in range(1, round((duration + HOLD_TIME) / simulation.tick_time) + 1):
        yield LIFT_HEIGHT * minimum_jerk(k * simulation.tick_time / duration)


def gravity_factor(simulation: DrakeSimulation) -> Failure:
    """Take the table away and let the weight grow until the object gives way, as for ``q_sim``.

    Args:
        simulation: at the snapshot; left anywhere.

    Raises:
        Diverged: the simulation did.
    """
    com = simulation.made.scene.obj.com_m
    simulation.without_table()
    simulation.set_weight(0.0)
    before = simulation.object_in_hand()

    def exceeded() -> bool:
        return gave_way(before, simulation.object_in_hand(), com, *LIMITS)

    for _ in range(round(SETTLE / simulation.tick_time)):
        simulation.tick()
    if exceeded():
        return Failure(0.0, False)
    states = [(0.0, simulation.save())]
    size = 0.0
    for rate in (COARSE, FINE):
        while True:
            if size >= CAP:
                return Failure(CAP, True)
            size += rate * max(size, 1.0) * simulation.tick_time
            simulation.set_weight(size)
            simulation.tick()
            if exceeded():
                break
            if rate == COARSE and size > 1.05 * states[-1][0] + 0.02:
                states.append((size, simulation.save()))
        if rate == COARSE:
            earlier = [s for s in states if s[0] <= STEP_BACK * size]
            size, state = max(earlier, default=states[0], key=lambda s: s[0])
            simulation.restore(state)
    return Failure(size, False)
