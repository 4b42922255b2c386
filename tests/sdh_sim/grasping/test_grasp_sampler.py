"""Random grasps: determined by the generator, valid frames, ranges, the side they close across."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from sdh_sim.grasping import RandomGrasp, sample_grasp
from sdh_sim.grasping import grasp_sampler as grasps
from sdh_sim.objects import ObjectInfo, Spread, object_info, object_names
from sdh_sim.robot.sdh2_constants import PRESHAPES
from tests.support.sdh2 import SDH2


def draw(obj: ObjectInfo, count: int, seed: int = 0) -> list[RandomGrasp]:
    rng = np.random.default_rng(seed)
    return [sample_grasp(SDH2, obj, rng) for _ in range(count)]


def exact(monkeypatch, name: str, side: float, wide: float) -> None:
    monkeypatch.setitem(grasps.SPREADS, name, Spread(side, wide, 0.0, 0.0))


def plan(**changes) -> RandomGrasp:
    base = RandomGrasp("side", "parallel", 0.0, 0.0, 0.0, 0.1, 0.2, np.zeros(3), 0.0)
    return dataclasses.replace(base, **changes)


@pytest.mark.parametrize("name", object_names())
def test_the_generator_alone_decides(name):
    obj = object_info(name)
    first, again, other = draw(obj, 30), draw(obj, 30), draw(obj, 30, seed=1)
    for a, b in zip(first, again, strict=True):
        for field in dataclasses.fields(RandomGrasp):
            assert np.array_equal(getattr(a, field.name), getattr(b, field.name))
    assert any(a.azimuth != b.azimuth for a, b in zip(first, other, strict=True))


@pytest.mark.parametrize("name", object_names())
def test_palm_rotations_are_right_handed_and_orthonormal(name):
    for p in draw(object_info(name), 100):
        rotation = p.palm_rotation()
        assert rotation.T @ rotation == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1.0)


@pytest.mark.parametrize("name", object_names())
def test_ranges(name):
    obj = object_info(name)
    plans = draw(obj, 400)
    for p in plans:
        assert p.preshape in PRESHAPES
        low, high = SDH2.reaches[p.preshape].depth
        if p.approach == "side":
            assert abs(p.azimuth) <= math.radians(50)
            assert 0.0 <= p.tilt <= math.radians(15)
            assert 0.055 <= p.height <= obj.height - 0.025
            # Set back by what the near face is further than 40 mm from the axis.
            setback = [max(0.0, half - 0.040) for half in (obj.half_narrow, obj.half_wide)]
            assert low + min(setback) <= p.depth <= high + max(setback)
        else:
            assert p.approach == "top"
            assert p.roll == 0.0
            assert obj.height - 0.07 <= p.height <= obj.height - 0.015
            assert low <= p.depth <= high
        # The palm never starts inside the table or on the object's far side.
        assert p.palm_position(SDH2)[2] > 0.0
        assert p.palm_rotation()[2, 2] < 0.05
    assert {p.approach for p in plans} == {"side", "top"}
    assert {p.preshape for p in plans} == set(PRESHAPES)
    share = np.mean([p.approach == "side" for p in plans])
    assert share == pytest.approx(grasps.SPREADS[name].side, abs=0.08)


def test_errors_have_the_spread_asked_for():
    offsets = np.array([p.offset for p in draw(object_info("box"), 600)])
    assert offsets.shape == (600, 3)
    assert offsets.std(axis=0) == pytest.approx(np.full(3, grasps.SPREADS["box"].offset), rel=0.1)
    assert np.abs(offsets.mean(axis=0)).max() < 0.2 * grasps.SPREADS["box"].offset


def horizontal_angle(vector: np.ndarray) -> float:
    return math.atan2(vector[1], vector[0])


@pytest.mark.parametrize("name", ["box", "oval_bottle", "spray_bottle"])
@pytest.mark.parametrize("side", [0.0, 1.0])
@pytest.mark.parametrize("wide", [0.0, 1.0])
@pytest.mark.parametrize("narrow_yaw", [0.0, math.pi / 2])
def test_the_hand_closes_across_the_side_asked_for(monkeypatch, name, side, wide, narrow_yaw):
    exact(monkeypatch, name, side, wide)
    # All three have their narrow side along x; one modelled the other way round must do too.
    obj = dataclasses.replace(object_info(name), narrow_yaw=narrow_yaw)
    assert obj.half_narrow < obj.half_wide
    for p in draw(obj, 40):
        # The fingers close along the palm's x, which lies along the object's narrow side or
        # across it, whichever of its two senses.
        closing = p.palm_rotation()[:, 0]
        aligned = abs(math.cos(horizontal_angle(closing) - p.object_yaw - narrow_yaw))
        # Up to 15 degrees of tilt and 12 of rolling error blur it by a few degrees.
        assert aligned > 0.97 if wide == 0.0 else aligned < 0.25


@pytest.mark.parametrize("name", object_names())
def test_narrow_side_is_the_shape_s_own(name):
    # From the object's extents alone, turned as it stands.
    obj = object_info(name)
    quat = obj.standing_quat
    up_is_y = quat[0] == pytest.approx(math.sqrt(0.5))  # standing on its y axis: x, z are level
    level = obj.extents_m[[0, 2]] if up_is_y else obj.extents_m[[0, 1]]
    assert 2 * obj.half_narrow == pytest.approx(level.min(), abs=1e-6)
    assert 2 * obj.half_wide == pytest.approx(level.max(), abs=1e-6)
    assert (obj.narrow_yaw == 0.0) == (level[0] <= level[1])


def test_side_pose_by_hand():
    # Forward, level, 100 mm over the table, the object's axis 200 mm ahead of the palm at
    # (560, 0): the palm looks along x and closes along y; the point midway between thumb and
    # fingers is at -9.5 mm of its x, so it stands 9.5 mm to the left of the line.
    p = plan()
    assert p.palm_rotation() == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]))
    assert p.palm_position(SDH2) == pytest.approx((0.36, 0.0095, 0.1))
    # Three fingers at 120 degrees close on the palm's axis.
    assert plan(preshape="centrical").palm_position(SDH2) == pytest.approx((0.36, 0.0, 0.1))
    # 90 degrees to the left: along y.
    p = plan(azimuth=math.pi / 2, preshape="spherical")
    assert p.palm_position(SDH2) == pytest.approx((0.56, -0.2, 0.1))
    # Tilted down by 10 degrees: 200 sin 10 = 34.73 mm higher, 200 cos 10 = 196.96 mm back.
    p = plan(tilt=math.radians(10), preshape="spherical")
    assert p.palm_position(SDH2) * 1e3 == pytest.approx((363.04, 0, 134.73), abs=0.01)
    assert p.palm_rotation()[:, 2] == pytest.approx((0.984808, 0, -0.173648), abs=1e-6)


def test_top_pose_by_hand():
    # Straight down, palm's x along the world's: 200 mm over the grasp centre.
    p = plan(approach="top")
    assert p.palm_rotation() == pytest.approx(np.diag([1.0, -1.0, -1.0]), abs=1e-12)
    assert p.palm_position(SDH2) == pytest.approx((0.5695, 0.0, 0.3))
    p = plan(approach="top", azimuth=math.pi / 2)
    assert p.palm_rotation()[:, 0] == pytest.approx((0, 1, 0), abs=1e-12)
    assert p.palm_position(SDH2) == pytest.approx((0.56, 0.0095, 0.3))


def test_an_offset_moves_the_palm_along_its_own_axes():
    moved = plan(offset=np.array([0.001, 0.002, 0.003])).palm_position(SDH2) - plan().palm_position(
        SDH2
    )
    assert moved == pytest.approx((0.003, 0.001, 0.002))  # palm x, y, z are world y, z, x


def test_roll_turns_about_the_approach():
    p = plan(roll=math.pi / 2)
    assert p.palm_rotation()[:, 2] == pytest.approx((1, 0, 0), abs=1e-12)
    assert p.palm_rotation()[:, 0] == pytest.approx((0, 0, 1), abs=1e-12)


def test_an_unlisted_object_gets_the_default_spread():
    obj = dataclasses.replace(object_info("box"), name="teapot")
    assert {p.approach for p in draw(obj, 40)} == {"side", "top"}
