"""The 500 published random grasps: q*, ε, V and force closure."""

import numpy as np
import pytest

import graspq as gq
from tests.support.published_grasps import need_reference


@pytest.mark.parametrize("name", ["box", "cylindrical_bottle"])
@pytest.mark.parametrize("bound", ["linf", "l1"])
def test_published_values(name, bound):
    data = np.load(need_reference())
    points, normals = data[f"{name}/points_m"], data[f"{name}/inward_vertex_normals"]
    friction = float(data[f"{name}/friction"])
    grasps = [
        [gq.contact_wrenches(gq.Contact(points[i], normals[i], friction)) for i in ids]
        for ids in data[f"{name}/grasp_vertex_ids"]
    ]
    wanted = [t[:, None].copy() for t in data[f"{name}/task_wrench"]]
    q = gq.task_scaling_batch(grasps, wanted, bound)
    np.testing.assert_allclose(q.value, data[f"{name}/q_{bound}"], rtol=1e-12)
    assert (q.upper - q.lower <= 1e-9 * q.value).all()
    closed = data[f"{name}/force_closure_{bound}"]
    eps = gq.epsilon_batch(grasps, bound)
    assert ((eps > 0) == closed).all()
    assert ([gq.is_force_closure(g) for g in grasps] == closed).all()
    np.testing.assert_allclose(
        eps[closed], data[f"{name}/epsilon_{bound}"][closed], rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        gq.volume_batch(grasps, bound), data[f"{name}/volume_{bound}"], rtol=1e-6
    )
