"""The hand's MJCF: masses, inertias, taxels, coupling, files as generated, stable under noise."""

from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest

from sdh_sim.model_files import models_dir
from sdh_sim.modelgen import hand as generator
from tests.support.generated_files import assert_same_files, model_files

FOLDER = models_dir() / "schunk_sdh2"
FINGERS = ("finger1", "finger2", "thumb")
# Mass [kg], centre of mass [mm], Ixx Iyy Izz Iyz at it [1e-6 kg m^2].
LINKS = {
    "palm": (1.0288, (0, 0, 38.7), (1189.6, 1188.9, 1563.6, 0)),
    "knuckle": (0.047, (0, 2.21, 12.16), (16.07, 7.01, 15.08, -0.48)),
    "proximal": (0.167, (0.75, -0.04, 43.02), (158.3, 158.2, 19.04, 9.26)),
    "distal": (0.0929, (0.99, 2.00, 31.59), (42.32, 39.74, 11.22, 5.80)),
}
# Distal taxel rows from the tip: x, z [mm], tilt of the normal [deg].
DISTAL_ROWS = [
    (7.75, 62.07, 28.55), (9.28, 59.04, 25.19), (10.64, 55.92, 21.83), (11.81, 52.73, 18.47),
    (12.79, 49.47, 15.11), (13.58, 46.17, 11.76), (14.18, 42.82, 8.40), (14.58, 39.44, 5.04),
    (14.78, 36.05, 1.68), (14.80, 32.65, 0), (14.80, 29.25, 0), (14.80, 25.85, 0),
    (14.80, 22.45, 0),
]  # fmt: skip


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(FOLDER / "sdh2.xml"))


def test_total_mass_is_1_95_kg(model):
    assert model.body_mass.sum() == pytest.approx(1.0288 + 3 * (0.047 + 0.167 + 0.0929))
    assert round(model.body_mass.sum(), 2) == 1.95


@pytest.mark.parametrize("link", LINKS)
def test_link_inertias_are_the_tables(model, link):
    mass, com, (ixx, iyy, izz, iyz) = LINKS[link]
    tensor = np.array([[ixx, 0, 0], [0, iyy, iyz], [0, iyz, izz]]) * 1e-6
    for name in ["palm"] if link == "palm" else [f"{f}_{link}" for f in FINGERS]:
        body = model.body(name)
        assert body.mass[0] == pytest.approx(mass)
        assert body.ipos * 1e3 == pytest.approx(com, abs=1e-9)
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        axes = turn.reshape(3, 3)
        assert axes @ np.diag(body.inertia) @ axes.T == pytest.approx(tensor, abs=1e-11)


def test_inertias_are_physically_possible(model):
    moving = model.body_mass > 0
    moments = np.sort(model.body_inertia[moving], axis=1)
    assert len(moments) == 10
    assert (moments > 0).all()
    # A rigid body's moments satisfy the triangle inequality.
    assert (moments[:, 0] + moments[:, 1] >= moments[:, 2]).all()
    # Radii of gyration fit inside the hand.
    gyration = np.sqrt(moments.max(axis=1) / model.body_mass[moving])
    assert (gyration < 0.06).all()


def taxels(model: mujoco.MjModel) -> dict[tuple[str, str, int, int], int]:
    pattern = re.compile(r"(finger1|finger2|thumb)_(proximal|distal)_r(\d\d)_c(\d)")
    found = {}
    for geom in range(model.ngeom):
        match = pattern.fullmatch(model.geom(geom).name)
        if match:
            finger, kind, row, column = match.groups()
            found[finger, kind, int(row), int(column)] = geom
    return found


def test_456_live_taxels_of_486(model):
    found = taxels(model)
    assert len(found) == 456
    every = {(f, "proximal", r, k) for f in FINGERS for r in range(14) for k in range(6)}
    every |= {(f, "distal", r, k) for f in FINGERS for r in range(13) for k in range(6)}
    assert len(every) == 486
    corners = {(f, "distal", r, k) for f in FINGERS for r in range(5) for k in (0, 5)}
    assert set(found) == every - corners


def test_taxel_apexes_are_the_published_positions(model):
    for (finger, kind, row, column), geom in taxels(model).items():
        y = (column - 2.5) * 3.4
        if kind == "proximal":
            apex, tilt = np.array([15.4, y, 21.6 + (13 - row) * 3.4]), 0.0
        else:
            x, z, tilt = DISTAL_ROWS[row]
            apex = np.array([x, y, z])
        normal = np.array([np.cos(np.radians(tilt)), 0, np.sin(np.radians(tilt))])
        assert model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE
        assert model.body(model.geom_bodyid[geom]).name == f"{finger}_{kind}"
        radius = model.geom_size[geom, 0]
        top = model.geom_pos[geom] + radius * normal
        assert top * 1e3 == pytest.approx(apex, abs=2e-4)
        # Less than one pitch and neighbours catch an edge; more than the half depth of the
        # finger and it stands out at the back.
        assert 3.4e-3 < radius < 0.0155


