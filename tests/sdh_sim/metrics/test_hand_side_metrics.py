"""Metrics of posture, compliance and slip, and probabilities, of perceived grasps of the SDH-2."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

import graspq as gq
from sdh_sim.metrics import METRICS, compliance, posture, probability, slip
from sdh_sim.metrics.contact_points import length_of
from sdh_sim.metrics.field_metric import FAMILIES
from sdh_sim.metrics.hand_springs import (
    rubber_stiffness,
    servo_stiffness,
    weight_wrenches,
)
from sdh_sim.objects import ObjectInfo, object_info
from sdh_sim.robot import HandKinematics
from sdh_sim.robot.sdh2_constants import TAXEL_PITCH
from sdh_sim.sensing import PerceivedGrasp, TactileSnapshot, TrackingErrors, perceive
from tests.support import sdh2

LIMIT = (1.6401, 1.0934)
ALL = (*posture.METRICS, *compliance.METRICS, *slip.METRICS, *probability.METRICS)
FINGER1, FINGER2, THUMB = range(3)


@pytest.fixture(scope="module")
def kinematics() -> HandKinematics:
    return HandKinematics()


@pytest.fixture(scope="module")
def obj() -> ObjectInfo:
    return replace(object_info("box"), com_m=np.zeros(3))


@pytest.fixture(scope="module")
def snapshot() -> TactileSnapshot:
    """Fingers 1 and 2 against each other, the thumb across."""
    proximal = np.zeros((3, 14, 6))
    proximal[:2, 8:14, 1:5] = 20.0
    proximal[THUMB, 6:12, 1:5] = 10.0
    return sdh2.snapshot(
        proximal=proximal,
        distal=np.zeros((3, 13, 6)),
        joint_angles=np.array([0.2, -0.1, 0.1, 0, 0, -0.1, 0.1]),
        motor_torques=np.zeros(7),
        object_pose_hand=np.array([0, 0, 0.13, 1.0, 0, 0, 0]),
        hand_pose_world=np.array([0.3, 0.1, 0.5, 1.0, 0, 0, 0]),
    )


@pytest.fixture(scope="module")
def grasp(snapshot, obj, kinematics) -> PerceivedGrasp:
    return perceive(snapshot, obj, LIMIT, "all", kinematics)


def test_they_are_described_and_have_names_of_their_own():
    names = [m.name for m in ALL]
    assert len(set(names)) == len(names)
    assert not set(names) & {*METRICS, "success_probability"}
    for m in ALL:
        assert m.family in FAMILIES
        assert m.function.__name__ == m.name
        assert all((m.label, m.source, m.conventions, m.blind_to))


def test_every_one_has_a_value(grasp):
    values = {m.name: m.function(grasp) for m in ALL}
    assert not any(math.isnan(v) for v in values.values()), values
    assert values["grasp_robustness"] >= values["contact_robustness"] >= 0.0
    assert 0.0 < values["transmission_uniformity"] <= 1.0
    assert values["least_stiffness"] > 0.0


def test_a_hand_that_is_not_known_is_named(grasp):
    unknown = replace(grasp, kinematics=None)
    for m in (posture.METRICS[0], *compliance.METRICS, *probability.METRICS):
        with pytest.raises(gq.GraspError, match="kinematics: the perceived grasp has none"):
            m.function(unknown)


def test_a_grasp_of_earlier_versions_can_still_be_made(grasp):
    made = PerceivedGrasp(
        grasp.snapshot, grasp.obj, grasp.torque_limits, grasp.contacts, grasp.task
    )
    assert made.kinematics is None
    assert slip.slip_margin(made) == slip.slip_margin(grasp)


def test_copies_share_the_hand_and_a_pickled_grasp_finds_it_again(grasp):
    assert copy.deepcopy(grasp).kinematics is grasp.kinematics
    data = pickle.dumps(grasp)
    assert len(data) < 200_000  # not the compiled model
    again = pickle.loads(data)
    assert compliance.least_stiffness(again) == compliance.least_stiffness(grasp)
    assert pickle.loads(pickle.dumps(replace(grasp, kinematics=None))).kinematics is None


def test_the_springs_are_those_of_the_model(grasp):
    # models/schunk_sdh2: kp 30 of the spread joint, 20 of the others.
    assert servo_stiffness(grasp) == pytest.approx([30, 20, 20, 20, 20, 20, 20])
    straight, twist = rubber_stiffness(grasp)
    column = 1e6 * TAXEL_PITCH**2 / 3e-3
    assert straight == pytest.approx([column * len(p.contact.patch) for p in grasp.contacts])
    # 24 columns of 6 × 4 taxels: the polar moment of a rectangle of 6 × 4 pitches.
    polar = 24 * (6**2 + 4**2) / 12 * TAXEL_PITCH**2
    assert twist == pytest.approx(column * polar, rel=0.02)  # the pad is curved
    assert length_of(grasp) == pytest.approx(0.5 * np.linalg.norm(grasp.obj.extents_m))
    assert weight_wrenches(grasp) == pytest.approx(np.array([[0, 0, 0.831 * 9.81, 0, 0, 0]]))


def test_the_posture_counts_from_the_middle_of_the_ranges(grasp, kinematics):
    spans = np.array([motor.span for motor in kinematics.hand.motors])
    middle = replace(grasp.snapshot, joint_angles=spans.mean(axis=1))
    assert posture.range_deviation(replace(grasp, snapshot=middle)) == pytest.approx(0.0)


def test_the_slip_margin_agrees_with_the_capability(grasp):
    for mass in (0.3, 3.0):
        heavier = replace(grasp, task=grasp.task * mass / 0.831)
        capable = METRICS["q_capability"](heavier)
        assert (slip.slip_margin(heavier) >= 0.0) == (capable >= 1.0)


def test_without_errors_a_probability_says_what_q_says(grasp):
    for mass in (0.2, 3.0):
        heavier = replace(grasp, obj=replace(grasp.obj, mass_kg=mass))
        seen = perceive(heavier.snapshot, heavier.obj, LIMIT, "all", grasp.kinematics)
        found = probability.probabilities(seen, TrackingErrors(), samples=2)
        q = METRICS["q_linf"](seen)
        assert found.task == float(q > 1.0)
        assert found.median_q == pytest.approx(q, rel=1e-6)
        assert found.closure == 1.0
        assert found.epsilon == pytest.approx(METRICS["epsilon_l1"](seen), rel=1e-3)


def test_an_error_of_the_mass_alone_in_closed_form(grasp):
    """q* = c/m: P(q* > 1) = P(mass factor < q*) is a normal distribution's."""
    q = METRICS["q_linf"](grasp)
    wanted = 0.9 * q  # heavier, so that the mass decides
    obj = replace(grasp.obj, mass_kg=grasp.obj.mass_kg * wanted)
    seen = perceive(grasp.snapshot, obj, LIMIT, "all", grasp.kinematics)
    assert METRICS["q_linf"](seen) == pytest.approx(1 / 0.9, rel=1e-6)
    found = probability.probabilities(seen, TrackingErrors(mass_error=0.1), samples=200)
    expected = 0.5 * (1 + math.erf((1 / 0.9 - 1) / 0.1 / math.sqrt(2)))
    assert found.task == pytest.approx(expected, abs=4 * math.sqrt(expected * (1 - expected) / 200))


def test_the_same_seed_the_same_copies(grasp):
    errors = TrackingErrors(2e-3, 0.02, 0.05, 0.05)
    first = probability.probabilities(grasp, errors, samples=8, seed=3)
    assert probability.probabilities(grasp, errors, samples=8, seed=3) == first
    assert probability.probabilities(grasp, errors, samples=8, seed=4) != first
    with_pads = replace(grasp, contacts=grasp.contacts[:2])
    assert probability.probabilities(with_pads, errors, samples=8, seed=3) == first  # from readings


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"samples": 0}, "samples: expected an integer >= 1"),
        ({"samples": 2.5}, "samples: expected an integer >= 1"),
        ({"errors": TrackingErrors(position_error=-1.0)}, "position_error: expected a finite"),
        ({"errors": TrackingErrors(mass_error=math.nan)}, "mass_error: expected a finite"),
    ],
)
def test_bad_input_is_named(grasp, change, words):
    with pytest.raises(gq.GraspError, match=words):
        probability.probabilities(grasp, **change)
    with pytest.raises(gq.GraspError, match="contacts: got none"):
        probability.probabilities(replace(grasp, contacts=()))
