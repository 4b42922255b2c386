"""From a grasp to a feasible motion: within reach, free of collisions, liftable."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim.cell import Scene
from sdh_sim.cell.contacts import robot_touches
from sdh_sim.errors import NoFeasibleGrasp
from sdh_sim.grasping.closing_arc import closing_arc
from sdh_sim.grasping.grasp_plan import GraspPlan, standing_pose
from sdh_sim.grasping.grasp_sampler import RandomGrasp, sample_grasp, what_fits

LIFT_HEIGHT = 0.15  # [m]
OPENINGS = (0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)  # closing ratios tried for the approach
MARGIN = 0.08  # of the closing ratio that an opening found here leaves free
MAX_DRAWS = 500
LEAST_FINGERS = 2  # that a random grasp must aim at the object
TURNS = 24  # directions in which a grasp of a user's own is tried, all around
UNREACHABLE, COLLIDING, MISSING = "unreachable", "colliding", "missing"


class Infeasible(NamedTuple):
    """Why a grasp has no motion.

    Attributes:
        kind: ``UNREACHABLE``, ``COLLIDING`` or ``MISSING`` (the fingers meet no object).
        reason: in words.
    """

    kind: str
    reason: str


@dataclass(frozen=True)
class MotionPlan:
    """A grasp with the arm's motion to it and up from it.

    Attributes:
        grasp: where the hand goes.
        approach, lift: joint paths of the arm (n, 6) [rad].
        opening: closing ratio during the approach.
        unreachable, colliding: grasps drawn before that the arm cannot reach or that collide.
    """

    grasp: GraspPlan
    approach: np.ndarray
    lift: np.ndarray
    opening: float
    unreachable: int = 0
    colliding: int = 0


def plan_motion(scene: Scene, rng: np.random.Generator) -> MotionPlan:
    """Draw grasps until one is within reach, free of collisions, and aimed at the object.

    Args:
        scene: with the object and the style of grasps in its settings.
        rng: of all that is random in them.

    Raises:
        NoFeasibleGrasp: none in ``MAX_DRAWS`` draws.
    """
    met = Counter[str]()
    for _ in range(MAX_DRAWS):
        drawn = sample_grasp(scene.hand, scene.obj, rng, scene.settings.grasps)
        found = try_grasp(scene, drawn.plan(scene.hand).as_given(scene.obj), aim=drawn)
        if isinstance(found, MotionPlan):
            return replace(
                found, unreachable=met[UNREACHABLE], colliding=met[COLLIDING] + met[MISSING]
            )
        met[found.kind] += 1
    counts = ", ".join(
        f"{met[kind]} {what}"
        for kind, what in (
            (UNREACHABLE, "out of reach"),
            (COLLIDING, "in collision"),
            (MISSING, "past the object"),
        )
    )
    raise NoFeasibleGrasp(
        f"no feasible grasp of {scene.obj.name} in {MAX_DRAWS} draws ({counts}); "
        + what_fits(scene.hand, scene.obj)
    )


def plan_given(scene: Scene, grasp: GraspPlan) -> MotionPlan | Infeasible:
    """The motion of a grasp that was given, or why there is none.

    One that may be turned is tried in directions all around, the given one first.
    """
    turns = range(TURNS if grasp.turnable else 1)
    failures: list[Infeasible] = []
    for turn in turns:
        turned = grasp.turned(turn * 2 * math.pi / TURNS) if turn else grasp
        found = try_grasp(scene, turned.as_given(scene.obj))
        if isinstance(found, MotionPlan):
            return found
        failures.append(found)
    # What came nearest to a motion says most.
    within_reach = [f for f in failures if f.kind != UNREACHABLE]
    return (within_reach or failures)[0]


def try_grasp(
    scene: Scene, grasp: GraspPlan, aim: RandomGrasp | None = None
) -> MotionPlan | Infeasible:
    """The motion of a grasp, or why there is none.

    Args:
        scene: with the object.
        grasp: where the hand goes.
        aim: the random grasp that it comes from. Where its fingers meet nothing, they would have to
            without its errors: an error may miss the object, a plan may not.
    """
    arm = scene.palm_motion
    rotation, position = grasp.palm_rotation, grasp.palm_position
    final = arm.reach(position, rotation)
    if final is None:
        return Infeasible(UNREACHABLE, "the arm cannot bring the palm there")
    back = arm.straight(final, -arm.standoff * rotation[:, 2])
    if back is None:
        return Infeasible(
            UNREACHABLE, f"the arm cannot approach along the palm's z from {arm.standoff:g} m away"
        )
    data = mujoco.MjData(scene.model)
    opening, met = _free_opening(scene, data, grasp, back)
    if opening is None:
        return Infeasible(COLLIDING, f"the open hand or the arm touches {met} on its way")
    place(scene, data, grasp, final, opening)
    arc = closing_arc(scene, data, grasp, opening)
    if arc.blocked_by:
        return Infeasible(COLLIDING, f"a closing finger meets {arc.blocked_by} before the object")
    if aim is not None and arc.sideways.sum() < LEAST_FINGERS:
        place(scene, data, grasp, final, opening)
        data.qpos[scene.object_qpos : scene.object_qpos + 3] += rotation @ aim.offset
        if closing_arc(scene, data, grasp, opening).sideways.sum() < LEAST_FINGERS:
            return Infeasible(MISSING, "the fingers close past the object")
    lift = arm.straight(final, np.array([0.0, 0.0, LIFT_HEIGHT]))
    if lift is None:
        return Infeasible(UNREACHABLE, f"the arm cannot lift the hand by {LIFT_HEIGHT:g} m")
    return MotionPlan(grasp, back[::-1], lift, opening)


def _free_opening(
    scene: Scene, data: mujoco.MjData, grasp: GraspPlan, path: np.ndarray
) -> tuple[float | None, str]:
    """The opening with which the approach touches nothing: the grasp's own, or the most closed.

    Args:
        scene: with the object.
        data: to try positions in; its content is lost.
        grasp: with the closing.
        path: joint angles of the arm on the approach, (n, 6) [rad].

    Returns:
        the opening, and None with what is touched where there is none.
    """
    # The search closes the hand a little further than the approach will: a margin.
    openings, margins = OPENINGS, (MARGIN, 0.0)
    if grasp.opening is not None:
        openings, margins = (grasp.opening,), (0.0,)
    met = ""
    for opening in openings:
        tries = itertools.product((path[0], path[len(path) // 3], path[-1]), margins)
        met = next(
            filter(None, (_met(scene, data, grasp, arm, opening + m) for arm, m in tries)), ""
        )
        if not met:
            return opening, ""
    return None, met


def place(
    scene: Scene, data: mujoco.MjData, grasp: GraspPlan, arm: np.ndarray, opening: float
) -> None:
    """Set the start of a grasp: object at its place, arm and hand at rest.

    Args:
        scene: with the object.
        data: of the scene; reset and changed in place.
        grasp: with the object's yaw and the closing.
        arm: joint angles (6,) [rad].
        opening: closing ratio.
    """
    mujoco.mj_resetData(scene.model, data)
    angles = grasp.closing.angles(opening)
    data.qpos[scene.arm_qpos] = arm
    scene.pose_hand(data, angles)
    at = slice(scene.object_qpos, scene.object_qpos + 7)
    data.qpos[at] = standing_pose(scene.obj, grasp.object_yaw)
    data.ctrl[scene.arm_motors] = arm
    data.ctrl[scene.motors] = angles


def _met(
    scene: Scene, data: mujoco.MjData, grasp: GraspPlan, arm: np.ndarray, opening: float
) -> str:
    """What the robot touches in a position, empty where nothing; arguments as ``place``."""
    place(scene, data, grasp, arm, opening)
    mujoco.mj_kinematics(scene.model, data)
    mujoco.mj_collision(scene.model, data)
    return robot_touches(scene, data)
