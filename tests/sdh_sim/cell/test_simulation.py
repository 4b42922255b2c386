"""The simulation: references in even steps, torque peaks, divergence noticed at once."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim import poses
from sdh_sim.cell import Scene, Simulation, build_scene
from sdh_sim.errors import Diverged
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
    simulation = Simulation(scene)
    start = simulation.data.ctrl.copy()
    arm, hand = 0.01 * np.arange(1.0, 7.0), -0.02 * np.arange(1.0, 8.0)
    simulation.tick(arm, hand)
    target = np.empty_like(start)
    target[scene.arm_motors], target[scene.motors] = arm, hand
    assert len(steps) == simulation.steps == 5
    for k, control in enumerate(steps, start=1):
        assert control == pytest.approx(start + k / 5 * (target - start), abs=1e-15)


def test_poses_are_those_of_the_joints_as_they_are(scene):
    # A falling object: at speed v MuJoCo's own xpos is v dt behind qpos after a step.
    simulation = Simulation(scene)
    data, free = simulation.data, slice(scene.object_qpos, scene.object_qpos + 7)
    data.qpos[free] = 0.3, 0.6, 1.5, 1.0, 0.0, 0.0, 0.0
    data.qvel[scene.object_dof : scene.object_dof + 6] = 1.0, 0.0, 0.0, 0.0, 0.0, 2.0
    simulation.tick()
    before = data.xpos.copy()
    assert simulation.pose(scene.object_body) == pytest.approx(data.qpos[free], abs=1e-12)
    behind = data.qpos[scene.object_qpos] - data.xpos[scene.object_body, 0]
    assert behind == pytest.approx(1.0 * scene.model.opt.timestep, rel=1e-4)
    palm = simulation.pose(scene.palm)
    in_hand = poses.relative(palm, data.qpos[free])
    assert simulation.object_in_hand() == pytest.approx(in_hand, abs=1e-12)
    assert (data.xpos == before).all()  # the simulation is left as it is


def test_references_that_are_not_given_stay(scene, steps):
    simulation = Simulation(scene)
    arm, hand = np.full(6, 0.01), np.full(7, 0.02)
    simulation.tick(arm, hand)
    simulation.tick(hand=2.0 * hand)
    assert simulation.data.ctrl[scene.arm_motors] == pytest.approx(arm, abs=1e-15)
    assert simulation.data.ctrl[scene.motors] == pytest.approx(2.0 * hand, abs=1e-15)
    simulation.tick()
    assert (steps[-1] == steps[-5]).all()


def test_the_peak_is_that_of_every_step(scene, monkeypatch):
    simulation, seen, step = Simulation(scene), [], mujoco.mj_step

    def watched(model, data):
        step(model, data)
        seen.append(np.abs(data.actuator_force[scene.motors]))

    monkeypatch.setattr(mujoco, "mj_step", watched)
    for _ in range(3):
        simulation.tick(hand=simulation.data.ctrl[scene.motors] + 0.05)
    assert len(seen) == 15
    assert (simulation.peak == np.max(seen, axis=0)).all()
    assert simulation.peak.max() > 0.0


@pytest.mark.parametrize("speed", [np.nan, np.inf, 2e3])
def test_divergence_is_noticed_within_its_step(scene, monkeypatch, speed):
    simulation, taken, step = Simulation(scene), [], mujoco.mj_step

    def spoilt(model, data):
        step(model, data)
        taken.append(1)
        if len(taken) == 3:
            data.qvel[scene.object_dof] = speed

    monkeypatch.setattr(mujoco, "mj_step", spoilt)
    with pytest.raises(Diverged):
        simulation.tick()
    assert len(taken) == 3
    assert simulation.state()["qvel"][scene.object_dof] == pytest.approx(speed, nan_ok=True)


def test_restore_goes_back_but_for_the_clock(scene):
    simulation = Simulation(scene)
    simulation.wait(0.05)
    saved, places, speeds = (
        simulation.save(),
        simulation.data.qpos.copy(),
        simulation.data.qvel.copy(),
    )
    simulation.tick(hand=np.full(7, 0.1))
    later = simulation.time
    simulation.restore(saved)
    assert simulation.time == later
    assert (simulation.data.qpos == places).all()
    assert (simulation.data.qvel == speeds).all()
    assert (simulation.data.ctrl[scene.motors] == 0.0).all()


class Recorder:
    """An observer that notes when it is called and what it is given."""

    def __init__(self, name: str, calls: list[tuple[str, float, str]]) -> None:
        self.name, self.calls = name, calls

    def after_tick(self, scene: Scene, data: mujoco.MjData, phase: str) -> None:
        self.calls.append((self.name, data.time, phase))


def test_observers_are_called_after_every_tick_in_their_order(scene):
    calls: list[tuple[str, float, str]] = []
    simulation = Simulation(scene, [Recorder("log", calls)])
    simulation.phase = "first"
    simulation.tick()
    with simulation.observed_by(Recorder("sensor", calls)):
        simulation.phase = "second"
        simulation.tick()
    simulation.tick()
    assert [(name, round(time, 6), phase) for name, time, phase in calls] == [
        ("log", 0.01, "first"),
        ("sensor", 0.02, "second"),
        ("log", 0.02, "second"),
        ("log", 0.03, "second"),
    ]


def test_an_observer_leaves_when_its_block_is_broken_off(scene):
    simulation = Simulation(scene)
    with pytest.raises(KeyError), simulation.observed_by(Recorder("sensor", [])):
        raise KeyError
    assert simulation.observers == []
