"""Metrics of the contacts' wrenches alone, of a perceived grasp."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

import graspq as gq
from sdh_sim.metrics.contact_points import friction_of, length_of, normals_of, positions_of
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.objects import surface_corners
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.user_references import ObjectFolder

SURFACE_EDGES = 8
WEIGHT_EDGES = 4  # FRoGGeR's


def _relative_epsilon(grasp: PerceivedGrasp) -> float:
    """ε of the contacts over that of the object's surface."""
    obj, length = grasp.obj, length_of(grasp)
    wrenches = gq.unit_wrenches(
        positions_of(grasp), normals_of(grasp), friction_of(grasp), SURFACE_EDGES, length=length
    )
    centre = tuple(float(x) for x in obj.com_m)
    whole = _surface_epsilon(obj.name, obj.folder, float(obj.friction), centre, length)
    return gq.epsilon(wrenches, "l1") / whole


@lru_cache(maxsize=64)
def _surface_epsilon(
    name: str,
    folder: ObjectFolder | None,
    friction: float,
    centre: tuple[float, ...],
    length: float,
) -> float:
    """ε of the wrenches of unit normal forces anywhere on an object's surface."""
    corners = surface_corners(name, folder)
    wrenches = gq.unit_wrenches(*corners, friction, SURFACE_EDGES, origin=centre, length=length)
    return gq.surface_epsilon([np.hstack(list(wrenches))])


def _minimum_weight(grasp: PerceivedGrasp) -> float:
    """ℓ* of the edges of the contacts' friction cones."""
    return gq.minimum_weight(
        gq.unit_wrenches(positions_of(grasp), normals_of(grasp), friction_of(grasp), WEIGHT_EDGES)
    )


_HARD = "Hard fingers, unit normal forces at the contacts' centres"
_BLIND_TO = "moments about the normals, how hard contacts can press, the weight"

METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        name="relative_epsilon",
        label="ε / ε of the object",
        family="wrench space",
        function=_relative_epsilon,
        unit="",
        source="Pollard 1994; Borst, Fischer and Hirzinger 2004; Simox 2012",
        conventions=(
            _HARD + ", L1 bound, the object's friction, 8 edges, for grasp and surface alike; "
            "moments about the centre of mass over half the diagonal of the object's box. The "
            "surface is that of the shapes that collide."
        ),
        blind_to=_BLIND_TO,
    ),
    FieldMetric(
        name="minimum_weight",
        label="ℓ*",
        family="wrench space",
        function=_minimum_weight,
        unit="",
        source="FRoGGeR: Li, Culbertson, Burdick and Ames 2023",
        conventions=(
            _HARD + ", cones of 4 edges. At most one over the number of edges, so that grasps with "
            "more contacts have less."
        ),
        blind_to=_BLIND_TO + ", how large wrenches are",
    ),
    FieldMetric(
        name="normalised_minimum_weight",
        label="m ℓ*",
        family="wrench space",
        function=lambda grasp: WEIGHT_EDGES * len(grasp.contacts) * _minimum_weight(grasp),
        unit="",
        source="FRoGGeR: Li, Culbertson, Burdick and Ames 2023",
        conventions=(
            "The minimum weight times the number of edges, at most 1; FRoGGeR's examples ask for "
            "0.3 or more."
        ),
        blind_to=_BLIND_TO + ", how large wrenches are",
        threshold=0.3,
    ),
    FieldMetric(
        name="scaled_epsilon",
        label="ε, arms scaled",
        family="wrench space",
        function=lambda grasp: gq.scaled_epsilon(
            positions_of(grasp), normals_of(grasp), 0.5 * friction_of(grasp)
        ),
        unit="",
        source="Ferrari and Canny 1992, with the conventions of DexGraspBench",
        conventions=(
            _HARD + ", L1 bound, cones of 8 edges, half the friction; arms from the contacts' mean "
            "over their mean length."
        ),
        blind_to=_BLIND_TO + ", where the centre of mass is",
    ),
)
