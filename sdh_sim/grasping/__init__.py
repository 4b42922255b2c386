"""From an object on the table to an object in the hand: random grasps, motion, fingers.

Other rooms use what is named here.
"""

from sdh_sim.grasping.acquire import acquire
from sdh_sim.grasping.closing_arc import ClosingArc, closing_arc
from sdh_sim.grasping.finger_control import FingerControl
from sdh_sim.grasping.given_grasp import plan_of
from sdh_sim.grasping.grasp_plan import GraspPlan
from sdh_sim.grasping.grasp_sampler import RandomGrasp, sample_grasp
from sdh_sim.grasping.motion_plan import (
    Infeasible,
    MotionPlan,
    place,
    plan_given,
    plan_motion,
    try_grasp,
)

__all__ = [
    "ClosingArc",
    "FingerControl",
    "GraspPlan",
    "Infeasible",
    "MotionPlan",
    "RandomGrasp",
    "acquire",
    "closing_arc",
    "place",
    "plan_given",
    "plan_motion",
    "plan_of",
    "sample_grasp",
    "try_grasp",
]
