"""Exact grasp wrench space metrics: contacts in, ε, V and q* out."""

from graspq.ball import epsilon, is_force_closure
from graspq.batch import ScalingBatch, epsilon_batch, task_scaling_batch, volume_batch
from graspq.contact import Contact, contact_wrenches
from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError
from graspq.hand import HandBound, HandScaling, hand_task_scaling
from graspq.limits import max_normal_force, max_torsion
from graspq.scaling import TaskScaling, task_scaling
from graspq.tasks import gravity_tasks
from graspq.volume import volume

__all__ = [
    "Contact",
    "EllipsoidSet",
    "GraspError",
    "HandBound",
    "HandScaling",
    "ScalingBatch",
    "TaskScaling",
    "contact_wrenches",
    "epsilon",
    "epsilon_batch",
    "gravity_tasks",
    "hand_task_scaling",
    "is_force_closure",
    "max_normal_force",
    "max_torsion",
    "task_scaling",
    "task_scaling_batch",
    "volume",
    "volume_batch",
]
