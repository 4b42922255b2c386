"""Exact grasp wrench space metrics: contacts in, ε, V and q* out."""

from graspq.ball import epsilon, is_force_closure
from graspq.contact import Contact, contact_wrenches
from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError
from graspq.hand import HandBound, HandScaling, hand_task_scaling
from graspq.limits import max_normal_force, max_torsion
from graspq.product import product_volume as volume
from graspq.scaling import TaskScaling, task_scaling
from graspq.tasks import gravity_tasks

__all__ = [
    "Contact",
    "EllipsoidSet",
    "GraspError",
    "HandBound",
    "HandScaling",
    "TaskScaling",
    "contact_wrenches",
    "epsilon",
    "gravity_tasks",
    "hand_task_scaling",
    "is_force_closure",
    "max_normal_force",
    "max_torsion",
    "task_scaling",
    "volume",
]
