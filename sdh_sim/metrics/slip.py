"""The slip margin of a perceived grasp: friction left when the hand chooses its forces well."""

from __future__ import annotations

import graspq as gq
from sdh_sim.metrics.built_in import EDGES, hand_bound
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.sensing import PerceivedGrasp


def slip_margin(grasp: PerceivedGrasp) -> float:
    """Least over the task of the best least friction left (``graspq.slip_margin``) [N]."""
    return gq.slip_margin(hand_bound(grasp, held=False), grasp.task, EDGES)


METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        "slip_margin",
        "slip margin",
        "task",
        slip_margin,
        "N",
        "Kerr and Roth 1986; GraspIt!'s grasp force optimisation",
        "Linear programs per task wrench on the edges of inscribed cones (12): maximise the least "
        "μf_n - |f_t| over contacts, summed over a contact's taxels, within the motors' torque "
        "limits. Below 0: the friction that is missing; -inf: more would not help.",
        "what the motors exert now; contacts that no pad feels; how far the task could grow",
        threshold=0.0,
    ),
)
"""Metrics of the task, in the order of the documentation."""
