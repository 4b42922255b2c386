"""Finger references: closing, stalling, squeezing."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.cell import build_scene
from sdh_sim.grasping import FingerControl
from sdh_sim.robot import preshape_closing
from sdh_sim.settings import TrialSettings
from tests.support import taxel_press as sdh_press
from tests.support.sdh2 import SDH2, torque_limits

LIMITS = torque_limits((1.6, 1.0))
STIFFNESS = np.array([30.0, 20, 20, 20, 20, 20, 20])
DAMPING = np.array([0.2, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05])
NOTHING = np.zeros(7)
# Motors: spread, finger 2, thumb, finger 1, proximal before distal; fingers in the order 1, 2,
# thumb.
SPREAD, F2_PROXIMAL, F2_DISTAL, T_PROXIMAL, T_DISTAL, F1_PROXIMAL, F1_DISTAL = range(7)


def control(preshape: str = "parallel", ratio: float = 0.2) -> FingerControl:
    return FingerControl(SDH2, preshape_closing(preshape), ratio, LIMITS, STIFFNESS, DAMPING)


def test_it_starts_at_the_preshape():
    fingers = control("spherical", 0.3)
    assert fingers.reference == pytest.approx(preshape_closing("spherical").angles(0.3))
    assert not fingers.closed
    assert not fingers.settled


def test_free_fingers_close_at_their_rate_until_fully_closed():
    fingers = control(ratio=0.2)
    for _ in range(100):
        fingers.close(NOTHING, 0.01)
    assert fingers.ratio == pytest.approx(np.full(3, 0.8))  # 0.6 per second
    assert fingers.reference == pytest.approx(preshape_closing("parallel").angles(0.8))
    assert not fingers.closed
    for _ in range(40):
        fingers.close(NOTHING, 0.01)
    assert fingers.ratio.tolist() == [1.0, 1.0, 1.0]
    assert fingers.closed


@pytest.mark.parametrize(
    ("motor", "finger"),
    [(F1_PROXIMAL, 0), (F1_DISTAL, 0), (F2_PROXIMAL, 1), (F2_DISTAL, 1), (T_PROXIMAL, 2),
     (T_DISTAL, 2)],
)  # fmt: skip
@pytest.mark.parametrize("sign", [1, -1])
def test_a_loaded_finger_stops_and_the_others_go_on(motor, finger, sign):
    fingers = control()
    torques = np.zeros(7)
    torques[motor] = sign * 0.21 * LIMITS[motor]
    fingers.close(torques, 0.01)
    assert np.flatnonzero(fingers.stalled).tolist() == [finger]
    for _ in range(10):
        fingers.close(NOTHING, 0.01)  # it stays stopped when the load goes
    expected = np.full(3, 0.2 + 11 * 0.006)
    expected[finger] = 0.2
    assert fingers.ratio == pytest.approx(expected)


def test_less_than_the_stall_torque_stops_nothing():
    fingers = control()
    fingers.close(0.19 * LIMITS, 0.01)
    assert not fingers.stalled.any()


@pytest.mark.parametrize("share", [0.0, 0.25, 0.8, 1.0])
def test_a_finger_goes_back_to_where_it_was_as_its_torque_crossed_the_stall_torque(share):
    # Torque in stall torques 1 - share at one tick and 2 - share at the next: it crossed 1 when
    # that share of the tick had passed.
    stall, torques = 0.2 * LIMITS[T_DISTAL], np.zeros(7)
    fingers = control(ratio=0.2)
    torques[T_DISTAL] = (1.0 - share) * stall
    fingers.close(torques, 0.01)
    torques[T_DISTAL] = (2.0 - share) * stall * (1.0 + 1e-12)
    fingers.close(torques, 0.01)
    assert fingers.stalled.tolist() == [False, False, True]
    assert fingers.ratio == pytest.approx([0.212, 0.212, 0.2 + share * 0.006])
    fingers.close(torques, 0.01)
    assert fingers.ratio[2] == pytest.approx(0.2 + share * 0.006)


def test_where_a_finger_stops_does_not_depend_on_the_tick():
    # A torque that grows with the closing ratio; ticks that begin anywhere.
    stall = 0.2 * LIMITS[F1_PROXIMAL]
    stops = []
    for first in (0.002, 0.0055, 0.01):
        fingers = control(ratio=0.2)
        torques, dt = np.zeros(7), first
        while not fingers.stalled[0]:
            torques[F1_PROXIMAL] = 10.0 * stall * (fingers.ratio[0] - 0.2)
            fingers.close(torques, dt)
            dt = 0.01
        stops.append(fingers.ratio[0])
    assert stops == pytest.approx([0.3] * 3, abs=1e-12)


@pytest.mark.parametrize(("limit", "stall"), [(0.4, 0.1288), (0.1, 0.09)])
def test_weak_motors_are_not_stopped_by_what_moving_takes(limit, stall):
    # A phalanx closes by 82 degrees over the ratio, at 0.6 a second: 0.05 N m s/rad take 0.0429 N m
    # of its motor, and three times that is 0.1288.
    def stopped(torque: float) -> bool:
        fingers = FingerControl(
            SDH2, preshape_closing("parallel"), 0.2, np.full(7, limit), STIFFNESS, DAMPING
        )
        torques = np.zeros(7)
        torques[T_DISTAL] = torque
        fingers.close(torques, 0.01)
        return bool(fingers.stalled[2])

    assert not stopped(0.99 * stall)
    assert stopped(1.01 * stall)


def test_the_spread_motor_stops_no_finger():
    fingers = control("centrical")
    torques = np.zeros(7)
    torques[SPREAD] = LIMITS[SPREAD]
    fingers.close(torques, 0.01)
    assert not fingers.stalled.any()


def test_closed_when_every_finger_is_stopped():
    fingers = control()
    torques = np.zeros(7)
    torques[[F1_PROXIMAL, F2_PROXIMAL]] = 1.0
    fingers.close(torques, 0.01)
    assert not fingers.closed
    torques[T_PROXIMAL] = 1.0
    fingers.close(torques, 0.01)
    assert fingers.closed


def test_squeeze_ramps_to_a_quarter_more_than_the_limit():
    fingers = control("parallel", 0.5)
    held = fingers.reference - 0.03  # the object holds the fingers back
    for _ in range(30):
        fingers.squeeze(held, 0.01)
    assert not fingers.settled
    # Half way: reference - angle = 0.5 * 1.25 * limit / kp of the proximal joints.
    assert (fingers.reference - held)[[F2_PROXIMAL, T_PROXIMAL, F1_PROXIMAL]] == pytest.approx(
        np.full(3, 0.5 * 1.25 * 1.6 / 20)
    )
    for _ in range(31):
        fingers.squeeze(held, 0.01)
    assert fingers.settled
    asked = STIFFNESS * (fingers.reference - held)
    assert asked[[F2_PROXIMAL, T_PROXIMAL, F1_PROXIMAL]] == pytest.approx(np.full(3, 2.0))
    # The others keep their references: spread and, with this preshape, the distal joints.
    kept = preshape_closing("parallel").angles(0.5)
    rest = [SPREAD, F2_DISTAL, T_DISTAL, F1_DISTAL]
    assert fingers.reference[rest] == pytest.approx(kept[rest])


@pytest.mark.parametrize("preshape", ["cylindrical", "spherical"])
def test_curling_preshapes_squeeze_with_the_distal_joints_too(preshape):
    fingers = control(preshape, 0.5)
    held = fingers.reference - 0.03
    for _ in range(61):
        fingers.squeeze(held, 0.01)
    distal = [F2_DISTAL, T_DISTAL, F1_DISTAL]
    assert (STIFFNESS * (fingers.reference - held))[distal] == pytest.approx(np.full(3, 1.25))


def test_squeeze_counts_from_where_it_began():
    fingers = control("parallel", 0.5)
    held = fingers.reference - 0.03
    fingers.squeeze(held, 0.01)
    for _ in range(60):
        fingers.squeeze(held - 0.5, 0.01)  # pushed back: the reference does not follow
    assert fingers.reference[T_PROXIMAL] == pytest.approx(held[T_PROXIMAL] + 1.25 * 1.6 / 20)


def test_a_squeezing_motor_gives_its_limit_and_no_more():
    # The real motors against a box that cannot move: 1.25 times the limit is asked for.
    scene = build_scene(TrialSettings("box"))
    scene = sdh_press.bolted(sdh_press.alone(scene, ("thumb", "proximal")))
    data = sdh_press.against_thumb_proximal(scene)
    limits = torque_limits(scene.settings.torque_limit)
    kp = scene.model.actuator_gainprm[scene.motors, 0]
    fingers = FingerControl(SDH2, preshape_closing("parallel"), 0.5, limits, kp, DAMPING)
    start = data.qpos[scene.motor_qpos].copy()
    peak = np.zeros(7)
    for _ in range(100):
        wanted = fingers.squeeze(start, 0.01)
        data.ctrl[scene.motors[T_PROXIMAL]] = wanted[T_PROXIMAL]
        for _ in range(5):
            mujoco.mj_step(scene.model, data)
            peak = np.maximum(peak, np.abs(data.actuator_force[scene.motors]))
    assert data.actuator_force[scene.motors[T_PROXIMAL]] == pytest.approx(1.6401, abs=1e-12)
    assert peak[T_PROXIMAL] <= 1.6401 + 1e-12
