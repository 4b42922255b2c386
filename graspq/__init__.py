"""Exact grasp wrench space metrics: contacts in, ε, V and q* out."""

from graspq.ball import LargestBall, epsilon, is_force_closure, largest_ball
from graspq.batch import ScalingBatch, epsilon_batch, task_scaling_batch, volume_batch
from graspq.closure_residuals import qp_dfc_residual, qp_residual, span_loss
from graspq.compliance import (
    CompliantGrasp,
    contact_stiffness,
    grasp_stiffness,
    least_stiffness,
)
from graspq.contact import Contact, contact_wrenches
from graspq.contact_geometry import centroid_distance, contact_area, contact_shape
from graspq.edge_weights import minimum_weight
from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError
from graspq.forces import ContactForces, contact_forces
from graspq.grasp_maps import ellipsoid_volume, grasp_map, isotropy, smallest_singular_value
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
from graspq.surface_wrenches import relative_epsilon, surface_epsilon, unit_wrenches
from graspq.synthesis_losses import dexgraspbench_q1, dfc_residual, scaled_epsilon, tdg_loss
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
    "centroid_distance",
    "contact_area",
    "contact_forces",
    "contact_robustness",
    "contact_shape",
    "contact_stiffness",
    "contact_wrenches",
    "dexgraspbench_q1",
    "dfc_residual",
    "discretisation_error",
    "ellipsoid_volume",
    "epsilon",
    "epsilon_batch",
    "grasp_map",
    "grasp_robustness",
    "grasp_stiffness",
    "gravity_tasks",
    "hand_task_scaling",
    "is_force_closure",
    "isotropy",
    "largest_ball",
    "least_stiffness",
    "manipulability",
    "max_normal_force",
    "max_torsion",
    "minimum_weight",
    "qp_dfc_residual",
    "qp_residual",
    "range_deviation",
    "relative_epsilon",
    "scaled_epsilon",
    "singularity_distance",
    "slip_margin",
    "smallest_singular_value",
    "span_loss",
    "surface_epsilon",
    "task_scaling",
    "task_scaling_batch",
    "tdg_loss",
    "transmission_uniformity",
    "unit_wrenches",
    "volume",
    "volume_batch",
]
