"""Transmissions read from the compiled model, against what the mechanism's equations say."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.errors import HandError
from sdh_sim.robot.mechanism import Mechanism

# Two links in a plane; each test says what drives them.
FINGER = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="near">
      <joint name="a" axis="0 1 0" {near}/>
      <geom type="capsule" fromto="0 0 0 0 0 0.05" size="0.008"/>
      <body name="far" pos="0 0 0.05">
        <joint name="b" axis="0 1 0" {far}/>
        <geom type="capsule" fromto="0 0 0 0 0 0.04" size="0.008"/>
      </body>
    </body>
  </worldbody>
  <tendon><fixed name="pull"><joint joint="a" coef="0.012"/><joint joint="b" coef="0.007"/></fixed>
  </tendon>
  <equality>{equality}</equality>
  <actuator>{motor}</actuator>
</mujoco>"""
ON_TENDON = '<position name="m" tendon="pull" kp="50000"/>'


def mechanism(motor=ON_TENDON, near="", far="", equality="", motors=("m",)):
    text = FINGER.format(motor=motor, near=near, far=far, equality=equality)
    return Mechanism(mujoco.MjModel.from_xml_string(text), motors, "finger")


def test_a_gear_on_a_joint_with_a_follower():
    # Motor position 4 a, and b = -0.5 a: a = m / 4.
    found = mechanism(
        '<position name="m" joint="a" gear="4" kp="10"/>',
        equality='<joint joint1="b" joint2="a" polycoef="0 -0.5 0 0 0"/>',
    )
    assert found.passive == ()
    assert found.positions(np.array([1.0])) == pytest.approx([0.25, -0.125])
    columns, transmission, _ = found.motions(np.array([0.25, -0.125]))
    assert columns == pytest.approx(np.array([[0.25], [-0.125]]))
    assert transmission is None


def test_a_follower_by_a_polynomial():
    # b = 0.1 + a + 0.5 a^2, so db/da = 1 + a; the tendon drives both: m = r_a a + r_b b.
    found = mechanism(equality='<joint joint1="b" joint2="a" polycoef="0.1 1 0.5 0 0"/>')
    a = 0.3
    b = 0.1 + a + 0.5 * a**2
    assert found.positions(np.array([0.012 * a + 0.007 * b])) == pytest.approx([a, b], abs=1e-8)
    columns = found.motions(np.array([a, b])).columns[:, 0]
    speed = 1.0 / (0.012 + 0.007 * (1.0 + a))
    assert columns == pytest.approx([speed, speed * (1.0 + a)])


def test_a_tendon_that_is_tied_makes_joints_dependent():
    # The tendon keeps its length: b = -(r_a / r_b) a.
    found = mechanism('<position name="m" joint="a" kp="10"/>', equality='<tendon tendon1="pull"/>')
    assert found.positions(np.array([0.2])) == pytest.approx([0.2, -0.2 * 12 / 7])


SPRUNG = {"near": 'stiffness="0.3"', "far": 'stiffness="0.2"'}


def test_an_underactuated_finger_settles_where_springs_and_tendon_balance():
    # Servo force F = k_p (m - L), joints q_i = r_i F / k_i, length L = Σ r_i q_i.
    found = mechanism(**SPRUNG)
    assert len(found.passive) == 1
    arms, springs, gain, at = np.array([0.012, 0.007]), np.array([0.3, 0.2]), 50000.0, 0.01
    compliance = (arms**2 / springs).sum()
    force = gain * at / (1.0 + gain * compliance)
    expected = arms * force / springs
    assert found.positions(np.array([at])) == pytest.approx(expected, rel=1e-4)
    assert (
        found.positions(np.array([at])).tobytes()
        == mechanism(**SPRUNG).positions(np.array([at])).tobytes()
    )  # the same bits in a mechanism that is new


def test_a_passive_joint_with_a_spring_counts_as_held():
    # What moves is the joint with the longer arm: speed 1 / r_a per speed of the tendon.
    found = mechanism(**SPRUNG)
    columns, transmission, driven = found.motions(np.zeros(2))
    assert transmission is None
    assert driven is None
    assert columns == pytest.approx(np.array([[1.0 / 0.012], [0.0]]))


def test_a_passive_joint_is_free_between_its_stops_and_held_at_them():
    found = mechanism(far='range="-1 1"', near='range="-1 1"')
    columns, transmission, driven = found.motions(np.array([0.3, 0.2]))
    assert columns == pytest.approx(np.eye(2))
    assert transmission == pytest.approx(np.array([[0.012, 0.007]]))
    assert driven == pytest.approx(np.array([[1.0 / 0.012], [0.0]]))
    held = found.motions(np.array([0.3, 0.995]))
    assert held.transmission is None
    assert held.columns == pytest.approx(np.array([[1.0 / 0.012], [0.0]]))


def test_virtual_work_holds_for_every_motion():
    found = mechanism(equality='<joint joint1="b" joint2="a" polycoef="0 0.8 0.3 0 0"/>')
    rng = np.random.default_rng(0)
    for at in rng.uniform(0.0, 0.01, 5):
        joints = found.positions(np.array([at]))
        step = 1e-6
        ahead = found.positions(np.array([at + step]))
        assert (ahead - joints) / step == pytest.approx(
            found.motions(joints).columns[:, 0], rel=1e-4
        )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"motors": ("other",)}, "its model has no actuator other"),
        ({}, "no motor moves b, and neither a spring nor a stop holds it"),
        (
            {
                "motor": ON_TENDON + '<position name="n" tendon="pull"/>',
                "motors": ("m", "n"),
                **SPRUNG,
            },
            "its 2 motors move only 1 joints that do not follow each other",
        ),
    ],
)
def test_what_is_no_mechanism_is_refused(given, message):
    with pytest.raises(HandError, match=message):
        mechanism(**given)


def test_a_posture_that_equalities_do_not_allow_is_refused():
    # b = a^2 + 1 and the tendon at -1: r_a a + r_b (a^2 + 1) has no root there.
    found = mechanism(equality='<joint joint1="b" joint2="a" polycoef="1 0.5 1 0 0"/>')
    with pytest.raises(HandError, match="equalities do not let the motors get to -1"):
        found.positions(np.array([-1.0]))
