"""Settling of hands whose motors pull tendons, and of a hand with a passive joint."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.robot import read_hand_folder
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from sdh_sim.trial.outcome import moved_between
from tests.sdh_sim.trial.test_user_hand import FLAP, FORCE, held_by, post  # noqa: F401
from tests.support.hand_folders import GRIPPER, write_hand


def grasped(settings: TrialSettings) -> Trial:
    trial = Trial(settings, 0)
    trial.acquire()
    trial.snapshot()
    return trial


# The flap pushes sideways, at the limit of friction: it slides on in one and stays in the other.
@pytest.mark.parametrize(
    ("model", "differ_mm", "differ_deg"),
    [(GRIPPER, 0.2, 1.0), (FLAP, 2.0, 5.0)],
    ids=["tendon", "passive joint"],
)
def test_a_hand_from_a_folder_settles_as_in_the_simulation(
    model,
    differ_mm,
    differ_deg,
    post,  # noqa: F811
    tmp_path,
):
    hand = read_hand_folder(write_hand(tmp_path / "gripper", model=model))
    trial = grasped(held_by(hand, post))
    found = trial.settle()
    simulation = trial.simulation
    with simulation.without_table():
        simulation.wait(0.5)
    before, now = trial.row.object_pose_hand, simulation.object_in_hand()
    assert before is not None
    moved, turned = moved_between(before, now, trial.scene.obj.com_m)
    assert found.held
    assert found.displacement_mm == pytest.approx(moved, abs=differ_mm)
    assert found.rotation_deg == pytest.approx(turned, abs=differ_deg)
    assert np.abs(found.ways[0].state.torques) <= FORCE + 1e-9
    # What is known at the snapshot is known where it settles, too.
    after = found.grasp.snapshot
    assert trial.prediction is not None
    assert (after.joints is None) == (trial.prediction.grasp.snapshot.joints is None)
