"""The field's metrics that need contacts and object alone, of a perceived grasp."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import graspq as gq
from sdh_sim.metrics import contact_geometry, grasp_map, synthesis, wrench_space
from sdh_sim.metrics.field_metric import FAMILIES
from sdh_sim.objects import object_info, object_spec
from sdh_sim.sensing import PadContact, PerceivedGrasp
from tests.support import sdh2

MODULES = (wrench_space, grasp_map, contact_geometry, synthesis)
METRICS = {metric.name: metric for module in MODULES for metric in module.METRICS}
# What shared motors, pads and pictures tell of a contact does not matter to these metrics.
SNAPSHOT = sdh2.snapshot(
    np.zeros((3, 14, 6)), np.zeros((3, 13, 6)), np.zeros(7), np.zeros(7), np.zeros(7), np.zeros(7)
)
PLACES = [(1.0, 0.1, 0.2), (-1.0, 0.3, 0.0), (-1.0, -0.3, 0.1)]


def grasp_on(name: str = "box", count: int = 3) -> PerceivedGrasp:
    """Three contacts on the two wide sides of an object, or the first of them."""
    obj = object_info(name)
    pads = []
    for side, along, up in PLACES[:count]:
        place = 0.5 * obj.extents_m * (side, along, up)
        normal = [-side, 0.0, 0.0]
        contact = gq.Contact(place, normal, obj.friction, 20.0, 20.0 * 0.004)
        pads.append(PadContact("pad", contact, np.zeros((6, 7))))
    return PerceivedGrasp(SNAPSHOT, obj, np.ones(7), tuple(pads), np.zeros((6, 1)))


def test_names_differ_and_all_is_said():
    assert len(METRICS) == sum(len(module.METRICS) for module in MODULES)
    for metric in METRICS.values():
        assert metric.family in FAMILIES
        assert metric.label
        assert metric.source
        assert metric.conventions.endswith(".")
        assert metric.blind_to
        assert metric.worst == (-math.inf if metric.high_is_good else math.inf)


@pytest.mark.parametrize("name", METRICS)
def test_every_metric_has_a_value(name):
    for count in (1, 2, 3):
        value = METRICS[name].function(grasp_on(count=count))
        assert isinstance(value, float)
        assert not math.isnan(value)


@pytest.mark.parametrize("name", METRICS)
def test_without_contacts_it_says_so(name):
    with pytest.raises(gq.GraspError):
        METRICS[name].function(grasp_on(count=0))


def test_lengths_and_coefficients_are_those_that_are_said():
    grasp = grasp_on()
    positions = np.array([p.contact.position for p in grasp.contacts])
    normals = np.array([p.contact.normal for p in grasp.contacts])
    mu = grasp.obj.friction
    length = 0.5 * float(np.linalg.norm(grasp.obj.extents_m))
    expected = {
        "isotropy": gq.isotropy(gq.grasp_map(positions, length=length)),
        "contact_area": gq.contact_area(positions),
        "dexgraspbench_q1": 2 - gq.scaled_epsilon(positions, normals, mu / 2),
        "scaled_epsilon": gq.scaled_epsilon(positions, normals, mu / 2),
        "tdg_loss": gq.tdg_loss(positions, normals, mu / 2),
        "qp_residual": gq.qp_residual(positions, normals, mu / 2, 0.002),
        "qp_dfc_residual": gq.qp_dfc_residual(positions, normals, mu / 2, 0.002),
        "span_axes": gq.span_loss(positions, normals, mu),
        "normalised_minimum_weight": 12 * METRICS["minimum_weight"].function(grasp),
    }
    for name, value in expected.items():
        assert METRICS[name].function(grasp) == pytest.approx(value, rel=1e-12)


def test_what_contacts_can_press_does_not_matter():
    grasp = grasp_on()
    strong = tuple(
        replace(
            pad,
            contact=gq.Contact(
                pad.contact.position, pad.contact.normal, pad.contact.friction, 200.0, 0.8
            ),
        )
        for pad in grasp.contacts
    )
    for metric in METRICS.values():
        value = metric.function(grasp)
        assert metric.function(replace(grasp, contacts=strong)) == pytest.approx(value, abs=1e-12)


def test_epsilon_relative_to_the_box_is_that_of_its_corners():
    grasp = grasp_on()
    # The box's middle is not its centre of mass, which the contacts' frame has as its origin.
    model = object_spec("box").compile()
    middle = model.geom_pos[np.flatnonzero(model.geom_contype)[0]] - grasp.obj.com_m
    half = 0.5 * grasp.obj.extents_m
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    places = np.tile(middle + half * signs, (3, 1))
    normals = np.concatenate([-signs[:, [k]] * np.eye(3)[k] for k in range(3)])
    length = float(np.linalg.norm(half))
    surface = gq.unit_wrenches(places, normals, grasp.obj.friction, 8, length=length)
    positions = np.array([p.contact.position for p in grasp.contacts])
    inward = np.array([p.contact.normal for p in grasp.contacts])
    own = gq.unit_wrenches(positions, inward, grasp.obj.friction, 8, length=length)
    expected = gq.relative_epsilon(own, surface)
    assert 0 < expected < 1
    assert METRICS["relative_epsilon"].function(grasp) == pytest.approx(expected, rel=1e-6)
