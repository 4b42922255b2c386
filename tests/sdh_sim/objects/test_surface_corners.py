"""Corners of an object's surface."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.objects import object_info, surface_corners, surface_of
from sdh_sim.objects.surface_corners import corners_of


def compiled(*geoms: str) -> mujoco.MjModel:
    """A model of one body with these geoms."""
    body = "".join(f"<geom {geom}/>" for geom in geoms)
    return mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><body name='object'>{body}</body></worldbody></mujoco>"
    )


def test_a_box_has_three_normals_at_every_corner():
    found = corners_of(compiled("type='box' size='.01 .02 .03' pos='.1 0 0'"))
    assert len(found.positions) == 24
    assert np.abs(found.positions - [0.1, 0, 0]) == pytest.approx(
        np.tile([0.01, 0.02, 0.03], (24, 1))
    )
    assert np.abs(found.normals).sum(axis=1) == pytest.approx(np.ones(24))
    # Into the box.
    assert ((found.positions - [0.1, 0, 0]) * found.normals).sum(axis=1).max() < 0


def test_what_lies_within_another_shape_is_no_surface():
    # The end of the lower box, four corners, is inside the upper one.
    found = corners_of(
        compiled("type='box' size='.01 .01 .02'", "type='box' size='.03 .03 .01' pos='0 0 .025'")
    )
    lower = np.abs(found.positions[:, :2]).max(axis=1) < 0.02
    assert lower.sum() == 12
    assert found.positions[lower, 2].max() == pytest.approx(-0.02)
    assert (~lower).sum() == 24


def test_a_cylinder_is_a_prism():
    found = corners_of(compiled("type='cylinder' size='.02 .04'"))
    # 64 corners at either end: one normal of the end and two of the sides each.
    assert len(found.positions) == 2 * 64 * 3
    assert np.linalg.norm(found.positions[:, :2], axis=1) == pytest.approx(np.full(384, 0.02))


@pytest.mark.parametrize("name", ["box", "cylindrical_bottle"])
def test_normals_are_those_of_the_surface(name):
    # Off a convex corner along a normal of it, that corner is the nearest point of the surface. In
    # concave edges, of which the bottle has some, another is.
    found = surface_corners(name)
    assert np.ptp(found.positions, axis=0) == pytest.approx(object_info(name).extents_m, rel=1e-3)
    rows = np.linspace(0, len(found.positions) - 1, 60).astype(int)
    probes = found.positions[rows] - 0.002 * found.normals[rows]
    error = np.abs(surface_of(name).inward_normals(probes) - found.normals[rows]).max(axis=1)
    assert np.quantile(error, 1.0 if name == "box" else 0.8) < 1e-9
