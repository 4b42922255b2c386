"""Exact grasp wrench space metrics: contacts in, ε, V and q* out."""

from graspq.ball import LargestBall, epsilon, is_force_closure, largest_ball
from graspq.batch import ScalingBatch, epsilon_batch, task_scaling_batch, volume_batch
from graspq.compliance import (
    CompliantGrasp,
    contact_stiffness,
    grasp_stiffness,
    least_stiffness,
)
from graspq.contact import Contact, contact_wrenches
from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError
from graspq.forces import ContactForces, contact_forces
from graspq.hand_bound import HandBound
from graspq.hand_scaling import hand_task_scaling
from graspq.limits import max_normal_force, max_torsion
from graspq.posture import (
    manipulability,
    range_deviation,
    singularity_distance,
    transmission_uniformity,
)
from graspq.robustness import contact_robustness, grasp_robustness
from graspq.scaling import discretisation_error, task_scaling
from graspq.scaling_result import HandScaling, TaskScaling
from graspq.slip import slip_margin
from graspq.tasks import gravity_tasks
from graspq.volume import volume
from graspq.wrench_space import WrenchSpace

__all__ = [
    "CompliantGrasp",
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
    "contact_robustness",
    "contact_stiffness",
    "contact_wrenches",
    "discretisation_error",
    "epsilon",
    "epsilon_batch",
    "grasp_robustness",
    "grasp_stiffness",
    "gravity_tasks",
    "hand_task_scaling",
    "is_force_closure",
    "largest_ball",
    "least_stiffness",
    "manipulability",
    "max_normal_force",
    "max_torsion",
    "range_deviation",
    "singularity_distance",
    "slip_margin",
    "task_scaling",
    "task_scaling_batch",
    "transmission_uniformity",
    "volume",
    "volume_batch",
]
