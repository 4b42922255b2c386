"""Metrics of the hand's posture: room in the ranges, and what its Jacobian transmits."""

from __future__ import annotations

import numpy as np

import graspq as gq
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.metrics.hand_springs import (
    compliant_grasp,
    kinematics_of,
    scaled_jacobian,
)
from sdh_sim.sensing import PerceivedGrasp

SURVEY = "Roa and Suárez 2015, section 4"
_MOVING = (
    "Motors that move no contact are left out; of the others' singular values as many count as "
    "there are, at most the number of rows."
)


def range_deviation(grasp: PerceivedGrasp) -> float:
    """Σ ((θ - mid)/range)² over the motors (``graspq.range_deviation``)."""
    spans = np.array([motor.span for motor in kinematics_of(grasp).hand.motors])
    return gq.range_deviation(grasp.snapshot.joint_angles, spans[:, 0], spans[:, 1])


def singularity_distance(grasp: PerceivedGrasp) -> float:
    """Smallest singular value of the Jacobian of the contacts' centres [1/rad]."""
    return gq.singularity_distance(scaled_jacobian(grasp))


def manipulability(grasp: PerceivedGrasp) -> float:
    """Product of the singular values of the Jacobian of the contacts' centres."""
    return gq.manipulability(scaled_jacobian(grasp))


def transmission_uniformity(grasp: PerceivedGrasp) -> float:
    """σmin/σmax of the hand-object Jacobian (``graspq.transmission_uniformity``)."""
    springs = compliant_grasp(grasp)
    straight = _forces(springs)
    motors = len(grasp.torque_limits)
    return gq.transmission_uniformity(
        springs.grasp_map[:, straight], springs.jacobian[straight, :motors] / springs.length
    )


def _forces(springs: gq.CompliantGrasp) -> np.ndarray:
    """Which components are forces of contacts, not moments (m,) bool: the first three of each."""
    first = np.searchsorted(springs.owners, springs.owners)
    return np.arange(len(springs.owners)) - first < 3


METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        "range_deviation",
        "joint range",
        "posture",
        range_deviation,
        "",
        SURVEY,
        "Over all motors, a coupled joint once; ranges as the hand's description has them.",
        "the object, contacts and forces",
        high_is_good=False,
    ),
    FieldMetric(
        "singularity_distance",
        "σmin(J)",
        "posture",
        singularity_distance,
        "1/rad",
        SURVEY,
        "J takes motor speeds to the velocities of the contacts' centres, divided by half "
        f"the diagonal of the object's box. {_MOVING} SynGrasp takes the hand-object Jacobian "
        "instead.",
        "normals, friction, forces and torque limits",
    ),
    FieldMetric(
        "manipulability",
        "√det(JJᵀ)",
        "posture",
        manipulability,
        "",
        f"Yoshikawa 1985; {SURVEY}",
        f"J as for σmin(J); where it is taller than wide √det(JᵀJ). {_MOVING} Its unit is 1/rad "
        "per singular value, so that grasps by different numbers of motors do not compare.",
        "normals, friction, forces and torque limits",
    ),
    FieldMetric(
        "transmission_uniformity",
        "uniformity of G⁺ᵀJ",
        "posture",
        transmission_uniformity,
        "",
        SURVEY,
        "σmin/σmax, in [0, 1]; SynGrasp has the inverse. Moments about the centre of mass, over "
        "half the diagonal of the object's box, which divides J, too; contacts without moments. "
        f"{_MOVING}",
        "friction, forces and torque limits",
    ),
)
"""Metrics of posture, in the order of the documentation."""
