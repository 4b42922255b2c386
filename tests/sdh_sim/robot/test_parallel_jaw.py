"""The parallel jaw against what its drawing and statics say on paper.

Drawing [mm], palm frame: z out of the guide, x along the stroke. Pads are 140 apart when open and
meet when closed, each jaw moving by 70. A pad is flat, 12 ahead of its jaw's frame; 14 rows by 6
columns of taxels lie 3.4 apart about its middle, 80 above the palm, row 0 at the tip, which is at
108. The left jaw, at -x, looks along +x, the right one along -x.

Statics: one motor moves both jaws by q, so by virtual work F δq = N_left δq + N_right δq. What both
pads press on in equal measure takes F / 2 from each; what one pad alone meets takes all of F.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.robot import HandKinematics, built_in_hand, hand_spec, joint_table

FORCE = 100.0  # rated [N]
HAND = built_in_hand("parallel_jaw")
SIDES = ("left", "right")


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(HAND.model))


def test_one_motor_moves_two_joints_alike():
    kinematics = HandKinematics(HAND)
    assert kinematics.selection.tolist() == [[1.0], [1.0]]
    assert [row[:2] for row in joint_table(HAND)] == [
        ("left_slide", "0"),
        ("right_slide", "0 (coupled)"),
    ]
    (motor,) = HAND.motors
    assert (motor.name, motor.rated, motor.span) == ("grip", FORCE, (0.0, 0.07))


@pytest.mark.parametrize("moved", [0.0, 0.02, 0.07])
def test_frames_and_pads_are_the_drawing(moved):
    posture = HandKinematics(HAND).at(np.array([moved]))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        position, axes = posture.link(f"{side}_jaw")
        assert position == pytest.approx((sign * (moved - 0.082), 0, 0), abs=1e-12)
        assert axes == pytest.approx(np.diag([sign, sign, 1.0]), abs=1e-12)
        point, normal = HAND.arrays["pad"].surface(6.5, 2.5)
        middle = position + axes @ point
        assert middle == pytest.approx((sign * (moved - 0.07), 0, 0.080), abs=1e-9)
        assert axes @ normal == pytest.approx((sign, 0, 0), abs=1e-12)
        speed = posture.jacobian(f"{side}_jaw", middle)
        assert speed == pytest.approx(np.array([[sign], [0], [0]]), abs=1e-12)
        assert not posture.spin_jacobian(f"{side}_jaw").any()


def test_the_mounting_face_is_120_mm_below_the_palm():
    offset, turn = HandKinematics(HAND).palm_offset()
    assert offset == pytest.approx((0, 0, 0.120))
    assert turn == pytest.approx((1, 0, 0, 0))


def test_every_taxel_s_apex_is_on_the_flat_pad(model):
    assert [pad.array.shape for pad in HAND.pads] == [(14, 6)] * 2
    assert HAND.tactile_size == 168
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for side in SIDES:
        for row in range(14):
            for column in range(6):
                geom = model.geom(f"{side}_pad_r{row:02d}_c{column}").id
                assert model.body(int(model.geom_bodyid[geom])).name == f"{side}_jaw"
                apex = model.geom_pos[geom] + (model.geom_size[geom, 0], 0, 0)
                expected = (0.012, (column - 2.5) * 0.0034, 0.080 + (6.5 - row) * 0.0034)
                assert apex == pytest.approx(expected, abs=1e-7)
                assert HAND.arrays["pad"].centres[row, column] == pytest.approx(expected, abs=1e-7)


def test_spheres_stay_within_the_finger_and_overlap(model):
    # The finger: y ±14, tip at 108; its back at x = -14, from z = 70 straight to -6 at the tip.
    for side in SIDES:
        for row in range(14):
            for column in range(6):
                geom = model.geom(f"{side}_pad_r{row:02d}_c{column}").id
                (_, y, z), radius = model.geom_pos[geom], model.geom_size[geom, 0]
                assert 3.4e-3 < radius <= 4 * 3.4e-3
                assert abs(y) + radius <= 0.014 + 1e-9
                assert z + radius <= 0.108 + 1e-9
                back = -0.014 + 0.008 * max(0.0, (z - 0.070) / 0.038)
                assert 0.012 - 2 * radius >= back


def test_contact_bits_are_those_of_every_hand(model):
    taxels = np.array(["_pad_r" in model.geom(k).name for k in range(model.ngeom)])
    structure = model.geom_group == 3
    assert (taxels.sum(), structure.sum()) == (168, 7)
    assert (model.geom_contype[taxels] == 2).all()
    assert (model.geom_priority[taxels] == 2).all()
    assert (model.geom_contype[structure] == 4).all()
    assert (model.geom_conaffinity[structure] == 12).all()
    assert not model.geom_contype[~(taxels | structure)].any()
    assert not model.geom_conaffinity[~structure].any()
    assert (model.geom_condim[taxels | structure] == 3).all()


def test_masses_and_inertias_are_those_of_the_boxes(model):
    assert model.body_mass.sum() == pytest.approx(0.80 + 2 * 0.14)
    # Palm: 0.55 kg of 120 x 75 x 75 mm about z = -67.5, 0.25 kg of 200 x 52 x 36 about -18.
    com = (0.55 * -67.5 + 0.25 * -18.0) / 0.80
    apart = 0.55 * (com + 67.5) ** 2 + 0.25 * (com + 18.0) ** 2
    across = (0.55 * (75**2 + 75**2) + 0.25 * (52**2 + 36**2)) / 12 + apart
    along = (0.55 * (120**2 + 75**2) + 0.25 * (200**2 + 36**2)) / 12 + apart
    upright = (0.55 * (120**2 + 75**2) + 0.25 * (200**2 + 52**2)) / 12
    palm = model.body("palm")
    assert palm.ipos == pytest.approx((0, 0, 1e-3 * com))
    assert sorted(palm.inertia) == pytest.approx(sorted(1e-6 * np.array([across, along, upright])))
    moments = np.sort(model.body_inertia[model.body_mass > 0], axis=1)
    assert (moments[:, 0] + moments[:, 1] > moments[:, 2]).all()
    assert (moments > 0).all()


def held(plate: tuple[float, float], slides: bool, seconds: float = 4.0):
    """The gripper closed on a plate between two x [m] in the palm frame by its rated force.

    A pad on a fixed plate comes to rest at a rate of 6/s only: that of a taxel's contact follows
    from the inertia of what it joins, here the jaw alone.

    Returns:
        the state at rest, and the normal forces of the pads on the plate (2,) [N].
    """
    spec = hand_spec(HAND)
    spec.option.gravity = np.zeros(3)
    spec.option.timestep = 0.002
    middle, half = sum(plate) / 2, (plate[1] - plate[0]) / 2
    # The palm lies 120 mm above the mounting face, the middle of the pads 80 above that.
    body = spec.worldbody.add_body(name="plate", pos=(middle, 0, 0.2))
    if slides:
        body.add_joint(name="slides", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(1, 0, 0))
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=(half, 0.05, 0.05), contype=1, conaffinity=15, mass=0.5
    )
    model = spec.compile()
    # Rubber of 1 MPa, 3 mm thick, as soft as the scene makes it: what the coupling yields by then
    # moves less than a thousandth of the force from one pad to the other.
    taxels = [k for k in range(model.ngeom) if "_pad_r" in model.geom(k).name]
    inverse = model.body_invweight0[model.geom_bodyid[taxels[0]], 0]
    inverse += model.body_invweight0[model.body("plate").id, 0]
    stiffness = 1e6 * 3.4e-3**2 / 3e-3 * (1 - 0.95) * inverse
    model.geom_solref[taxels] = (-stiffness, -2.0 * np.sqrt(stiffness))
    model.geom_solimp[taxels] = (0.95, 0.95, 0.001, 0.5, 2.0)
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.095  # 45 mm past the plate: more than saturates 5 kN/m
    mujoco.mj_step(model, data, round(seconds / 0.002))
    forces, wrench = np.zeros(2), np.zeros(6)
    for k in range(data.ncon):
        names = [model.geom(int(geom)).name for geom in data.contact.geom[k]]
        mujoco.mj_contactForce(model, data, k, wrench)
        for side, index in (("left", 0), ("right", 1)):
            if any(name.startswith(f"{side}_pad") for name in names):
                forces[index] += wrench[0]
    return data, forces


@pytest.mark.parametrize("slides", [False, True])
def test_both_pads_press_with_half_the_motor_s_force(slides):
    # In the middle, or off it and free: the jaws take a sliding plate along and centre it.
    data, forces = held((-0.02, 0.02) if not slides else (-0.025, 0.015), slides)
    assert data.actuator_force[0] == pytest.approx(FORCE)
    assert forces == pytest.approx(np.full(2, FORCE / 2), rel=1e-3)
    assert np.abs(data.qvel).max() < 1e-5


@pytest.mark.parametrize(("side", "plate"), [("left", (-0.05, 0.05)), ("right", (-0.05, 0.05))])
def test_one_pad_alone_takes_all_of_it_and_the_jaws_stay_together(side, plate):
    # A fixed plate that one pad meets 10 mm before the other would.
    shift = 0.01 if side == "right" else -0.01
    data, forces = held((plate[0] + shift, plate[1] + shift), False)
    expected = [FORCE, 0.0] if side == "left" else [0.0, FORCE]
    assert forces == pytest.approx(expected, rel=1e-3)
    left, right = (data.joint(f"{name}_slide").qpos[0] for name in SIDES)
    assert abs(left - right) < 1e-6
    # The coupling yields by R f / k: impedance d = 0.9999, k = 1 / (d T)² with T = 5 ms, inverse
    # inertia 2 / (1.9 + 0.14) kg, f the force that it carries to the right jaw.
    carried = FORCE if side == "right" else 0.0
    yields = (1 - 0.9999) * 2 / 2.04 * carried * 0.005**2
    assert left - right == pytest.approx(yields, rel=0.02, abs=1e-9)


def test_the_reference_goes_past_the_joint_s_end_by_what_the_rated_force_takes(model):
    # 1.25 x 100 N over 5 kN/m are 25 mm; a position beyond 70 mm is no position of the motor.
    assert model.actuator_ctrlrange[0] == pytest.approx((0.0, 0.095))
    assert HAND.motors[0].span == (0.0, 0.07)


def test_it_closes_at_50_mm_per_second_and_stops_at_its_ends(model):
    (closing,) = HAND.closings.values()
    assert closing.rate * closing.travel == pytest.approx([0.050], rel=1e-5)
    data = mujoco.MjData(model)
    steps, begin = round(1.0 / closing.rate / 0.002), 0.0
    for step in range(steps):
        data.ctrl[:] = closing.angles(closing.rate * 0.002 * step)
        if step == steps // 2:
            begin = data.qpos[0]
        mujoco.mj_step(model, data)
        assert abs(data.actuator_force[0]) < 0.15 * FORCE
        if step == steps // 2 + 50:
            assert (data.qpos[0] - begin) / (51 * 0.002) == pytest.approx(0.050, rel=0.01)
    mujoco.mj_step(model, data, 500)
    assert data.qpos == pytest.approx([0.07, 0.07], abs=1e-4)
    assert data.ncon == 0  # pads pass through each other; the fingers' metal stays 6 mm apart


@pytest.mark.parametrize("timestep", [0.001, 0.002, 0.005])
def test_random_controls_leave_it_finite_and_without_warnings(timestep):
    spec = hand_spec(HAND)
    spec.option.timestep = timestep
    model = spec.compile()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(5)
    for _ in range(40):
        data.ctrl[0] = rng.uniform(0.0, 0.07)
        mujoco.mj_step(model, data, round(0.1 / timestep))
        assert np.isfinite(data.qpos).all()
        assert np.abs(data.qvel).max() < 2.0
        assert data.qpos[0] == pytest.approx(data.qpos[1], abs=1e-5)
    mujoco.mj_step(model, data, round(1.0 / timestep))
    assert data.qpos[0] == pytest.approx(data.ctrl[0], abs=1e-5)
    assert not any(data.warning[k].number for k in range(mujoco.mjtWarning.mjNWARNING))
