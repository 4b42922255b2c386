"""A trial with a hand from a folder: one motor on a tendon of two jaws."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.cell import scene_builder
from sdh_sim.metrics import predict
from sdh_sim.objects import user_object
from sdh_sim.robot import hand_kinematics, read_hand_folder
from sdh_sim.sensing import take_snapshot
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from tests.support.hand_folders import write_hand

POST = """<mujoco><worldbody><body name="post">
  <geom type="box" size="0.025 0.025 0.06"/>
</body></worldbody></mujoco>"""
FACTS = """name = "post"
mass = 0.3
friction = 0.6
[grasp]
side = 0.0
offset = 0.002
yaw = 0.02
"""
FORCE = 60.0  # [N] of the motor, along the tendon


@pytest.fixture(scope="module")
def post(tmp_path_factory):
    folder = tmp_path_factory.mktemp("objects") / "post"
    folder.mkdir()
    (folder / "object.toml").write_text(FACTS, encoding="utf-8")
    (folder / "post.xml").write_text(POST, encoding="utf-8")
    return user_object(folder)


def test_the_jaws_press_as_statics_says_and_the_post_is_held(post, tmp_path, monkeypatch):
    hand = read_hand_folder(write_hand(tmp_path / "gripper"))
    monkeypatch.setattr(scene_builder, "built_in_hand", lambda *_: hand)
    settings = TrialSettings(
        post.name, folder=post.reference, hand="gripper", torque_limit=(FORCE,), arm="none"
    )
    trial = Trial(settings, 0)
    trial.acquire()
    simulation = trial.simulation
    # The jaws come 25 mm closer each, to the post's sides, as far as the rubber gives way.
    closed = simulation.scene.motor_positions(simulation.data)
    assert closed == pytest.approx([0.015], abs=1e-3)
    # Half of the motor's force on each jaw, pads and the rest of it together.
    assert simulation.data.actuator_force[simulation.scene.motors] == pytest.approx([FORCE])
    assert sum(simulation.hand_force()) == pytest.approx(2 * FORCE / 2, rel=0.03)
    snapshot = take_snapshot(simulation)
    prediction = predict(
        snapshot, trial.scene.obj, settings.torque_limit, "all", hand_kinematics(hand)
    )
    values = prediction.values
    assert len(prediction.grasp.contacts) == 2
    # One motor: a contact alone could bear twice what both can at once (L∞ against the motor).
    assert values["q_capability"] == pytest.approx(values["q_linf"] / 2, rel=0.1)
    motion = trial.lift()
    assert not motion.fell
    assert motion.displacement_mm < 10.0
    assert np.isfinite(motion.rotation_deg)
