"""A trial with a hand from a folder: one motor on a tendon of two jaws."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.metrics import METRICS, evaluate, grasp_of, predict, read_stored, snapshot_of
from sdh_sim.objects import user_object
from sdh_sim.records import write_rows
from sdh_sim.robot import hand_kinematics, read_hand_folder
from sdh_sim.runs import columns_of_run
from sdh_sim.sensing import take_snapshot
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, run_trial
from tests.support.hand_folders import GRIPPER, write_hand

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


def held_by(hand, post) -> TrialSettings:
    """The hand, floating, grasps the post."""
    return TrialSettings(
        post.name,
        folder=post.reference,
        hand=hand.name,
        hand_folder=hand.folder,
        torque_limit=(FORCE,),
        arm="none",
    )


def test_the_jaws_press_as_statics_says_and_the_post_is_held(post, tmp_path):
    hand = read_hand_folder(write_hand(tmp_path / "gripper"))
    settings = held_by(hand, post)
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


FLAP = GRIPPER.replace(
    '<geom name="left_box" class="finger"/>',
    '<geom name="left_box" class="finger"/><body name="flap" pos="0 0.002 0">'
    '<joint name="flap" axis="0 0 1" stiffness="0.1" damping="0.01" armature="0.001"/>'
    '<geom size="0.004" pos="0.012 0.01 0"/></body>',
)


def test_a_stored_grasp_has_the_positions_of_passive_joints(post, tmp_path):
    # A ball before the jaw gives way to the post: from 12 mm ahead of its joint to the pad's 10 mm
    # less its radius of 4 mm, at 15.6 mm from the joint (1 mm to either side: 0.09 rad).
    hand = read_hand_folder(write_hand(tmp_path / "hand", FLAP))
    settings = held_by(hand, post)
    row = {**run_trial(settings, 0).row, "trial": 0}
    file = tmp_path / "trials.parquet"
    write_rows([row], file, columns_of_run(settings))
    _, (stored,) = read_stored([file])
    flap = hand_kinematics(hand).model.joint("flap").qposadr[0]
    turned = np.arccos(6.0 / np.hypot(12.0, 10.0)) - np.arctan2(10.0, 12.0)
    assert stored["joint_positions"][flap] == pytest.approx(turned, abs=0.15)
    again = snapshot_of(stored)
    assert again is not None
    assert (again.joints == row["joint_positions"]).all()
    assert hand_kinematics(hand).joint_positions(again.joint_angles)[flap] == pytest.approx(
        0.0, abs=1e-6
    )
    grasp = grasp_of(stored, "all", hand_kinematics(hand), {post.name: post.reference})
    assert grasp is not None
    found = evaluate(grasp, {"q_linf": METRICS["q_linf"]})
    assert found["q_linf"] == pytest.approx(stored["q_linf"], rel=1e-5)
