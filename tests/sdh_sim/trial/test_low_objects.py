"""Small and low objects: the fingertips pass above the table, and meet the object."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from sdh_sim.cell import build_scene
from sdh_sim.errors import NoFeasibleGrasp
from sdh_sim.grasping import plan_motion
from sdh_sim.grasping.fingertips import fingertip_reach
from sdh_sim.objects import user_object
from sdh_sim.robot.sdh2_constants import PRESHAPES
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial
from tests.support.sdh2 import SDH2


def folder(tmp_path, geom: str, mass: float):
    """An object of one geom, grasped without errors."""
    (tmp_path / "o.xml").write_text(
        f"<mujoco><worldbody><body><geom {geom}/></body></worldbody></mujoco>"
    )
    (tmp_path / "object.toml").write_text(
        f'name = "low"\nmass = {mass}\nfriction = 0.6\n[grasp]\noffset = 0.0\nyaw = 0.0\n'
    )
    return user_object(tmp_path)


@pytest.mark.parametrize(
    ("geom", "mass"),
    [
        ('type="box" size="0.015 0.015 0.015"', 0.05),
        ('type="box" size="0.030 0.030 0.030"', 0.3),
        ('type="cylinder" size="0.02 0.02"', 0.1),
        ('type="cylinder" size="0.03 0.04"', 0.1),
    ],
    ids=["cube 30", "cube 60", "cylinder 40", "cylinder 80"],
)
def test_low_objects_are_touched(tmp_path, geom, mass):
    own = folder(tmp_path, geom, mass)
    settings = TrialSettings(own.name, folder=own.reference)
    ended = Counter(run_trial(settings, seed).row.failure for seed in range(5))
    assert ended["no_contact"] == 0
    assert ended["none"] >= 4  # without errors of the hand almost all hold


def test_what_is_too_wide_is_named_with_what_would_do(tmp_path):
    own = folder(tmp_path, 'type="box" size="0.12 0.12 0.03"', 0.1)
    scene = build_scene(TrialSettings(own.name, folder=own.reference))
    with pytest.raises(NoFeasibleGrasp, match="500 draws") as error:
        plan_motion(scene, np.random.default_rng(0))
    text = str(error.value)
    assert "it stands 60 mm high and is 240 x 240 mm wide" in text
    assert "takes from above what is higher than 4 mm, from the side what is at least 80" in text
    assert "closes across 214 mm at most" in text


@pytest.mark.parametrize("preshape", PRESHAPES)
def test_fingertips_reach_less_far_on_wide_objects(preshape):
    reaches = [fingertip_reach(SDH2, preshape, half).lowest for half in (0.0, 0.02, 0.04, 0.06)]
    assert reaches == sorted(reaches, reverse=True)


def test_fingertips_of_straight_fingers_reach_their_length():
    # 91 mm to the proximal axis, 86.5 to the distal one, 68.5 to the tip, at 75/82 of the closing.
    assert fingertip_reach(SDH2, "parallel", 0.0).lowest == pytest.approx(0.246, abs=1e-4)
    # Open, the proximal links stand at -75 degrees and the distal ones upright. Their axes are
    # 2 x 86.5 sin 75 + 19.05 + 38.11 = 224.27 mm apart, each with a pad 14.8 mm ahead; but the
    # fingers meet 9.6 mm nearer to the pair's side than the middle, as the thumb's base is further.
    widest = fingertip_reach(SDH2, "parallel", 0.0).widest
    assert 0.170 < widest < 0.1947
