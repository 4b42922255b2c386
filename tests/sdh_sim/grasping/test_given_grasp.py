"""From a grasp of a file to a plan: where the palm goes, and how the fingers close."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.errors import SettingsError
from sdh_sim.grasp_files import GraspEntry
from sdh_sim.grasping import plan_of
from sdh_sim.grasping.grasp_plan import OBJECT_POSITION
from sdh_sim.objects import object_info
from sdh_sim.robot import preshape_closing
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from sdh_sim.user_references import GraspSet
from tests.support.grasp_entries import entries

HALF = np.sqrt(0.5)  # cosine and sine of half a quarter turn


def test_a_pose_in_the_object_s_frame_turns_with_the_object():
    box = object_info("box")
    assert box.standing_quat == pytest.approx([HALF, HALF, 0, 0])  # its y points up, its z to -y
    # The palm's z points down, against the object's y; its x is the object's.
    pose = np.array([0.01, 0.3, 0.02, HALF, HALF, 0.0, 0.0])
    entry = GraspEntry("box", "a", pose, "parallel", object_yaw=np.pi / 2)
    plan = plan_of(entry, box)
    # A quarter turn about the vertical takes the object's x to the world's y, its z to the x.
    place = [OBJECT_POSITION[0] + 0.02, OBJECT_POSITION[1] + 0.01, box.standing_height + 0.3]
    assert plan.palm_position == pytest.approx(place, abs=1e-15)
    wanted = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]], dtype=float)
    assert plan.palm_rotation == pytest.approx(wanted, abs=1e-15)
    assert (plan.name, plan.turnable, plan.opening) == ("a", False, None)
    assert plan.closing is preshape_closing("parallel")


@pytest.mark.parametrize("entry", entries(8), ids=lambda entry: entry.name)
def test_a_plan_keeps_what_the_file_says(entry):
    obj = object_info(entry.object)
    plan = plan_of(entry, obj)
    found = plan.palm_in_object(obj)
    sign = np.sign(found[3:] @ entry.palm_pose[3:])  # q and -q are one rotation
    assert found[:3] == pytest.approx(entry.palm_pose[:3], abs=1e-12)
    assert sign * found[3:] == pytest.approx(entry.palm_pose[3:], abs=1e-12)
    assert plan.turnable == (entry.object_yaw is None)
    if entry.preshape:
        assert plan.opening == entry.ratio
    else:  # angles: the approach takes the open ones
        assert plan.opening == 0.0
        assert plan.closing.angles(0.0) == pytest.approx(entry.open, abs=1e-12)
        assert plan.closing.angles(1.0) == pytest.approx(entry.closed, abs=1e-12)


def test_a_trial_of_a_file_needs_a_grasp():
    settings = TrialSettings("box", grasps="file", grasp_set=GraspSet("/a.csv", "0" * 64))
    with pytest.raises(SettingsError, match="a trial with grasps from a file needs one of them"):
        Trial(settings, 0)
