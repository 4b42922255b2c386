"""How a user's object stands on the table."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.objects import object_info, user_object
from tests.support.object_files import FACTS, A, B, C, block, object_folder, refusal


@pytest.mark.parametrize(("up", "axis"), [("x", 0), ("y", 1), ("z", 2)])
def test_the_axis_named_points_up(tmp_path, up, axis):
    path = object_folder(tmp_path, block((0.01, 0.02, 0.03)), FACTS + f'up = "{up}"')
    found = user_object(path)
    model = found.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    rotation = data.body("object").xmat.reshape(3, 3)
    assert rotation[:, axis] == pytest.approx((0, 0, 1), abs=1e-9)
    assert object_info(found.name, found.reference).height == pytest.approx((A, B, C)[axis])
    assert data.site("base").xpos == pytest.approx(np.zeros(3), abs=1e-9)
    assert data.site("base").xmat.reshape(3, 3) == pytest.approx(np.eye(3), abs=1e-9)


def test_what_falls_over_is_refused(tmp_path):
    leaning = block((0.0, 0.0, 0.06))
    leaning.vertices[:, 0] += leaning.vertices[:, 2]  # sheared by 45 degrees
    assert "it falls over: standing on z up, its centre of mass is 30.0 mm beside" in refusal(
        object_folder(tmp_path, leaning)
    )
