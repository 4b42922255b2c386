"""From a random grasp to a feasible motion: reachable, free of collisions, liftable."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from sdh_sim import poses
from sdh_sim.cell import Scene
from sdh_sim.cell.contacts import robot_touches
from sdh_sim.grasping.grasp_sampler import OBJECT_POSITION, STANDOFF, GraspPlan, sample_grasp
from sdh_sim.robot import arm_kinematics, preshape_angles

LIFT_HEIGHT = 0.15  # [m]
OPENINGS = (0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)  # closing ratios tried for the approach
MAX_DRAWS = 500
UNREACHABLE, COLLIDING = "unreachable", "colliding"


@dataclass(frozen=True)
class MotionPlan:
    """A grasp with the arm's motion to it and up from it.

    Attributes:
        grasp: where the hand goes.
        approach, lift: joint paths of the arm (n, 6) [rad].
        opening: closing ratio of the preshape during the approach.
        unreachable, colliding: grasps drawn before that the arm cannot reach or that collide.
    """

    grasp: GraspPlan
    approach: np.ndarray
    lift: np.ndarray
    opening: float
    unreachable: int = 0
    colliding: int = 0


def plan_motion(scene: Scene, rng: np.random.Generator) -> MotionPlan:
    """Draw grasps until one is within reach and free of collisions.

    Args:
        scene: with the object and the style of grasps in its settings.
        rng: of all that is random in them.

    Raises:
        RuntimeError: none in ``MAX_DRAWS`` draws.
    """
    unreachable = colliding = 0
    for _ in range(MAX_DRAWS):
        found = try_grasp(scene, sample_grasp(scene.obj, rng, scene.settings.grasps))
        if isinstance(found, MotionPlan):
            return replace(found, unreachable=unreachable, colliding=colliding)
        unreachable += found == UNREACHABLE
        colliding += found == COLLIDING
    raise RuntimeError(
        f"no feasible grasp of {scene.obj.name} in {MAX_DRAWS} draws ({unreachable} out of reach, "
        f"{colliding} in collision): is it too wide for the hand or too low?"
    )


def try_grasp(scene: Scene, grasp: GraspPlan) -> MotionPlan | str:
    """The motion of a grasp, or why there is none: ``UNREACHABLE`` or ``COLLIDING``."""
    arm = arm_kinematics()
    rotation, position = grasp.palm_rotation(), grasp.palm_position()
    final = arm.reach(position, rotation)
    back = None if final is None else arm.straight(final, -STANDOFF * rotation[:, 2])
    if final is None or back is None:
        return UNREACHABLE
    opening = free_opening(scene, mujoco.MjData(scene.model), grasp, back)
    if opening is None:
        return COLLIDING
    lift = arm.straight(final, np.array([0.0, 0.0, LIFT_HEIGHT]))
    if lift is None:
        return UNREACHABLE
    return MotionPlan(grasp, back[::-1], lift, opening)


def free_opening(
    scene: Scene, data: mujoco.MjData, grasp: GraspPlan, path: np.ndarray
) -> float | None:
    """The opening with which the approach touches nothing, the most closed one, or None.

    Args:
        scene: with the object.
        data: to try positions in; its content is lost.
        grasp: with the preshape.
        path: joint angles of the arm on the approach, (n, 6) [rad].
    """
    for opening in OPENINGS:
        # The check closes the hand a little further than the approach will: a margin.
        if all(
            not _collides(scene, data, grasp, arm, opening + margin)
            for arm in (path[0], path[len(path) // 3], path[-1])
            for margin in (0.08, 0.0)
        ):
            return opening
    return None


def place(
    scene: Scene, data: mujoco.MjData, grasp: GraspPlan, arm: np.ndarray, opening: float
) -> None:
    """Set the start of a grasp: object on the table, arm and hand at rest.

    Args:
        scene: with the object.
        data: of the scene; reset and changed in place.
        grasp: with the object's yaw and the preshape.
        arm: joint angles (6,) [rad].
        opening: closing ratio of the preshape.
    """
    mujoco.mj_resetData(scene.model, data)
    angles = preshape_angles(grasp.preshape, opening)
    data.qpos[scene.arm_qpos] = arm
    data.qpos[scene.motor_qpos] = angles
    data.qpos[scene.coupled_qpos] = angles[0]
    free = data.qpos[scene.object_qpos : scene.object_qpos + 7]
    free[3:] = poses.product(poses.about_z(grasp.object_yaw), scene.obj.standing_quat)
    free[:3] = (*OBJECT_POSITION, scene.obj.standing_height)
    data.ctrl[scene.arm_motors] = arm
    data.ctrl[scene.motors] = angles


def _collides(
    scene: Scene, data: mujoco.MjData, grasp: GraspPlan, arm: np.ndarray, opening: float
) -> bool:
    """Whether the robot touches anything in a position; arguments as ``place``."""
    place(scene, data, grasp, arm, opening)
    mujoco.mj_kinematics(scene.model, data)
    mujoco.mj_collision(scene.model, data)
    return robot_touches(scene, data)
