"""Metrics by where the contacts of a perceived grasp lie."""

from __future__ import annotations

import graspq as gq
from sdh_sim.metrics.contact_points import positions_of
from sdh_sim.metrics.field_metric import FieldMetric

_POLYGON = (
    "Convex hull of the contacts' centres in the plane nearest to them; the triangle of three. "
)
_BLIND_TO = "normals, friction, how hard contacts can press, the weight"

METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        name="centroid_distance",
        label="centroid distance",
        family="contact geometry",
        function=lambda grasp: gq.centroid_distance(positions_of(grasp)),
        unit="m",
        source="Ding, Lee and Wang 2001; Roa and Suárez 2015",
        conventions="Mean of the contacts' centres, all with the same weight.",
        blind_to=_BLIND_TO + ", and on which side of the contacts the weight hangs",
        high_is_good=False,
    ),
    FieldMetric(
        name="contact_area",
        label="contact area",
        family="contact geometry",
        function=lambda grasp: gq.contact_area(positions_of(grasp)),
        unit="m^2",
        source="Mirtich and Canny 1994; Roa and Suárez 2015",
        conventions=_POLYGON + "Fewer than three contacts have 0.",
        blind_to=_BLIND_TO + ", how large the object is",
    ),
    FieldMetric(
        name="contact_shape",
        label="contact shape",
        family="contact geometry",
        function=lambda grasp: gq.contact_shape(positions_of(grasp)),
        unit="",
        source="Park and Starr 1992; Kim, Oh, Yi and Suh 2001",
        conventions=_POLYGON + "0: equal inner angles; 1: a line, and fewer than three contacts.",
        blind_to=_BLIND_TO,
        high_is_good=False,
    ),
)
