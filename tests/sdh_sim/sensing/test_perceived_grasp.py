"""Contacts of hand-made snapshots against what equations (6) and (7) give on paper."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sdh_sim.objects import ObjectInfo, object_info
from sdh_sim.robot import HandKinematics
from sdh_sim.sensing import (
    PadContact,
    SensorModel,
    TactileSensor,
    TactileSnapshot,
    pad_contacts,
    perceive,
)
from sdh_sim.sensing.perceived_grasp import gravity_task
from tests.support import sdh2
from tests.support.sdh2 import arrays, torque_limits

LIMIT = (1.6401, 1.0934)
UPRIGHT = np.array([0, 0, 0, 1.0, 0, 0, 0])
FINGER1, FINGER2, THUMB = range(3)
OWN = 0.0  # share of the object's normal: the pads' own alone


@pytest.fixture(scope="module")
def kinematics() -> HandKinematics:
    return HandKinematics()


@pytest.fixture(scope="module")
def obj() -> ObjectInfo:
    """The box with its centre of mass put at (10, 20, 30) mm."""
    return replace(object_info("box"), com_m=np.array([0.01, 0.02, 0.03]))


def snapshot(cells: dict, angles=None, object_pose=None, hand_pose=None) -> TactileSnapshot:
    """Readings at (kind, finger, row, column); object 150 mm over the palm frame by default."""
    proximal, distal = np.zeros((3, 14, 6)), np.zeros((3, 13, 6))
    for (kind, finger, row, column), value in cells.items():
        (proximal if kind == "proximal" else distal)[finger, row, column] = value
    above = np.array([0, 0, 0.15, 1.0, 0, 0, 0])
    return sdh2.snapshot(
        proximal=proximal,
        distal=distal,
        joint_angles=np.zeros(7) if angles is None else np.asarray(angles, dtype=float),
        motor_torques=np.zeros(7),
        object_pose_hand=above if object_pose is None else np.asarray(object_pose, dtype=float),
        hand_pose_world=UPRIGHT if hand_pose is None else np.asarray(hand_pose, dtype=float),
    )


def only(contacts: tuple[PadContact, ...]) -> PadContact:
    assert len(contacts) == 1
    return contacts[0]


def taxels(contact: PadContact) -> int:
    """How many taxels count."""
    assert contact.contact.patch is not None
    return len(contact.contact.patch)


def test_one_proximal_contact_by_hand(kinematics, obj):
    # Straight thumb, the two middle cells of the lowest row: centre (15.4, 0, 21.6) mm in the
    # link, (-38.11 + 15.4, 0, 91 + 21.6) = (-22.71, 0, 112.6) in the palm; less the object's
    # (0, 0, 150) and its centre of mass (10, 20, 30): (-32.71, -20, -67.4).
    cells = {("proximal", THUMB, 13, 2): 5.0, ("proximal", THUMB, 13, 3): 5.0}
    found = only(pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics))
    contact = found.contact
    assert found.pad == "thumb_proximal"
    assert contact.position * 1e3 == pytest.approx((-32.71, -20.0, -67.4), abs=1e-6)
    assert contact.normal == pytest.approx((1, 0, 0), abs=1e-12)
    assert contact.friction == 0.63
    # Equation (6): only the proximal joint bears it, at a lever of 21.6 mm:
    # 1.6401 / 0.0216 = 75.9306 N. Equation (7): both cells lie 1.7 mm from the centre.
    assert contact.max_normal_force == pytest.approx(75.9306, abs=1e-4)
    assert contact.max_torsion == pytest.approx(0.63 * 75.9306 * 1.7e-3, rel=1e-6)
    assert contact.patch is not None
    expected = [(-32.71, -21.7, -67.4), (-32.71, -18.3, -67.4)]
    assert contact.patch * 1e3 == pytest.approx(np.array(expected), abs=1e-6)
    # A turn of the proximal joint moves the point by (21.6, 0, -15.4) mm per radian.
    expected = np.zeros((6, 7))
    expected[:3, 3] = (0.0216, 0, -0.0154)
    expected[4, 3] = 1.0
    assert found.jacobian == pytest.approx(expected, abs=1e-12)


def test_a_turned_object_sees_the_contact_turned(kinematics, obj):
    # Object's x along the palm's y: in its axes the palm's x is (0, -1, 0), and the contact at
    # (-22.71, 0, -37.4) from its origin is (0, 22.71, -37.4); less (10, 20, 30).
    cells = {("proximal", THUMB, 13, 2): 5.0, ("proximal", THUMB, 13, 3): 5.0}
    turned = snapshot(cells, object_pose=[0, 0, 0.15, math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    found = only(pad_contacts(turned, obj, LIMIT, "all", kinematics))
    assert found.contact.position * 1e3 == pytest.approx((-10, 2.71, -67.4), abs=1e-6)
    assert found.contact.normal == pytest.approx((0, -1, 0), abs=1e-12)
    assert found.contact.max_normal_force == pytest.approx(75.9306, abs=1e-4)
    assert found.jacobian[:3, 3] == pytest.approx((0, -0.0216, -0.0154), abs=1e-12)


def test_fingertip_contact_by_hand(kinematics, obj):
    # Row 0 of the distal pad: (7.75, 62.07) mm, tilt 28.55 degrees, cos .878400, sin .477925.
    # Lever of the distal joint: 62.07 cos - 7.75 sin = 50.8184 mm; of the proximal joint, 86.5
    # further down: + 86.5 cos = 126.8000 mm. g* = min(1.6401 / .1268000, 1.0934 / .0508184)
    # = min(12.9345, 21.5158).
    cells = {("distal", THUMB, 0, 2): 1.0, ("distal", THUMB, 0, 3): 1.0}
    contact = only(pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics)).contact
    assert contact.normal == pytest.approx((0.878400, 0, 0.477925), abs=1e-5)
    assert contact.max_normal_force == pytest.approx(12.9345, abs=1e-4)
    # A strong proximal motor leaves the distal one to decide.
    strong = only(pad_contacts(snapshot(cells), obj, (9.0, 1.0934), "all", kinematics)).contact
    assert strong.max_normal_force == pytest.approx(21.5158, abs=1e-4)


def test_centre_is_weighted_by_pressure(kinematics, obj):
    # Readings 1 and 3 in columns 1 and 2: centre at column 1.75, y = -.75 * 3.4 = -2.55 mm; the
    # cells are .75 and .25 pitches away, mean weighted distance (.75 + 3 * .25) / 4 = .375
    # pitches = 1.275 mm.
    cells = {("proximal", THUMB, 13, 1): 1.0, ("proximal", THUMB, 13, 2): 3.0}
    contact = only(pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics)).contact
    assert contact.position[1] * 1e3 == pytest.approx(-20 - 2.55, abs=1e-9)
    assert contact.max_torsion == pytest.approx(0.63 * 75.9306 * 1.275e-3, rel=1e-6)
    # Only ratios count.
    cells = {key: 100 * value for key, value in cells.items()}
    again = only(pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics)).contact
    assert again.position == pytest.approx(contact.position, abs=1e-15)
    assert again.max_torsion == pytest.approx(contact.max_torsion)


def test_taxels_far_below_the_largest_of_their_pad_do_not_count(kinematics, obj):
    # 10, 1.01 and 1 in a row: a tenth of the largest does not count, what exceeds it does. The
    # other pad has its own largest reading.
    cells = {("proximal", THUMB, 13, column): v for column, v in ((1, 10.0), (2, 1.01), (3, 1.0))}
    cells["proximal", FINGER1, 5, 2] = 0.1
    found = pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics)
    assert [(p.pad, taxels(p)) for p in found] == [
        ("finger1_proximal", 1), ("thumb_proximal", 2),
    ]  # fmt: skip
    # Centre at column (10 + 2.02) / 11.01 = 1.09174, y = -1.40826 * 3.4 = -4.78810 mm.
    assert found[1].contact.position[1] * 1e3 == pytest.approx(-20 - 4.78810, abs=1e-5)
    every = perceive(snapshot(cells), obj, LIMIT, "all", kinematics, threshold=0.0).contacts
    assert [taxels(p) for p in every] == [1, 3]
    strict = perceive(snapshot(cells), obj, LIMIT, "all", kinematics, threshold=0.5).contacts
    assert [taxels(p) for p in strict] == [1, 1]


def test_crosstalk_makes_no_contact(kinematics, obj):
    # A stamp on 3 by 3 taxels lights 21 in three seconds; only the nine that it touches count.
    forces = np.zeros(486)
    rows, columns = np.mgrid[6:9, 1:4]
    forces[(2 * 84 + rows * 6 + columns).ravel()] = 5.0 / 9
    sensor = TactileSensor(SensorModel(noise=0.0, gain_spread=0.0), np.random.default_rng(0))
    for _ in range(90):
        sensor.frame(forces)
    proximal, _ = arrays(sensor.read())
    assert np.count_nonzero(proximal) == 21
    cells = {("proximal", *at): proximal[at] for at in zip(*np.nonzero(proximal), strict=True)}
    stamped = snapshot(cells)
    assert taxels(only(pad_contacts(stamped, obj, LIMIT, "all", kinematics))) == 9
    every = pad_contacts(stamped, obj, LIMIT, "all", kinematics, threshold=0.0)
    assert taxels(only(every)) == 21


def test_rows_are_weighted_too(kinematics, obj):
    # Rows 12 and 13, readings 3 and 1: a quarter of a pitch below row 12's 25.0 mm is 24.15.
    cells = {("proximal", THUMB, 12, 2): 3.0, ("proximal", THUMB, 13, 2): 1.0}
    contact = only(pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics)).contact
    assert contact.position[2] * 1e3 == pytest.approx(91 + 24.15 - 180, abs=1e-6)
    assert contact.max_normal_force == pytest.approx(1.6401 / 0.02415, rel=1e-6)


def test_taxels_are_projected_onto_the_tangent_plane(kinematics, obj):
    # Distal rows 0 and 2 alike: centre at row 1, (9.28, 59.04), tilt 25.19. Row 0 is (-1.53,
    # 3.03) away, of which (.904901, .425621) . = -.0948 is along the normal: 3.3931 mm are left;
    # row 2 (1.36, -3.12), -.0973 along the normal: 3.4021 mm.
    cells = {("distal", THUMB, 0, 2): 2.0, ("distal", THUMB, 2, 2): 2.0}
    contact = only(pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics)).contact
    assert contact.patch is not None
    away = contact.patch - contact.position
    assert away @ contact.normal == pytest.approx((0, 0), abs=1e-12)
    assert np.linalg.norm(away, axis=1) * 1e3 == pytest.approx((3.3931, 3.4021), abs=1e-3)
    assert contact.max_torsion / (0.63 * contact.max_normal_force) * 1e3 == pytest.approx(
        (3.3931 + 3.4021) / 2, abs=1e-3
    )


def test_normals_point_from_every_pad_into_what_it_presses(kinematics, obj):
    cells = {(kind, finger, 9, 2): 1.0 for kind in ("proximal", "distal") for finger in range(3)}
    contacts = pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics, OWN)
    assert [p.pad for p in contacts] == [
        "finger1_proximal", "finger2_proximal", "thumb_proximal",
        "finger1_distal", "finger2_distal", "thumb_distal",
    ]  # fmt: skip
    for p in contacts:
        sign = 1 if p.pad.startswith("thumb") else -1
        assert p.contact.normal == pytest.approx((sign, 0, 0), abs=1e-9)


def test_normals_are_those_of_the_surface_that_a_pad_meets(kinematics, obj):
    # The thumb leans by 30 degrees against the box's face at x = -35.9 mm, moved to where its pad
    # is: however it leans, and however deep it seems to be in, the face looks along x.
    cells = {("proximal", THUMB, 13, 2): 5.0, ("proximal", THUMB, 13, 3): 5.0}
    for angle, depth in ((30, 0.0), (-20, 0.0), (10, 4e-3), (10, -4e-3)):
        bent = snapshot(cells, angles=np.radians([0, 0, 0, angle, 0, 0, 0]))
        own = only(pad_contacts(bent, obj, LIMIT, "all", kinematics, OWN)).contact
        face = -35.9e-3 - obj.com_m[0]
        pose = bent.object_pose_hand.copy()
        pose[0] += own.position[0] - face - depth
        there = replace(bent, object_pose_hand=pose)
        found = only(pad_contacts(there, obj, LIMIT, "all", kinematics))
        assert found.contact.normal == pytest.approx((1, 0, 0), abs=1e-6)
        assert own.normal == pytest.approx(
            (math.cos(math.radians(angle)), 0, -math.sin(math.radians(angle))), abs=1e-6
        )
        half = only(pad_contacts(there, obj, LIMIT, "all", kinematics, 0.5)).contact.normal
        assert math.degrees(math.acos(half[0])) == pytest.approx(abs(angle) / 2, abs=1e-3)
        # Equation (6) asks what the motors can push along that normal.
        lever = found.contact.normal @ found.jacobian[:3]
        assert found.contact.max_normal_force == pytest.approx(
            float(
                min(
                    limit / abs(arm)
                    for limit, arm in zip(torque_limits(LIMIT), lever, strict=True)
                    if abs(arm) > 1e-9
                )
            )
        )
        patch = found.contact.patch
        assert patch is not None
        assert np.ptp(patch @ found.contact.normal) < 1e-12  # in the tangent plane


def test_a_pad_far_from_any_surface_that_faces_it_keeps_its_own_normal(kinematics, obj):
    # Behind the thumb lies the face that looks the other way.
    cells = {("proximal", THUMB, 13, 2): 5.0}
    behind = snapshot(cells, object_pose=[-0.2, 0, 0.15, 1, 0, 0, 0])
    found = only(pad_contacts(behind, obj, LIMIT, "all", kinematics)).contact
    assert found.normal == pytest.approx((1, 0, 0), abs=1e-12)


def test_only_the_distal_pads_if_asked_for(kinematics, obj):
    cells = {(kind, finger, 9, 2): 1.0 for kind in ("proximal", "distal") for finger in range(3)}
    contacts = pad_contacts(snapshot(cells), obj, LIMIT, "distal", kinematics)
    assert [p.pad for p in contacts] == ["finger1_distal", "finger2_distal", "thumb_distal"]


def test_taxels_that_do_not_exist_read_nothing(kinematics, obj):
    cells = {("distal", THUMB, 0, 0): 9.0, ("distal", THUMB, 4, 5): 9.0}
    assert pad_contacts(snapshot(cells), obj, LIMIT, "all", kinematics) == ()


def test_contact_wanders_with_the_finger(kinematics, obj):
    # Thumb at 30 degrees: link's x is (.8660254, 0, -.5), z (.5, 0, .8660254); (15.4, 21.6) mm
    # goes to (24.1368, 11.0061) from the axis at (-38.11, 91): (-13.9732, 102.0061).
    cells = {("proximal", THUMB, 13, 2): 5.0, ("proximal", THUMB, 13, 3): 5.0}
    bent = snapshot(cells, angles=np.radians([0, 0, 0, 30, 0, 0, 0]))
    contact = only(pad_contacts(bent, obj, LIMIT, "all", kinematics, OWN)).contact
    assert contact.position * 1e3 == pytest.approx((-23.9732, -20, -77.9939), abs=1e-3)
    assert contact.normal == pytest.approx((0.8660254, 0, -0.5), abs=1e-6)
    assert contact.max_normal_force == pytest.approx(75.9306, abs=1e-4)  # same lever


def test_gravity_tasks_push_up(obj):
    # Hand upright, object too: 0.831 kg * 9.81 = 8.15211 N up, at up to 20/3 mm from the centre
    # of mass: 0.054347 N m about a level axis.
    task = gravity_task(snapshot({}), obj)
    assert task.shape == (6, 20)
    assert task[:3] == pytest.approx(np.repeat([[0], [0], [8.15211]], 20, axis=1), abs=1e-9)
    moments = np.linalg.norm(task[3:], axis=0)
    assert moments.max() == pytest.approx(8.15211 * 0.02 / 3, rel=1e-9)
    assert np.abs(task[5]).max() < 1e-12


def test_gravity_tasks_follow_hand_and_object(obj):
    # The palm's z along the world's x and its x along the world's y: up in the palm is +y. The
    # object turned by 90 degrees about the palm's z sees that as its own x.
    half = 0.5
    forward = np.array([0, 0, 0, half, half, half, half])
    turned = [0, 0, 0.15, math.sqrt(0.5), 0, 0, math.sqrt(0.5)]
    task = gravity_task(snapshot({}, hand_pose=forward), obj)
    assert task[:3, 0] == pytest.approx((0, 8.15211, 0), abs=1e-9)
    task = gravity_task(snapshot({}, object_pose=turned, hand_pose=forward), obj)
    assert task[:3, 0] == pytest.approx((8.15211, 0, 0), abs=1e-9)


def test_perceive_gathers_it(kinematics, obj):
    seen = snapshot({("proximal", FINGER1, 13, 2): 1.0, ("proximal", FINGER2, 13, 2): 1.0})
    grasp = perceive(seen, obj, LIMIT, "all", kinematics)
    assert [p.pad for p in grasp.contacts] == ["finger1_proximal", "finger2_proximal"]
    assert grasp.torque_limits.tolist() == [1.6401, 1.6401, 1.0934, 1.6401, 1.0934, 1.6401, 1.0934]
    assert grasp.task == pytest.approx(gravity_task(seen, obj))
