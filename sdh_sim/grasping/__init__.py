"""From an object on the table to an object in the hand: random grasps, motion, fingers.

Other rooms use what is named here.
"""

from sdh_sim.grasping.acquire import acquire
from sdh_sim.grasping.finger_control import FingerControl
from sdh_sim.grasping.grasp_sampler import GraspPlan, sample_grasp
from sdh_sim.grasping.motion_plan import MotionPlan, place, plan_motion, try_grasp

__all__ = [
    "FingerControl",
    "GraspPlan",
    "MotionPlan",
    "acquire",
    "place",
    "plan_motion",
    "sample_grasp",
    "try_grasp",
]
