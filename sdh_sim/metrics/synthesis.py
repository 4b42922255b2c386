"""Losses that grasp generators minimise, of a perceived grasp. Low is good in all of them."""

from __future__ import annotations

from collections.abc import Callable

import graspq as gq
from sdh_sim.metrics.contact_points import friction_of, normals_of, positions_of, torsion_of
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.sensing import PerceivedGrasp

# DexGraspBench rates grasps with half of the coefficients, to leave a margin.
MARGIN = 0.5

_SCALED = "Arms from the contacts' mean over their mean length. "
_HALF = "Half the friction, as DexGraspBench takes. "
_UNSCALED = "Arms in metres from the contacts' mean, moments beside forces as they are. "
_BLIND_TO = "how hard contacts can press, the weight, where the centre of mass is"


def _q1(grasp: PerceivedGrasp) -> float:
    """Q1 of DexGraspBench."""
    return gq.dexgraspbench_q1(positions_of(grasp), normals_of(grasp), MARGIN * friction_of(grasp))


def _tdg(grasp: PerceivedGrasp) -> float:
    """The TDG loss."""
    return gq.tdg_loss(positions_of(grasp), normals_of(grasp), MARGIN * friction_of(grasp))


def _quadratic(function: Callable[..., float], grasp: PerceivedGrasp) -> float:
    """A residual with friction and torsion of the contacts."""
    friction, torsion = MARGIN * friction_of(grasp), MARGIN * torsion_of(grasp)
    return function(positions_of(grasp), normals_of(grasp), friction, torsion)


def _span(grasp: PerceivedGrasp, targets: str) -> float:
    """GraspQP's loss about the centre of mass, with the object's friction."""
    friction = float(grasp.obj.friction)
    return gq.span_loss(positions_of(grasp), normals_of(grasp), friction, targets=targets)


METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        name="dfc_residual",
        label="DFC",
        family="synthesis",
        function=lambda grasp: gq.dfc_residual(positions_of(grasp), normals_of(grasp)),
        unit="",
        source="DexGraspNet, Wang et al. 2023; DexGraspBench",
        conventions=_SCALED + "Equal normal forces at all contacts.",
        blind_to="friction, unequal forces, " + _BLIND_TO,
        high_is_good=False,
    ),
    FieldMetric(
        name="dexgraspbench_q1",
        label="Q1 (DexGraspBench)",
        family="synthesis",
        function=_q1,
        unit="",
        source="DexGraspBench; Ferrari and Canny 1992",
        conventions=_SCALED + _HALF + "2 - ε of cones with 8 edges and the origin.",
        blind_to="moments about the normals, " + _BLIND_TO,
        high_is_good=False,
    ),
    FieldMetric(
        name="tdg_loss",
        label="TDG",
        family="synthesis",
        function=_tdg,
        unit="",
        source="Chen, Chen, Zhang and Wang 2024; DexGraspBench",
        conventions=_SCALED + _HALF + "Forces in 1000 fixed directions, hard fingers, round cones.",
        blind_to="whether moments can be resisted, " + _BLIND_TO,
        high_is_good=False,
    ),
    FieldMetric(
        name="qp_residual",
        label="QP",
        family="synthesis",
        function=lambda grasp: _quadratic(gq.qp_residual, grasp),
        unit="",
        source="BODex, Chen, Ke and Wang 2025; DexGraspBench",
        conventions=_UNSCALED + _HALF + "Torsion of the pads, halved as well.",
        blind_to=_BLIND_TO,
        high_is_good=False,
    ),
    FieldMetric(
        name="qp_dfc_residual",
        label="QP-DFC",
        family="synthesis",
        function=lambda grasp: _quadratic(gq.qp_dfc_residual, grasp),
        unit="",
        source="BODex, Chen, Ke and Wang 2025; DexGraspBench",
        conventions=_UNSCALED + _HALF + "Torsion of the pads, halved as well.",
        blind_to="any load, " + _BLIND_TO,
        high_is_good=False,
    ),
    FieldMetric(
        name="span_axes",
        label="span (GraspQP)",
        family="synthesis",
        function=lambda grasp: _span(grasp, "axes"),
        unit="",
        source="GraspQP, Zurbrügg, Cramariuc and Hutter 2025",
        conventions=(
            "Unit wrenches along the axes, edge weights up to 50, moments about the centre of mass "
            "times 5 per metre, the object's friction (the authors take 0.2)."
        ),
        blind_to="moments about the normals, how hard contacts can press, the weight",
        high_is_good=False,
    ),
    FieldMetric(
        name="span_zero",
        label="closure (GraspQP)",
        family="synthesis",
        function=lambda grasp: _span(grasp, "zero"),
        unit="",
        source="GraspQP, Zurbrügg, Cramariuc and Hutter 2025",
        conventions=(
            "No wrench, edge weights from 1 to 51, moments about the centre of mass times 5 per "
            "metre, the object's friction (the authors take 0.2)."
        ),
        blind_to="moments about the normals, how hard contacts can press, the weight",
        high_is_good=False,
    ),
)
