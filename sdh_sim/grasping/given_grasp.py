"""From a grasp of a file to a plan in the workcell."""

from __future__ import annotations

from sdh_sim.grasp_files import GraspEntry
from sdh_sim.grasping.grasp_plan import GraspPlan
from sdh_sim.objects import ObjectInfo


def plan_of(entry: GraspEntry, obj: ObjectInfo) -> GraspPlan:
    """The plan of a grasp; ``plan_given`` finds out whether there is a motion to it."""
    return GraspPlan.from_pose(
        obj,
        entry.palm_pose,
        entry.closing,
        opening=entry.opening,
        object_yaw=entry.object_yaw,
        name=entry.name,
    )
