"""The running cell: references in even steps, torque peaks, divergence noticed at once."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.cell.scene import Scene
from sdh_sim.cell.scene_builder import build_scene
from sdh_sim.errors import Diverged
from sdh_sim.report.html import Cell
from sdh_sim.settings import TrialSettings


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(TrialSettings("box"))


@pytest.fixture
def steps(monkeypatch):
    """The references of every step."""
    seen, step = [], mujoco.mj_step

    def watched(model, data):
        seen.append(data.ctrl.copy())
        step(model, data)

    monkeypatch.setattr(mujoco, "mj_step", watched)
    return seen


def test_references_go_to_their_new_values_evenly(scene, steps):
    cell = Cell(scene)
    start = cell.data.ctrl.copy()
    arm, hand = 0.01 * np.arange(1.0, 7.0), -0.02 * np.arange(1.0, 8.0)
    cell.tick(arm, hand)
    target = np.empty_like(start)
    target[scene.arm_motors], target[scene.motors] = arm, hand
    assert len(steps) == cell.steps == 5
    for k, control in enumerate(steps, start=1):
        assert control == pytest.approx(start + k / 5 * (target - start), abs=1e-15)


def test_references_that_are_not_given_stay(scene, steps):
    cell = Cell(scene)
    arm, hand = np.full(6, 0.01), np.full(7, 0.02)
    cell.tick(arm, hand)
    cell.tick(hand=2.0 * hand)
    assert cell.data.ctrl[scene.arm_motors] == pytest.approx(arm, abs=1e-15)
    assert cell.data.ctrl[scene.motors] == pytest.approx(2.0 * hand, abs=1e-15)
    cell.tick()
    assert (steps[-1] == steps[-5]).all()


def test_the_peak_is_that_of_every_step(scene, monkeypatch):
    cell, seen, step = Cell(scene), [], mujoco.mj_step

    def watched(model, data):
        step(model, data)
        seen.append(np.abs(data.actuator_force[scene.motors]))

    monkeypatch.setattr(mujoco, "mj_step", watched)
    for _ in range(3):
        cell.tick(hand=cell.data.ctrl[scene.motors] + 0.05)
    assert len(seen) == 15
    assert (cell.peak == np.max(seen, axis=0)).all()
    assert cell.peak.max() > 0.0


@pytest.mark.parametrize("speed", [np.nan, np.inf, 2e3])
def test_divergence_is_noticed_within_its_step(scene, monkeypatch, speed):
    cell, taken, step = Cell(scene), [], mujoco.mj_step

    def spoilt(model, data):
        step(model, data)
        taken.append(1)
        if len(taken) == 3:
            data.qvel[scene.object_dof] = speed

    monkeypatch.setattr(mujoco, "mj_step", spoilt)
    with pytest.raises(Diverged):
        cell.tick()
    assert len(taken) == 3
    assert cell.state()["qvel"][scene.object_dof] == pytest.approx(speed, nan_ok=True)


def test_restore_goes_back_but_for_the_clock(scene):
    cell = Cell(scene)
    cell.wait(0.05)
    saved, places, speeds = cell.save(), cell.data.qpos.copy(), cell.data.qvel.copy()
    cell.tick(hand=np.full(7, 0.1))
    later = cell.time
    cell.restore(saved)
    assert cell.time == later
    assert (cell.data.qpos == places).all()
    assert (cell.data.qvel == speeds).all()
    assert (cell.data.ctrl[scene.motors] == 0.0).all()
