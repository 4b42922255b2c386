"""The hand's kinematics against numbers worked out by hand from the table of dimensions.

Dimensions [mm], palm frame: finger bases (19.05, ±33, 74.5) and (-38.11, 0, 74.5), the fingers'
turned by 180 degrees about z; proximal axis 16.5 above the base, distal axis 86.5 further.
So at flexion angles p, d a finger that faces the horizontal direction e has its proximal axis at
height 91, its distal axis at base + 86.5 sin p e, height 91 + 86.5 cos p, its pad's x axis along
cos(p+d) e - sin(p+d) z and its own z axis along sin(p+d) e + cos(p+d) z.
Facing: thumb e = +x; finger 1 at spread s (-cos s, -sin s); finger 2 (-cos s, +sin s).
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from sdh_sim.model_files import models_dir
from sdh_sim.robot import HandKinematics, hand, preshape_closing
from tests.support.sdh2 import (
    FINGER_NAMES,
    MOTOR_NAMES,
    SDH2,
    live_mask,
    taxel_centres,
    torque_limits,
)

# Motors: spread, finger 2 proximal and distal, thumb the same, finger 1 the same [deg]; the
# body; its origin in the palm frame [mm]; its x and z axes. sin 30 = cos 60 = .5,
# cos 30 = sin 60 = .8660254, sin 75 = .9659258, cos 75 = .2588190, sin 20 = .3420201,
# cos 20 = .9396926.
POSTURES = [
    # All straight: distal axes at 74.5 + 16.5 + 86.5 = 177.5, the fingers facing the thumb.
    ((0, 0, 0, 0, 0, 0, 0), "thumb_distal", (-38.11, 0, 177.5), (1, 0, 0), (0, 0, 1)),
    ((0, 0, 0, 0, 0, 0, 0), "finger1_distal", (19.05, 33, 177.5), (-1, 0, 0), (0, 0, 1)),
    ((0, 0, 0, 0, 0, 0, 0), "finger2_distal", (19.05, -33, 177.5), (-1, 0, 0), (0, 0, 1)),
    ((0, 0, 0, 0, 0, 0, 0), "finger2_proximal", (19.05, -33, 91), (-1, 0, 0), (0, 0, 1)),
    # Thumb at 30 and 45: distal axis 86.5 (sin 30, cos 30) = (43.25, 74.9112) on from
    # (-38.11, 91); the distal link leans by 75.
    ((0, 0, 0, 30, 45, 0, 0), "thumb_proximal", (-38.11, 0, 91),
     (0.8660254, 0, -0.5), (0.5, 0, 0.8660254)),
    ((0, 0, 0, 30, 45, 0, 0), "thumb_distal", (5.14, 0, 165.9112),
     (0.2588190, 0, -0.9659258), (0.9659258, 0, 0.2588190)),
    # Finger 1 at spread 90 faces -y; proximal 90 lays it flat: 86.5 along -y from y = 33.
    ((90, 0, 0, 0, 0, 90, 0), "finger1_distal", (19.05, -53.5, 91), (0, 0, -1), (0, -1, 0)),
    # ... while finger 2, turned by the same motor, faces +y and stands straight.
    ((90, 0, 0, 0, 0, 90, 0), "finger2_distal", (19.05, -33, 177.5), (0, 1, 0), (0, 0, 1)),
    # Finger 2 at spread 60 faces (-.5, .8660254); proximal -30 moves it back along that by
    # 43.25: (+21.625, -37.4556), up 74.9112; distal 30 sets the tip upright again.
    ((60, -30, 30, 0, 0, 0, 0), "finger2_distal", (40.675, -70.4556, 165.9112),
     (-0.5, 0.8660254, 0), (0, 0, 1)),
    # Finger 1 at spread 60 faces (-.5, -.8660254); 20 of proximal: 86.5 (.3420201, .9396926)
    # = (29.5847, 81.2834), along the facing (-14.7924, -25.6211); distal -20: upright.
    ((60, 0, 0, 0, 0, 20, -20), "finger1_distal", (4.2576, 7.3789, 172.2834),
     (-0.5, -0.8660254, 0), (0, 0, 1)),
]  # fmt: skip


@pytest.fixture(scope="module")
def kinematics() -> HandKinematics:
    return HandKinematics()


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(models_dir() / "schunk_sdh2" / "sdh2.xml"))


@pytest.mark.parametrize(("motors", "body", "origin", "x", "z"), POSTURES)
def test_kinematics_are_the_tables(kinematics, motors, body, origin, x, z):
    posture = kinematics.at(np.radians(motors))
    position, rotation = posture.link(body)
    assert position * 1e3 == pytest.approx(origin, abs=1e-3)
    assert rotation[:, 0] == pytest.approx(x, abs=1e-6)
    assert rotation[:, 2] == pytest.approx(z, abs=1e-6)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@pytest.mark.parametrize(("motors", "body", "origin", "x", "z"), POSTURES)
def test_the_model_file_has_the_same_kinematics(model, motors, body, origin, x, z):
    # Joint by joint, with no help from sdh_sim; the mounting face is the world, the palm's
    # frame 7.5 mm above it.
    data = mujoco.MjData(model)
    names = ("spread", "finger2_proximal", "finger2_distal", "thumb_proximal", "thumb_distal",
             "finger1_proximal", "finger1_distal")  # fmt: skip
    for name, angle in zip(names, np.radians(motors), strict=True):
        data.joint(name).qpos[0] = angle
    data.joint("spread_coupled").qpos[0] = math.radians(motors[0])
    mujoco.mj_kinematics(model, data)
    assert data.body(body).xpos * 1e3 == pytest.approx(np.add(origin, (0, 0, 7.5)), abs=1e-3)
    rotation = data.body(body).xmat.reshape(3, 3)
    assert rotation[:, 0] == pytest.approx(x, abs=1e-6)
    assert rotation[:, 2] == pytest.approx(z, abs=1e-6)


def test_fingertip_is_68_5_mm_past_the_distal_axis(model):
    # Thumb at 30 and 45: (5.14, 165.9112) + 68.5 (.9659258, .2588190) = (71.3059, 183.6403).
    data = mujoco.MjData(model)
    data.joint("thumb_proximal").qpos[0] = math.radians(30)
    data.joint("thumb_distal").qpos[0] = math.radians(45)
    mujoco.mj_kinematics(model, data)
    tip = data.site("thumb_tip").xpos * 1e3 - (0, 0, 7.5)
    assert tip == pytest.approx((71.3059, 0, 183.6403), abs=1e-3)


def test_three_fingers_at_120_degrees_at_spread_60(kinematics):
    posture = kinematics.at(np.radians([60, 0, 0, 0, 0, 0, 0]))
    facing = [posture.link(f"{f}_distal")[1][:, 0] for f in FINGER_NAMES]
    for a, b in ((0, 1), (0, 2), (1, 2)):
        assert facing[a] @ facing[b] == pytest.approx(-0.5)


def test_jacobian_by_hand(kinematics):
    # Thumb at 30 and 45, centre of distal row 12: link (14.80, 22.45) mm leans by 75, so in the
    # palm (14.80 cos 75 + 22.45 sin 75, -14.80 sin 75 + 22.45 cos 75) = (25.5156, -8.4852) from
    # the distal axis and (68.7656, 66.4260) from the proximal one; a turn about +y moves (x, z)
    # by (z, -x) per radian.
    posture = kinematics.at(np.radians([0, 0, 0, 30, 45, 0, 0]))
    point = np.array([5.14 + 25.5156, 3.0, 165.9112 - 8.4852]) * 1e-3
    expected = np.zeros((3, 7))
    expected[:, 3] = (66.4260e-3, 0, -68.7656e-3)
    expected[:, 4] = (-8.4852e-3, 0, -25.5156e-3)
    assert posture.jacobian("thumb_distal", point) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("finger", FINGER_NAMES)
@pytest.mark.parametrize("kind", ["knuckle", "proximal", "distal"])
def test_jacobian_is_the_derivative_of_position(kinematics, finger, kind):
    rng = np.random.default_rng(3)
    body, step = f"{finger}_{kind}", 1e-6
    for _ in range(5):
        angles = rng.uniform(-1.2, 1.2, 7)
        angles[0] = rng.uniform(0.1, 1.4)
        local = rng.uniform(-0.05, 0.05, 3)

        def place(at, local=local):
            posture = kinematics.at(at)
            position, rotation = posture.link(body)
            return position + rotation @ local

        differences = np.column_stack([
            (place(angles + step * e) - place(angles - step * e)) / (2 * step) for e in np.eye(7)
        ])  # fmt: skip
        point = place(angles)
        posture = kinematics.at(angles)
        assert posture.jacobian(body, point) == pytest.approx(differences, abs=1e-9)
        moved = np.abs(differences).max(axis=0) > 1e-6
        own = {"knuckle": 0, "proximal": 1, "distal": 2}[kind]
        assert moved[0] == (finger != "thumb")  # the one spread motor turns both fingers
        first = {"finger2": 1, "thumb": 3, "finger1": 5}[finger]
        assert set(np.flatnonzero(moved[1:]) + 1) == set(range(first, first + own))


def test_spin_by_hand(kinematics):
    # Finger 1 at spread 60: the spread turns it about the palm's +z; its joints' axis is +y of
    # the base, which is turned by 180 + 60 degrees: (sin 60, -cos 60, 0).
    posture = kinematics.at(np.radians([60, 0, 0, 0, 0, 20, -20]))
    expected = np.zeros((3, 7))
    expected[:, 0] = (0, 0, 1)
    expected[:, 5] = expected[:, 6] = (0.8660254, -0.5, 0)
    assert posture.spin_jacobian("finger1_distal") == pytest.approx(expected, abs=1e-6)
    expected = np.zeros((3, 7))
    expected[:, 0] = (0, 0, -1)  # finger 2 turns the other way
    expected[:, 1] = (-0.8660254, -0.5, 0)
    assert posture.spin_jacobian("finger2_proximal") == pytest.approx(expected, abs=1e-6)


def test_limits_speeds_and_torques_are_the_data_sheets(model):
    assert MOTOR_NAMES == ("spread", "finger2_proximal", "finger2_distal", "thumb_proximal",
                                "thumb_distal", "finger1_proximal", "finger1_distal")  # fmt: skip
    quarter = math.pi / 2
    torque = [2.1, 2.1, 1.4, 2.1, 1.4, 2.1, 1.4]
    for name, tau in zip(MOTOR_NAMES, torque, strict=True):
        low = 0.0 if name == "spread" else -quarter
        assert model.joint(name).range == pytest.approx((low, quarter), abs=1e-8)
        assert model.jnt_limited[model.joint(name).id]
        motor = model.actuator(name)
        assert motor.forcerange == pytest.approx((-tau, tau))
        assert motor.ctrlrange == pytest.approx((low, quarter), abs=1e-8)
        assert model.actuator_forcelimited[motor.id]
        assert motor.trnid[0] == model.joint(name).id
        assert motor.gear[0] == 1.0
    assert model.joint("spread_coupled").range == pytest.approx((0, quarter), abs=1e-8)
    assert torque_limits((1.5, 0.5)).tolist() == [1.5, 1.5, 0.5, 1.5, 0.5, 1.5, 0.5]
    table = hand.joint_table(SDH2)
    assert len(table) == 8
    for name, _, tau, reach, speed in table:
        distal, spread = name.endswith("distal"), name.startswith("spread")
        assert tau == (1.4 if distal else 2.1)
        assert reach == pytest.approx((0 if spread else -quarter, quarter))
        assert math.degrees(speed) == pytest.approx(158 if distal else 86 if spread else 200)


def test_pads_are_84_and_68_cells():
    fingers = ("finger1", "finger2", "thumb")
    assert SDH2.pad_names == tuple(f"{f}_{k}" for k in ("proximal", "distal") for f in fingers)
    found = [(*p.array.shape, int(p.array.live.sum()), p.array.pitch) for p in SDH2.pads]
    assert found == [(14, 6, 84, 3.4e-3)] * 3 + [(13, 6, 68, 3.4e-3)] * 3
    assert live_mask("proximal").all()
    mask = live_mask("distal")
    expected = np.ones((13, 6), dtype=bool)
    expected[:5, [0, 5]] = False
    assert (mask == expected).all()


def test_taxel_centres_match_the_published_ones():
    proximal, distal = taxel_centres("proximal"), taxel_centres("distal")
    assert proximal.shape == (14, 6, 3)
    assert distal.shape == (13, 6, 3)
    # y = (column - 2.5) 3.4; proximal z = 21.6 + (13 - row) 3.4: 65.8 at row 0.
    assert proximal[0, 0] * 1e3 == pytest.approx((15.4, -8.5, 65.8))
    assert proximal[13, 5] * 1e3 == pytest.approx((15.4, 8.5, 21.6))
    assert distal[0, 1] * 1e3 == pytest.approx((7.75, -5.1, 62.07))
    assert distal[6, 3] * 1e3 == pytest.approx((14.18, 1.7, 42.82))


@pytest.mark.parametrize(
    ("preshape", "ratio", "spread", "proximal", "distal"),
    [
        # -75 + 82 c and 75 - 82 c degrees; spread 0 and 60.
        ("parallel", 0.0, 0, -75, 75),
        ("parallel", 0.5, 0, -34, 34),
        ("parallel", 1.0, 0, 7, -7),
        ("centrical", 0.25, 60, -54.5, 54.5),
        # -30 + 30 c and 30 + 35 c
        ("cylindrical", 0.0, 0, -30, 30),
        ("cylindrical", 1.0, 0, 0, 65),
        # -40 + 25 c and 40 + 15 c
        ("spherical", 0.6, 60, -25, 49),
    ],
)
def test_preshapes(preshape, ratio, spread, proximal, distal):
    expected = [spread, proximal, distal, proximal, distal, proximal, distal]
    assert np.degrees(preshape_closing(preshape).angles(ratio)) == pytest.approx(expected)


def test_preshape_takes_a_ratio_for_each_finger():
    # Fingers in the order finger 1, finger 2, thumb; motors begin with finger 2.
    angles = np.degrees(preshape_closing("cylindrical").angles([0.0, 0.5, 1.0]))
    assert angles == pytest.approx([0, -15, 47.5, 0, 65, -30, 30])


def test_preshapes_stay_inside_the_joint_limits():
    assert np.degrees(preshape_closing("cylindrical").angles(3.0))[2] == pytest.approx(90.0)
