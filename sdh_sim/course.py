"""From a random grasp to a feasible course: reachable, free of collisions, liftable."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from sdh_sim.arm import ArmKinematics
from sdh_sim.grasps import OBJECT_POSITION, STANDOFF, GraspPlan, sample_grasp
from sdh_sim.hand import preshape_angles
from sdh_sim.objects import ObjectInfo
from sdh_sim.scene import ARM_GEOM, HAND_GEOM, Scene

LIFT_HEIGHT = 0.15  # [m]
OPENINGS = (0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)  # closing ratios tried for the approach
MAX_DRAWS = 500


@dataclass(frozen=True)
class Course:
    """A feasible plan: joint paths of the arm and the opening of the hand."""

    plan: GraspPlan
    approach: np.ndarray
    lift: np.ndarray
    opening: float
    unreachable: int
    colliding: int


@lru_cache(maxsize=1)
def arm_kinematics() -> ArmKinematics:
    """The arm, built once per process."""
    return ArmKinematics()


def find_course(scene: Scene, thing: ObjectInfo, rng: np.random.Generator) -> Course:
    """Draw grasps until one is within reach and free of collisions."""
    arm = arm_kinematics()
    data = mujoco.MjData(scene.model)
    unreachable = colliding = 0
    for _ in range(MAX_DRAWS):
        plan = sample_grasp(thing, rng)
        rotation, position = plan.palm_rotation(), plan.palm_position()
        final = arm.reach(position, rotation)
        back = None if final is None else arm.straight(final, -STANDOFF * rotation[:, 2])
        if final is None or back is None:
            unreachable += 1
            continue
        opening = free_opening(scene, data, thing, plan, back)
        if opening is None:
            colliding += 1
            continue
        lift = arm.straight(final, np.array([0.0, 0.0, LIFT_HEIGHT]))
        if lift is None:
            unreachable += 1
            continue
        return Course(plan, back[::-1], lift, opening, unreachable, colliding)
    raise RuntimeError(f"no feasible grasp of {thing.name} in {MAX_DRAWS} draws")


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
