"""Exact grasp wrench space metrics: contacts in, ε, V and q* out."""

from graspq.ball import LargestBall, epsilon, is_force_closure, largest_ball
from graspq.batch import ScalingBatch, epsilon_batch, task_scaling_batch, volume_batch
from graspq.contact import Contact, contact_wrenches
from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError
from graspq.forces import ContactForces, contact_forces
from graspq.hand_bound import HandBound
from graspq.hand_scaling import hand_task_scaling
from graspq.limits import max_normal_force, max_torsion
from graspq.scaling import discretisation_error, task_scaling
from graspq.scaling_result import HandScaling, TaskScaling
from graspq.tasks import gravity_tasks
from graspq.volume import volume
from graspq.wrench_space import WrenchSpace

__all__ = [
    "Contact",
    "ContactForces",
    "EllipsoidSet",
    "GraspError",
    "HandBound",
    "HandScaling",
    "LargestBall",
    "ScalingBatch",
    "TaskScaling",
    "WrenchSpace",
    "contact_forces",
    "contact_wrenches",
    "discretisation_error",
    "epsilon",
    "epsilon_batch",
    "gravity_tasks",
    "hand_task_scaling",
    "is_force_closure",
    "largest_ball",
    "max_normal_force",
    "max_torsion",
    "task_scaling",
    "task_scaling_batch",
    "volume",
    "volume_batch",
]
