"""q* of hand-made snapshots in closed form, its scaling, and what it may depend on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sdh_sim.metrics import NO_READING, predict
from sdh_sim.objects import ObjectInfo, object_info, user_object
from sdh_sim.robot import HandKinematics
from sdh_sim.sensing import TactileSnapshot
from sdh_sim.sensing import perceived_grasp as perception
from tests.support import sdh2

LIMIT = (1.6401, 1.0934)
FINGER1, FINGER2, THUMB = range(3)
G_MAX = 75.9306  # 1.6401 N m over 21.6 mm, the lowest row of a proximal pad
WEIGHT = 0.831 * 9.81


@pytest.fixture(scope="module")
def kinematics() -> HandKinematics:
    return HandKinematics()


@pytest.fixture
def on_the_spot(monkeypatch) -> None:
    """A centre of mass that is known exactly."""
    monkeypatch.setattr(perception, "TASK_RADIUS", 0.0)


@pytest.fixture(scope="module")
def plate(tmp_path_factory) -> ObjectInfo:
    """A plate across the palm's y, wide enough that no edge is near, as heavy as the box."""
    folder = tmp_path_factory.mktemp("plate")
    (folder / "object.toml").write_text(
        'name = "plate"\nmass = 0.831\nfriction = 0.63\ncom = [0.0, 0.0, 0.0]\n'
    )
    (folder / "plate.xml").write_text(
        '<mujoco><worldbody><body><geom type="box" size="0.06 0.01 0.06"/></body></worldbody>'
        "</mujoco>"
    )
    return object_info("plate", user_object(folder).reference)


@pytest.fixture
def obj() -> ObjectInfo:
    return replace(object_info("box"), com_m=np.zeros(3))


@pytest.fixture
def pinch() -> TactileSnapshot:
    """Fingers 1 and 2 oppose each other (spread 90 degrees), one taxel each, the object between.

    Column 2 of one finger and 3 of the other lie at the palm's x = 19.05 - 1.7 mm, row 13 at
    z = 91 + 21.6: there is the centre of mass.
    """
    proximal = np.zeros((3, 14, 6))
    proximal[FINGER1, 13, 2] = proximal[FINGER2, 13, 3] = 20.0
    return sdh2.snapshot(
        proximal=proximal,
        distal=np.zeros((3, 13, 6)),
        joint_angles=np.array([math.pi / 2, 0, 0, 0, 0, 0, 0]),
        motor_torques=np.zeros(7),
        object_pose_hand=np.array([17.35e-3, 0, 112.6e-3, 1, 0, 0, 0]),
        hand_pose_world=np.array([0.3, 0.1, 0.5, 1.0, 0, 0, 0]),
    )


@pytest.fixture
def grasp(pinch) -> TactileSnapshot:
    """The same with the thumb and patches wide enough for the uncertain centre of mass."""
    proximal = np.zeros((3, 14, 6))
    proximal[:2, 8:14, 1:5] = 20.0
    proximal[THUMB, 6:12, 1:5] = 10.0
    return replace(
        sdh2.with_arrays(pinch, proximal=proximal),
        joint_angles=np.array([0.2, -0.1, 0.1, 0, 0, -0.1, 0.1]),
        object_pose_hand=np.array([0, 0, 0.13, 1.0, 0, 0, 0]),
    )


def test_a_pinch_lifts_by_friction_alone(on_the_spot, kinematics, plate, pinch):
    # Gravity across both normals. Each finger, at its own g*, can lift mu g*: together 2 mu g*.
    # Under the L1 bound the two share one g*: half of that.
    found = predict(pinch, plate, LIMIT, "all", kinematics)
    assert [p.contact.max_normal_force for p in found.contacts] == pytest.approx([G_MAX] * 2)
    assert found.q_linf == pytest.approx(2 * 0.63 * G_MAX / WEIGHT, rel=1e-4)  # 11.736
    assert found.q_l1 == pytest.approx(0.63 * G_MAX / WEIGHT, rel=1e-4)  # 5.868
    assert found.reason == ""


def test_a_pinch_on_its_side_carries_with_the_lower_finger(on_the_spot, kinematics, plate, pinch):
    # The hand rolled by 90 degrees, so that gravity runs along the normals: the lower finger
    # pushes up with g* and the upper one with nothing, whichever way round the hand lies.
    for sign in (1, -1):
        roll = np.array([0, 0, 0, math.sqrt(0.5), sign * math.sqrt(0.5), 0, 0])
        found = predict(replace(pinch, hand_pose_world=roll), plate, LIMIT, "all", kinematics)
        assert found.q_linf == pytest.approx(G_MAX / WEIGHT, rel=1e-4)  # 9.314
        assert found.q_l1 == pytest.approx(G_MAX / WEIGHT, rel=1e-4)


