"""Where the fingers go as they close: each along its arc, until the object stops it.

Geometry alone decides, without forces: the object stays where it is.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim.cell import OBJECT_GEOM, Scene
from sdh_sim.cell.contacts import hand_contacts
from sdh_sim.cell.scene import GROUP_NAMES
from sdh_sim.grasping.grasp_plan import GraspPlan

STEP = 0.03  # of the closing ratio: at most 7 mm at a fingertip


class ClosingArc(NamedTuple):
    """What the fingers meet as they close.

    Attributes:
        blocked_by: what is in the way of a finger before the object stops it, such as
            ``the table`` or ``the hand itself``; empty where nothing is.
        touches: fingers that the object stops (3,) bool.
    """

    blocked_by: str
    touches: np.ndarray


def closing_arc(scene: Scene, data: mujoco.MjData, plan: GraspPlan, opening: float) -> ClosingArc:
    """What the fingers meet as they close.

    Args:
        scene: with the object.
        data: arm and object at their places; the hand's joints are changed in place.
        plan: with the closing.
        opening: closing ratio to begin with, at which nothing touches.
    """
    ratio, touches = np.full(3, opening), np.zeros(3, dtype=bool)
    while not touches.all() and ratio[~touches].max() < 1.0:
        ratio[~touches] = np.minimum(ratio[~touches] + STEP, 1.0)
        angles = plan.closing.angles(ratio)
        data.qpos[scene.motor_qpos] = angles
        data.qpos[scene.coupled_qpos] = angles[0]
        mujoco.mj_kinematics(scene.model, data)
        mujoco.mj_collision(scene.model, data)
        for finger, group in hand_contacts(scene, data):
            if group != OBJECT_GEOM:
                return ClosingArc(GROUP_NAMES[group], touches)
            if finger >= 0:
                touches[finger] = True
    return ClosingArc("", touches)
