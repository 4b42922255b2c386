"""Metrics by the singular values of the grasp map, of a perceived grasp."""

from __future__ import annotations

import numpy as np

import graspq as gq
from sdh_sim.metrics.contact_points import length_of, positions_of
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.sensing import PerceivedGrasp

_CONVENTIONS = (
    "Hard fingers, three columns per contact; moments about the centre of mass, divided by half "
    "the diagonal of the object's box."
)
_BLIND_TO = "friction, that contacts only push, how hard they can press, the weight"


def _map(grasp: PerceivedGrasp) -> np.ndarray:
    """The grasp map (6, 3 n)."""
    return gq.grasp_map(positions_of(grasp), length=length_of(grasp))


METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        name="smallest_singular_value",
        label="σmin(G)",
        family="grasp map",
        function=lambda grasp: gq.smallest_singular_value(_map(grasp)),
        unit="",
        source="Li and Sastry 1988",
        conventions=_CONVENTIONS,
        blind_to=_BLIND_TO,
    ),
    FieldMetric(
        name="ellipsoid_volume",
        label="√det(GGᵀ)",
        family="grasp map",
        function=lambda grasp: gq.ellipsoid_volume(_map(grasp)),
        unit="",
        source="Li and Sastry 1988",
        conventions=_CONVENTIONS + " Grows with the number of contacts.",
        blind_to=_BLIND_TO,
    ),
    FieldMetric(
        name="isotropy",
        label="σmin/σmax(G)",
        family="grasp map",
        function=lambda grasp: gq.isotropy(_map(grasp)),
        unit="",
        source="Kim, Oh, Yi and Suh 2001",
        conventions=_CONVENTIONS,
        blind_to=_BLIND_TO,
    ),
)
