"""Contacts of parts without taxels: by hand, in a bound by the motors, in the simulation."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from sdh_sim.cell import HAND_GEOM, OBJECT_GEOM, Simulation
from sdh_sim.metrics import METRICS, evaluate
from sdh_sim.objects import ObjectInfo, object_info
from sdh_sim.robot import HAND, HandKinematics
from sdh_sim.sensing import (
    PerceivedGrasp,
    TactileSnapshot,
    perceive,
    take_snapshot,
    unsensed_contacts,
)
from sdh_sim.sensing.unsensed_contacts import TOUCHING
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from tests.support import sdh2
from tests.support.sdh2 import torque_limits

LIMIT = (1.6401, 1.0934)
OPEN = np.array([0.0, -1.5, 0.0, -1.5, 0.0, -1.5, 0.0])  # fingers bent outwards, out of the way


@pytest.fixture(scope="module")
def kinematics() -> HandKinematics:
    return HandKinematics()


def over_palm(height: float) -> tuple[TactileSnapshot, ObjectInfo]:
    """The box over a palm that points up, its lowest face ``height`` over the palm's frame."""
    # The frame of the box is 77.6 mm over its lowest face.
    # 8 mm towards the thumb it lies beside the rubber of the fingers' proximal pads.
    pose = np.array([-0.008, 0, height + 0.0776, 1.0, 0, 0, 0])
    hand = np.array([0, 0, 0.5, 1.0, 0, 0, 0])
    nothing = np.zeros((3, 14, 6)), np.zeros((3, 13, 6))
    return sdh2.snapshot(*nothing, OPEN, np.zeros(7), pose, hand), object_info("box")


def first_touch(kinematics: HandKinematics) -> float:
    """Greatest height at which the box counts as touching, within a micrometre."""
    low, high = 0.0, 0.3
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        touching = unsensed_contacts(*over_palm(middle), kinematics)
        low, high = (middle, high) if touching else (low, middle)
    return low


def test_a_box_on_the_palm_touches_it_where_their_faces_meet(kinematics):
    height = first_touch(kinematics) - 1e-5
    snapshot, obj = over_palm(height)
    found = unsensed_contacts(snapshot, obj, kinematics)
    assert {contact.pad for contact in found} <= {
        *("palm", "thumb_knuckle", "finger1_knuckle", "finger2_knuckle")
    }
    assert len(found) >= 2
    for contact in found:
        assert contact.contact.normal == pytest.approx((0, 0, 1), abs=1e-6)
        # Halfway between the faces, which are a little less than TOUCHING apart.
        below = -0.0776 - obj.com_m[2] - 0.5 * TOUCHING
        assert contact.contact.position[2] == pytest.approx(below, abs=2e-5)
        assert contact.contact.friction == obj.friction
        # The spread turns the knuckles under the box; nothing lifts it.
        assert contact.contact.normal @ contact.jacobian[:3] == pytest.approx(0.0, abs=1e-9)


def test_what_the_palm_carries_needs_no_motor(kinematics):
    snapshot, obj = over_palm(first_touch(kinematics) - TOUCHING)
    obj = replace(obj, com_m=np.zeros(3))  # over the middle of the palm
    grasp = perceive(snapshot, obj, LIMIT, "all", kinematics)
    assert grasp.contacts == ()
    values = evaluate(grasp)
    assert values["q_whole_hand"] == np.inf
    assert {values[name] for name in METRICS if name != "q_whole_hand"} == {0.0}
    # The same palm over the box can hold nothing.
    snapshot = replace(snapshot, hand_pose_world=np.array([0, 0, 0.5, 0, 1.0, 0, 0]))
    assert evaluate(perceive(snapshot, obj, LIMIT, "all", kinematics))["q_whole_hand"] == 0.0


def test_pads_left_out_belong_to_the_whole_hand(kinematics):
    proximal = np.zeros((3, 14, 6))
    proximal[2, 13, 2:4] = 5.0
    pose = np.array([0, 0, 0.15, 1.0, 0, 0, 0])
    seen = sdh2.snapshot(proximal, np.zeros((3, 13, 6)), np.zeros(7), np.zeros(7), pose, pose)
    obj = object_info("box")
    every, distal = (perceive(seen, obj, LIMIT, pads, kinematics) for pads in ("all", "distal"))
    assert [c.pad for c in every.contacts] == ["thumb_proximal"]
    assert not distal.contacts
    assert "thumb_proximal" in [c.pad for c in distal.others]
    assert METRICS["q_whole_hand"](every) == pytest.approx(METRICS["q_whole_hand"](distal))


def loaded_parts(simulation: Simulation) -> set[str]:
    """Links whose parts without taxels press on the object with more than 0.1 N."""
    scene, model, data = simulation.scene, simulation.scene.model, simulation.data
    found = set()
    for k in range(data.ncon):
        geoms = data.contact.geom[k]
        groups = scene.geom_group[geoms]
        if set(groups) != {OBJECT_GEOM, HAND_GEOM} or (scene.taxel[geoms] >= 0).any():
            continue
        force = np.zeros(6)
        mujoco.mj_contactForce(model, data, k, force)
        if force[0] > 0.1:
            part = geoms[list(groups).index(HAND_GEOM)]
            found.add(model.body(int(model.geom_bodyid[part])).name.removeprefix(HAND))
    return found


@pytest.mark.parametrize("seed", [2, 4, 6])
def test_what_bears_load_in_the_simulation_is_found(seed, kinematics):
    settings = TrialSettings(object="box")
    trial = Trial(settings, seed)
    trial.acquire()
    simulation, obj = trial.simulation, trial.scene.obj
    truth = loaded_parts(simulation)
    found = unsensed_contacts(take_snapshot(simulation), obj, kinematics)
    assert truth <= {contact.pad for contact in found}
    assert truth  # these seeds are chosen for it


def test_more_contacts_never_lower_the_capability(kinematics):
    settings = TrialSettings(object="cylindrical_bottle")
    trial = Trial(settings, 1)
    trial.acquire()
    simulation, obj = trial.simulation, trial.scene.obj
    grasp = perceive(take_snapshot(simulation), obj, LIMIT, "all", kinematics)
    assert isinstance(grasp, PerceivedGrasp)
    assert grasp.torque_limits == pytest.approx(torque_limits(LIMIT))
    assert METRICS["q_whole_hand"](grasp) >= METRICS["q_capability"](grasp) - 1e-9 > 0.0
