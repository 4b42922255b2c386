"""From a random grasp to a feasible course: reachable, free of collisions, liftable."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from sdh_sim.cell.scene import ARM_GEOM, HAND_GEOM, Scene
from sdh_sim.grasping.grasp_sampler import OBJECT_POSITION, STANDOFF, GraspPlan, sample_grasp
from sdh_sim.objects.catalogue import ObjectInfo
from sdh_sim.robot.arm import arm_kinematics
from sdh_sim.robot.hand import preshape_angles

LIFT_HEIGHT = 0.15  # [m]
OPENINGS = (0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)  # closing ratios tried for the approach
MAX_DRAWS = 500
UNREACHABLE, COLLIDING = "unreachable", "colliding"


@dataclass(frozen=True)
class Course:
    """A feasible plan.

    Attributes:
        plan: the grasp.
        approach, lift: joint paths of the arm (n, 6) [rad].
        opening: closing ratio of the preshape during the approach.
        unreachable, colliding: plans drawn before that the arm cannot reach or that collide.
    """

    plan: GraspPlan
    approach: np.ndarray
    lift: np.ndarray
    opening: float
    unreachable: int = 0
    colliding: int = 0


def find_course(scene: Scene, thing: ObjectInfo, rng: np.random.Generator) -> Course:
    """Draw grasps until one is within reach and free of collisions."""
    unreachable = colliding = 0
    for _ in range(MAX_DRAWS):
        found = plan_course(scene, thing, sample_grasp(thing, rng, scene.settings.grasps))
        if isinstance(found, Course):
            return replace(found, unreachable=unreachable, colliding=colliding)
        unreachable += found == UNREACHABLE
        colliding += found == COLLIDING
    raise RuntimeError(
        f"no feasible grasp of {thing.name} in {MAX_DRAWS} draws ({unreachable} out of reach, "
        f"{colliding} in collision): is it too wide for the hand or too low?"
    )


def plan_course(scene: Scene, thing: ObjectInfo, plan: GraspPlan) -> Course | str:
    """The course of a plan, or why there is none: ``UNREACHABLE`` or ``COLLIDING``."""
    arm = arm_kinematics()
    rotation, position = plan.palm_rotation(), plan.palm_position()
    final = arm.reach(position, rotation)
    back = None if final is None else arm.straight(final, -STANDOFF * rotation[:, 2])
    if final is None or back is None:
        return UNREACHABLE
    opening = free_opening(scene, mujoco.MjData(scene.model), thing, plan, back)
    if opening is None:
        return COLLIDING
    lift = arm.straight(final, np.array([0.0, 0.0, LIFT_HEIGHT]))
    if lift is None:
        return UNREACHABLE
    return Course(plan, back[::-1], lift, opening)


def free_opening(
    scene: Scene, data: mujoco.MjData, thing: ObjectInfo, plan: GraspPlan, path: np.ndarray
) -> float | None:
    """The tightest opening of the preshape with which the approach touches nothing, or None."""
    for opening in OPENINGS:
        # The check closes the hand a little further than the approach will: a margin.
        if all(
            not _collides(scene, data, thing, plan, arm, opening + margin)
            for arm in (path[0], path[len(path) // 3], path[-1])
            for margin in (0.08, 0.0)
        ):
            return opening
    return None


def place(
    scene: Scene, data: mujoco.MjData, thing: ObjectInfo, plan: GraspPlan, arm: np.ndarray,
    opening: float,
) -> None:  # fmt: skip
    """Object on the table, arm and hand at given joint angles."""
    mujoco.mj_resetData(scene.model, data)
    angles = preshape_angles(plan.preshape, opening)
    data.qpos[scene.arm_qpos] = arm
    data.qpos[scene.motor_qpos] = angles
    data.qpos[scene.coupled_qpos] = angles[0]
    yaw = np.array([math.cos(plan.object_yaw / 2), 0.0, 0.0, math.sin(plan.object_yaw / 2)])
    free = data.qpos[scene.object_qpos : scene.object_qpos + 7]
    mujoco.mju_mulQuat(free[3:], yaw, thing.standing_quat)
    free[:3] = (*OBJECT_POSITION, thing.standing_height)
    data.ctrl[scene.arm_motors] = arm
    data.ctrl[scene.motors] = angles


def _collides(
    scene: Scene, data: mujoco.MjData, thing: ObjectInfo, plan: GraspPlan, arm: np.ndarray,
    opening: float,
) -> bool:  # fmt: skip
    place(scene, data, thing, plan, arm, opening)
    mujoco.mj_kinematics(scene.model, data)
    mujoco.mj_collision(scene.model, data)
    groups = scene.geom_group[data.contact.geom]
    return bool(np.isin(groups, (HAND_GEOM, ARM_GEOM)).any())


def plan_columns(course: Course) -> dict[str, Any]:
    """What the row says about the plan."""
    plan = course.plan
    return {
        "approach": plan.approach,
        "preshape": plan.preshape,
        "plan_azimuth_rad": plan.azimuth,
        "plan_roll_rad": plan.roll,
        "plan_tilt_rad": plan.tilt,
        "plan_height_m": plan.height,
        "plan_depth_m": plan.depth,
        "plan_offset_m": plan.offset,
        "object_yaw_rad": plan.object_yaw,
        "resampled_unreachable": course.unreachable,
        "resampled_colliding": course.colliding,
    }