def test_two_points_cannot_hold_a_centre_of_mass_off_their_line(kinematics, plate, pinch):
    found = predict(pinch, plate, LIMIT, "all", kinematics)
    assert found.q_linf == found.q_l1 == 0.0
    assert found.reason


def test_without_friction_no_pinch(on_the_spot, kinematics, plate, pinch):
    found = predict(pinch, replace(plate, friction=0.0), LIMIT, "all", kinematics)
    assert found.q_linf == found.q_l1 == 0.0


def test_no_reading_no_prediction(kinematics, obj, pinch):
    found = predict(
        sdh2.with_arrays(pinch, proximal=np.zeros((3, 14, 6))), obj, LIMIT, "all", kinematics
    )
    assert found.q_linf == found.q_l1 == 0.0
    assert found.reason == NO_READING
    assert found.contacts == ()


def test_q_is_proportional_to_the_torque_limit(kinematics, obj, grasp):
    base = predict(grasp, obj, LIMIT, "all", kinematics)
    assert base.q_linf > 0
    double = predict(grasp, obj, (2 * LIMIT[0], 2 * LIMIT[1]), "all", kinematics)
    assert double.q_linf == pytest.approx(2 * base.q_linf, rel=1e-6)
    assert double.q_l1 == pytest.approx(2 * base.q_l1, rel=1e-6)


def test_q_is_inverse_to_the_mass(kinematics, obj, grasp):
    base = predict(grasp, obj, LIMIT, "all", kinematics)
    heavy = predict(grasp, replace(obj, mass_kg=3 * obj.mass_kg), LIMIT, "all", kinematics)
    assert heavy.q_linf == pytest.approx(base.q_linf / 3, rel=1e-6)
    assert heavy.q_l1 == pytest.approx(base.q_l1 / 3, rel=1e-6)


def test_sharing_a_bound_never_helps(kinematics, obj, grasp):
    found = predict(grasp, obj, LIMIT, "all", kinematics)
    count = len(found.contacts)
    assert count == 3
    assert found.q_l1 <= found.q_linf <= count * found.q_l1 * (1 + 1e-9)


def test_q_keeps_below_what_all_contacts_can_push(kinematics, obj, grasp):
    found = predict(grasp, obj, LIMIT, "all", kinematics)
    most = sum(p.contact.max_normal_force * math.hypot(1, 0.63) for p in found.contacts)
    assert 0 < found.q_linf < most / WEIGHT


def test_it_depends_on_snapshot_shape_mass_friction_com_and_limits_only(kinematics, obj, grasp):
    base = predict(grasp, obj, LIMIT, "all", kinematics)
    # Elsewhere in the world, turned about the vertical: gravity is the same.
    turned = np.array([3.0, -2.0, 1.0, math.cos(0.4), 0, 0, math.sin(0.4)])
    # The same readings in other units.
    louder = sdh2.with_arrays(grasp, proximal=grasp.proximal * 7.0)
    # What the object needs to stand on the table and to be planned for.
    other = replace(
        obj, extents_m=np.ones(3), height=2.0, half_wide=1.0,
        inertia_kgm2=np.eye(3), standing_height=9.0,
    )  # fmt: skip
    for same, what in ((grasp, other), (louder, obj),
                       (replace(grasp, hand_pose_world=turned), obj)):  # fmt: skip
        again = predict(same, what, LIMIT, "all", kinematics)
        assert again.q_linf == pytest.approx(base.q_linf, rel=1e-9)
        assert again.q_l1 == pytest.approx(base.q_l1, rel=1e-9)
    # The motors' torques serve other metrics: q* takes the limits.
    strained = predict(replace(grasp, motor_torques=np.full(7, 1.5)), obj, LIMIT, "all", kinematics)
    assert (strained.q_linf, strained.q_l1) == (base.q_linf, base.q_l1)
    # And it does listen to what it may know.
    rounder = predict(grasp, replace(obj, name="oval_bottle"), LIMIT, "all", kinematics)
    assert rounder.q_linf != pytest.approx(base.q_linf)
    slippery = predict(grasp, replace(obj, friction=0.3), LIMIT, "all", kinematics)
    assert slippery.q_linf < base.q_linf
    askew = replace(obj, com_m=np.array([0.03, 0.0, 0.0]))
    assert predict(grasp, askew, LIMIT, "all", kinematics).q_linf != pytest.approx(base.q_linf)
    # ... but not to how deep along gravity the centre of mass lies: the line is the same.
    deeper = replace(obj, com_m=np.array([0.0, 0.0, -0.1]))
    assert predict(grasp, deeper, LIMIT, "all", kinematics).q_linf == pytest.approx(base.q_linf)


def test_the_same_snapshot_gives_the_same_bits(kinematics, obj, grasp):
    first = predict(grasp, obj, LIMIT, "all", kinematics)
    assert first.values == predict(grasp, obj, LIMIT, "all", kinematics).values
    assert first.values == predict(grasp, obj, LIMIT, "all", HandKinematics()).values
