"""The grasps that a run takes from a file, and which of them a trial has."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from sdh_sim.runs.plan import Job, RunPlan

if TYPE_CHECKING:
    from sdh_sim.grasp_files import GraspEntry

    GivenGrasps = Mapping[str, Sequence[GraspEntry]]


def read_given_grasps(plan: RunPlan) -> GivenGrasps:
    """The grasps of the plan's file by object, in the file's order; none where they are random.

    Raises:
        GraspFileError: the file is missing, has changed or cannot be used.
    """
    if plan.settings.grasp_set is None:
        return {}
    from sdh_sim.grasp_files import read_grasp_set  # what knows the hand takes its time

    found: dict[str, list[GraspEntry]] = {name: [] for name in plan.objects}
    for entry in read_grasp_set(plan.settings.grasp_set, plan.objects):
        found[entry.object].append(entry)
    return found


def with_grasp(job: Job, given: GivenGrasps) -> Job:
    """The job with its grasp of ``read_given_grasps``; one with a random grasp as it is."""
    if job.grasp_number is None:
        return job
    return dataclasses.replace(job, grasp=given[job.settings.object][job.grasp_number])