def test_taxels_meet_objects_only(model):
    ids = np.array(list(taxels(model).values()))
    assert (model.geom_contype[ids] == 2).all()
    assert not model.geom_conaffinity[ids].any()
    assert (model.geom_priority[ids] == 2).all()
    assert (model.geom_condim[ids] == 3).all()
    structure = model.geom_group == 3
    assert (model.geom_contype[structure] == 4).all()
    assert (model.geom_conaffinity[structure] == 12).all()
    rest = np.ones(model.ngeom, dtype=bool)
    rest[ids] = False
    rest &= ~structure
    assert not model.geom_contype[rest].any()
    assert not model.geom_conaffinity[rest].any()


def test_pads_stand_out_of_the_structure(model):
    # Else an object rests on the metal, unfelt: every taxel's apex is outside every solid of its
    # own link, by at least 2 mm, which is more than the rubber is ever pressed.
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for (finger, kind, row, column), geom in taxels(model).items():
        if column not in (2, 5):
            continue
        outward = _normal(data, geom, kind, row)
        apex = data.geom_xpos[geom] + model.geom_size[geom, 0] * outward
        hit = np.full(1, -1, dtype=np.int32)
        groups = np.array([0, 0, 0, 1, 0, 0], dtype=np.uint8)
        start = apex + 0.05 * outward
        reach = mujoco.mj_ray(model, data, start, -outward, groups, 1, -1, hit)
        assert hit[0] >= 0, (finger, kind, row, column)
        assert reach > 0.05 + 0.002, (finger, kind, row, column, model.geom(hit[0]).name)


def _normal(data: mujoco.MjData, geom: int, kind: str, row: int) -> np.ndarray:
    tilt = 0.0 if kind == "proximal" else np.radians(DISTAL_ROWS[row][2])
    return data.geom_xmat[geom].reshape(3, 3) @ np.array([np.cos(tilt), 0, np.sin(tilt)])


def test_nothing_of_the_open_hand_touches_itself(model):
    data = mujoco.MjData(model)
    for spread in (0.0, 0.5, 1.0, 1.5):
        data.qpos[:] = 0.0
        data.joint("spread").qpos[0] = data.joint("spread_coupled").qpos[0] = spread
        mujoco.mj_forward(model, data)
        assert data.ncon == 0


def test_one_motor_turns_both_fingers_by_the_same_angle(model):
    data = mujoco.MjData(model)
    data.actuator("spread").ctrl[0] = 1.0
    mujoco.mj_step(model, data, 1500)
    one, two = data.joint("spread").qpos[0], data.joint("spread_coupled").qpos[0]
    assert one == pytest.approx(1.0, abs=0.02)
    assert two == pytest.approx(one, abs=1e-3)
    # Opposite senses: the fingers turn towards each other, to (-cos s, -sin s), (-cos s, sin s).
    for finger, sign in (("finger1", -1), ("finger2", 1)):
        x = data.body(f"{finger}_knuckle").xmat.reshape(3, 3)[:, 0]
        assert x == pytest.approx((-np.cos(one), sign * np.sin(one), 0), abs=2e-3)
    assert [model.actuator(k).name for k in range(model.nu)].count("spread_coupled") == 0
    assert model.nu == 7


def test_random_controls_leave_it_finite_and_without_warnings(model):
    data = mujoco.MjData(model)
    rng = np.random.default_rng(11)
    low, high = model.actuator_ctrlrange.T
    limit = model.actuator_forcerange[:, 1]
    for _ in range(80):
        data.ctrl[:] = rng.uniform(low, high)
        for _ in range(25):
            mujoco.mj_step(model, data)
            assert (np.abs(data.actuator_force) <= limit).all()
        assert np.isfinite(data.qpos).all()
        assert np.abs(data.qvel).max() < 50.0
    spread, coupled = data.joint("spread").qpos[0], data.joint("spread_coupled").qpos[0]
    assert coupled == pytest.approx(spread, abs=0.02)
    reach = model.jnt_range
    assert (data.qpos > reach[:, 0] - 0.05).all()
    assert (data.qpos < reach[:, 1] + 0.05).all()
    assert not any(data.warning[k].number for k in range(mujoco.mjtWarning.mjNWARNING))


def test_committed_files_are_what_the_script_makes(tmp_path):
    generator.write_hand(tmp_path)
    assert_same_files(tmp_path, FOLDER, model_files(FOLDER), "sdh_sim.modelgen.hand")
