"""Metrics of compliant pads and servos: grasp stiffness, PCR, PGR."""

from __future__ import annotations

import graspq as gq
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.metrics.hand_springs import compliant_grasp, weight_wrenches
from sdh_sim.sensing import PerceivedGrasp

EDGES = 12
_SPRINGS = (
    "Springs: rubber of the taxels that count, with the modulus and thickness that trials have "
    "unless told otherwise; gains of the servos in the hand's model; arm, links and object rigid. "
    "Contacts are soft points. Moments about the centre of mass over half the diagonal of the "
    "object's box."
)
_SOURCE = "Bicchi 1995; Pozzi, Malvezzi and Prattichizzo 2017"


def least_stiffness(grasp: PerceivedGrasp) -> float:
    """Smallest eigenvalue of the grasp's stiffness (``graspq.least_stiffness``) [N/m]."""
    return gq.least_stiffness(compliant_grasp(grasp))


def contact_robustness(grasp: PerceivedGrasp) -> float:
    """PCR beside the weight, least over its directions (``graspq.contact_robustness``) [N]."""
    springs = compliant_grasp(grasp)
    return min(gq.contact_robustness(springs, w, EDGES) for w in weight_wrenches(grasp))


def grasp_robustness(grasp: PerceivedGrasp) -> float:
    """PGR beside the weight, least over its directions (``graspq.grasp_robustness``) [N]."""
    springs = compliant_grasp(grasp)
    return min(gq.grasp_robustness(springs, w, EDGES) for w in weight_wrenches(grasp))


METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        "least_stiffness",
        "grasp stiffness",
        "compliance",
        least_stiffness,
        "N/m",
        "Cutkosky and Kao 1989; Rimon and Burdick 2019",
        f"Smallest eigenvalue of G(C_s + J C_q Jᵀ)⁻¹Gᵀ, without geometric stiffness. {_SPRINGS}",
        "friction, torque limits, how hard contacts press",
    ),
    FieldMetric(
        "contact_robustness",
        "PCR",
        "compliance",
        contact_robustness,
        "N",
        _SOURCE,
        "Largest distance of controllable contact forces that bear the weight from friction cones "
        f"(12 edges) and torque limits, over σmax of K Gᵀ(G K Gᵀ)⁻¹. {_SPRINGS} 0 where the weight "
        "cannot be borne so.",
        "what the motors exert now; what happens once a contact slips",
    ),
    FieldMetric(
        "grasp_robustness",
        "PGR",
        "compliance",
        grasp_robustness,
        "N",
        _SOURCE,
        "As PCR, best over the sets of contacts that stick, slip without friction, or are off, in "
        f"which stiffness holds the object. {_SPRINGS} NaN for more than seven contacts.",
        "what the motors exert now; whether contacts come to be in that set",
    ),
)
"""Metrics of compliance, in the order of the documentation."""
