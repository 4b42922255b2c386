"""Drives that yield, hold and lock: closed forms on two fingers, and what a trial does with them.

Finger 1 and finger 2 press a free box from both sides with N = τ̄ / L. A force F on the box
pushes finger 1 back, finger 2 follows with its limit. Finger 1 gives way at N + F = τ̄ / L with a
motor that yields, so at F = 0; at (τ̄ + τ_f) / L with friction τ_f in its gear, so at F = τ_f /
L; and never with a gear that locks.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.validation.friction import CLAMP_ANGLES, CLAMP_BOX, CLAMP_PLACE, CLAMP_PUSH
from experiments.validation.rig_readings import touches
from experiments.validation.rigs import gripper, settings_for
from sdh_sim.cell import Simulation, build_scene
from sdh_sim.errors import SettingsError
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial

LIMIT, FRICTION = 1.0, 0.4  # τ̄ [N m], τ_f / τ̄
LEVER = 0.1138  # L [m]: proximal axis to the middle of the box, as the pads meet it
MM = 1e-3


class Pinch:
    """A box between two fingers at their limit, at rest."""

    def __init__(self, drive: str) -> None:
        settings = replace(settings_for(torque_limit=(LIMIT, 1.4)), drive=drive)
        settings = replace(settings, gear_friction=FRICTION)
        self.scene = gripper(CLAMP_PLACE, [CLAMP_BOX], True, settings, 0.8)
        self.simulation = Simulation(self.scene)
        data = self.simulation.data
        self.scene.pose_hand(data, CLAMP_ANGLES)
        data.ctrl[self.scene.motors] = CLAMP_ANGLES
        reach = CLAMP_PUSH * (1.25 * (1.0 + FRICTION) * LIMIT / 20.0 + 0.05)
        for share in np.linspace(0.0, 1.0, 150):
            self.simulation.tick(hand=CLAMP_ANGLES + share * reach)
        self.simulation.wait(0.5)

    def forces(self) -> np.ndarray:
        """What the two fingers press with (2,) [N]."""
        touch = touches(self.scene, self.simulation.data)
        across = touch.forces[:, 1]
        return np.array(
            [abs(across[np.char.startswith(touch.links, f"finger{k}")].sum()) for k in (1, 2)]
        )

    def moved(self, force: float) -> float:
        """How far a force on the box towards finger 1 moves it within a second [m]."""
        data, body = self.simulation.data, self.scene.object_body
        before = data.xpos[body, 1]
        for share in np.linspace(0.05, 1.0, 20):
            data.xfrc_applied[body, 1] = share * force
            self.simulation.tick()
        self.simulation.wait(0.8)
        return float(data.xpos[body, 1] - before)


@pytest.mark.parametrize("drive", ["yield", "hold", "lock"])
def test_all_drives_push_with_the_limit(drive):
    assert Pinch(drive).forces() == pytest.approx(LIMIT / LEVER, rel=0.03)


@pytest.mark.parametrize(
    ("drive", "borne", "given_way"),
    [
        ("yield", 0.0, 0.1),
        ("hold", 0.95 * FRICTION, 1.5 * FRICTION),
        ("lock", 5.0, None),
    ],
)
def test_what_pushes_two_fingers_back(drive, borne, given_way):
    pinch = Pinch(drive)
    state = pinch.simulation.save()
    force = borne * LIMIT / LEVER
    assert abs(pinch.moved(force)) < (0.5 if drive == "lock" else 0.15) * MM
    if drive == "lock":  # finger 1 bears what it could never push with
        first, second = pinch.forces()
        assert first > 4.0 * LIMIT / LEVER
        assert first - second == pytest.approx(force, rel=0.02)
    if given_way is not None:
        pinch.simulation.restore(state)
        assert pinch.moved(given_way * LIMIT / LEVER) > 0.9 * MM


def test_a_locked_joint_keeps_its_place():
    pinch = Pinch("lock")
    before = pinch.scene.motor_positions(pinch.simulation.data)
    pinch.moved(3.0 * LIMIT / LEVER)
    after = pinch.scene.motor_positions(pinch.simulation.data)
    assert np.abs(after - before).max() < 2e-3


def test_a_locked_joint_opens_when_its_motor_opens_it():
    pinch = Pinch("lock")
    opened = CLAMP_ANGLES - 0.2 * CLAMP_PUSH
    for _ in range(60):
        pinch.simulation.tick(hand=opened)
    found = pinch.scene.motor_positions(pinch.simulation.data)[CLAMP_PUSH]
    assert found == pytest.approx(opened[CLAMP_PUSH], abs=0.01)


def test_a_saved_state_knows_where_the_stops_are():
    pinch = Pinch("lock")
    state = pinch.simulation.save()
    first = pinch.moved(2.0 * LIMIT / LEVER)
    pinch.simulation.restore(state)
    again = pinch.moved(2.0 * LIMIT / LEVER)
    assert again == pytest.approx(first, abs=1e-6)


@pytest.mark.parametrize("drive", ["hold", "lock"])
def test_a_trial_with_another_drive_is_repeated_bit_for_bit(drive):
    settings = TrialSettings("box", arm="none", drive=drive)
    rows = []
    for _ in range(2):
        trial = Trial(settings, 1)
        trial.acquire()
        rows.append((trial.snapshot().motor_torques, trial.simulation.object_in_hand()))
    assert np.array_equal(rows[0][0], rows[1][0])
    assert np.array_equal(rows[0][1], rows[1][1])
    limits = np.array([1.6401, 1.6401, 1.0934, 1.6401, 1.0934, 1.6401, 1.0934])
    assert (np.abs(rows[0][0]) <= limits).all()


def test_yield_changes_nothing_of_the_model():
    usual = build_scene(TrialSettings("box", hand="parallel_jaw")).model
    held = build_scene(TrialSettings("box", hand="parallel_jaw", drive="hold")).model
    assert not usual.dof_frictionloss.any()
    assert held.dof_frictionloss.sum() == pytest.approx(0.5 * 0.25 * 100.0)
    assert held.actuator_forcerange[-1, 1] == pytest.approx(1.125 * 100.0)


def test_settling_is_refused_with_a_drive_that_does_not_yield():
    with pytest.raises(SettingsError, match="settle: got 'verdict' with drive 'lock'; the predict"):
        TrialSettings("box", drive="lock", settle="verdict")
