"""From the object on the table to the object in the hand: approach, close, squeeze, rest."""

from __future__ import annotations

import numpy as np

from sdh_sim.cell.simulation import Cell
from sdh_sim.grasping.finger_control import FingerControl
from sdh_sim.grasping.motion_plan import Course, place
from sdh_sim.objects.catalogue import ObjectInfo
from sdh_sim.robot.arm import along, arm_kinematics

APPROACH_TIME, CLOSE_TIME, SQUEEZE_TIME = 0.8, 2.2, 2.0  # the last two at most [s]
QUIET_TIME = 0.1  # that long at rest ends the squeeze [s]
REST_TIME = 0.5  # [s]
REST_SPEED, REST_SPIN = 1e-3, 1e-2  # object at rest below these [m/s], [rad/s]


def acquire(cell: Cell, thing: ObjectInfo, course: Course) -> None:
    """Grasp the object; the cell ends at rest, ready for the snapshot.

    Raises:
        Diverged: the simulation did.
    """
    scene, data = cell.scene, cell.data
    place(scene, data, thing, course.plan, course.approach[0], course.opening)
    duration = arm_kinematics().duration(course.approach, APPROACH_TIME)
    cell.phase = "approach"
    cell.follow(lambda share: along(course.approach, share), duration)
    cell.wait(0.1)
    fingers = FingerControl(
        course.plan.preshape,
        course.opening,
        cell.limits,
        scene.model.actuator_gainprm[scene.motors, 0],
        scene.model.dof_damping[scene.motor_dof],
    )
    cell.phase = "close"
    for _ in range(round(CLOSE_TIME / cell.tick_time)):
        torques = data.actuator_force[scene.motors]
        cell.tick(hand=fingers.close(torques, cell.tick_time))
        if fingers.closed:
            break
    cell.phase = "squeeze"
    quiet = 0.0
    for _ in range(round(SQUEEZE_TIME / cell.tick_time)):
        angles = data.qpos[scene.motor_qpos]
        cell.tick(hand=fingers.squeeze(angles, cell.tick_time))
        speed = data.qvel[scene.object_dof : scene.object_dof + 6]
        still = np.linalg.norm(speed[:3]) < REST_SPEED and np.linalg.norm(speed[3:]) < REST_SPIN
        quiet = quiet + cell.tick_time if still else 0.0
        if quiet > QUIET_TIME and fingers.settled:
            break
    cell.phase = "rest"
    cell.wait(REST_TIME)
