"""Where the fingers go as they close: each along its arc, until the object stops it.

Geometry alone decides, without forces: the object stays where it is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim.cell import OBJECT_GEOM, Scene
from sdh_sim.cell.contacts import hand_contacts
from sdh_sim.cell.scene import GROUP_NAMES
from sdh_sim.grasping.grasp_plan import GraspPlan

MOST_AXIAL = math.cos(math.radians(45))  # of a normal along the palm's z that a finger presses on
STEP = 0.05  # of the closing ratio: 12 mm at a fingertip, less than a finger is thick


class ClosingArc(NamedTuple):
    """What the fingers meet as they close.

    Attributes:
        blocked_by: what is in the way of a finger before the object stops it, such as
            ``the table`` or ``the hand itself``; empty where nothing is.
        stopped: fingers that the object stops (fingers,) bool.
        sideways: those of them that it stops by a face which they can press on as they close, not
            one that looks toward the palm (fingers,) bool.
    """

    blocked_by: str
    stopped: np.ndarray
    sideways: np.ndarray


def closing_arc(scene: Scene, data: mujoco.MjData, plan: GraspPlan, opening: float) -> ClosingArc:
    """What the fingers meet as they close.

    Args:
        scene: with the object.
        data: arm and object at their places; the hand's joints are changed in place.
        plan: with the closing.
        opening: closing ratio to begin with, at which nothing touches.
    """
    fingers = len(scene.hand.fingers)
    ratio = np.full(fingers, opening)
    stopped, sideways = np.zeros((2, fingers), dtype=bool)
    axis = plan.palm_rotation[:, 2]
    moving = ~stopped
    while moving.any() and ratio[moving].max() < 1.0:
        ratio[moving] = np.minimum(ratio[moving] + STEP, 1.0)
        scene.pose_hand(data, plan.closing.angles(ratio))
        mujoco.mj_kinematics(scene.model, data)
        mujoco.mj_collision(scene.model, data)
        for contact in hand_contacts(scene, data):
            if contact.group != OBJECT_GEOM:
                return ClosingArc(GROUP_NAMES[contact.group], stopped, sideways)
            if contact.finger >= 0:
                stopped[contact.finger] = True
                sideways[contact.finger] |= abs(contact.normal @ axis) < MOST_AXIAL
        # Fingers on one motor go on together, and the first that meets the object takes it along,
        # until the last one does.
        moving = (scene.hand.joined_fingers & ~stopped).any(axis=1)
    return ClosingArc("", stopped, sideways)
