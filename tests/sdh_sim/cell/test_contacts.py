"""Tactile arrays against MuJoCo's contact forces and the torques behind them."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from sdh_sim.cell import Scene, build_scene
from sdh_sim.cell.contacts import hand_force, taxel_forces
from sdh_sim.robot import HandKinematics, TaxelArray
from sdh_sim.robot import sdh2_constants as c
from sdh_sim.settings import TrialSettings
from tests.support import taxel_press as sdh_press
from tests.support.sdh2 import MOTOR_NAMES, PAD_OFFSETS, arrays

THUMB = [MOTOR_NAMES.index("thumb_proximal"), MOTOR_NAMES.index("thumb_distal")]
CELL = 3.4e-3**2  # [m^2]


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(TrialSettings("box"))


def squeeze(scene: Scene, data: mujoco.MjData, demand: tuple[float, float]) -> None:
    """Ramp the thumb's references beyond where they are [rad] in 0.5 s, then wait 1.5 s."""
    motors = scene.motors[THUMB]
    start = data.ctrl[motors].copy()
    for k in range(1000):
        data.ctrl[motors] = start + np.array(demand) * min(1.0, k / 250)
        mujoco.mj_step(scene.model, data)


@pytest.fixture(scope="module")
def proximal(scene) -> tuple[Scene, mujoco.MjData]:
    """The thumb's proximal pad against a fixed block, its motor at the limit of 1.6401 N m."""
    press = sdh_press.bolted(sdh_press.alone(scene, ("thumb", "proximal")))
    data = sdh_press.against_thumb_proximal(press)
    squeeze(press, data, (0.2, 0.0))
    return press, data


@pytest.fixture(scope="module")
def distal(scene) -> tuple[Scene, mujoco.MjData]:
    """The thumb's distal pad against a fixed block, the proximal motor at its limit."""
    press = sdh_press.bolted(sdh_press.alone(scene, ("thumb", "distal")))
    data = sdh_press.against_thumb_distal(press)
    squeeze(press, data, (0.2, 0.0))
    return press, data


def test_force_on_a_fixed_block_is_the_torque_over_the_lever(proximal):
    # The block's face is a plane x = constant: about the joint's axis, force along x has the
    # height of the centre of pressure as its lever, friction along z the face's distance.
    scene, data = proximal
    assert data.actuator_force[scene.motors][THUMB[0]] == pytest.approx(1.6401, abs=1e-12)
    pressed = arrays(taxel_forces(scene, data))[0][2]  # the thumb is the third finger
    heights = (21.6 + (13 - np.arange(14)) * 3.4) * 1e-3
    height = pressed.sum(axis=1) @ heights / pressed.sum()
    box = data.body("object/object").xmat.reshape(3, 3)
    force = sdh_press.contacts(scene, data)[2].sum(axis=0) @ box
    assert force[0] == pytest.approx(pressed.sum(), rel=1e-6)
    assert force[0] * height - force[2] * 15.4e-3 == pytest.approx(1.6401, rel=5e-3)
    assert 25.0 < pressed.sum() < 48.0  # 1.6401 N m over 34 to 65 mm


@pytest.mark.parametrize("which", ["proximal", "distal"])
def test_pad_forces_are_the_motors_torques_through_the_jacobian(which, request):
    # J^T f = tau, J from the kinematics of the bare hand and f from the pad: a wrong joint,
    # limit or frame anywhere makes the two differ. (Joint ranges read in degrees instead of
    # radians would let the joints' stops push: 260 N on the pad.)
    scene, data = request.getfixturevalue(which)
    torque = data.actuator_force[scene.motors]
    assert torque[THUMB[0]] == pytest.approx(1.6401, abs=1e-12)
    palm = data.xmat[scene.palm].reshape(3, 3)
    _, _, force, position = sdh_press.contacts(scene, data)
    kinematics = HandKinematics()
    posture = kinematics.at(data.qpos[scene.motor_qpos])
    held = np.zeros(7)
    for f, p in zip(force @ palm, (position - data.xpos[scene.palm]) @ palm, strict=True):
        held += posture.jacobian(f"thumb_{which}", p).T @ f
    assert held[THUMB] == pytest.approx(torque[THUMB], abs=3e-4)


def test_inverse_jacobian_predicts_the_force_on_the_distal_pad(distal):
    # The whole pad as one contact at its centre of pressure, as the metrics take it.
    scene, data = distal
    palm = data.xmat[scene.palm].reshape(3, 3)
    _, _, force, position = sdh_press.contacts(scene, data)
    in_palm = force @ palm
    centre = in_palm[:, 0] @ ((position - data.xpos[scene.palm]) @ palm) / in_palm[:, 0].sum()
    kinematics = HandKinematics()
    posture = kinematics.at(data.qpos[scene.motor_qpos])
    plane = posture.jacobian("thumb_distal", centre)[[0, 2]][:, THUMB]
    predicted = np.linalg.solve(plane.T, data.actuator_force[scene.motors][THUMB])
    assert predicted == pytest.approx(in_palm.sum(axis=0)[[0, 2]], rel=5e-3)
    assert taxel_forces(scene, data).sum() == pytest.approx(predicted[0], rel=5e-3)


@pytest.mark.parametrize("which", ["proximal", "distal"])
def test_arrays_sum_to_the_contact_force(which, request):
    scene, data = request.getfixturevalue(which)
    forces = taxel_forces(scene, data)
    assert forces.shape == (486,)
    pad = c.PADS.index(("thumb", which))
    first, last = PAD_OFFSETS[pad], PAD_OFFSETS[pad + 1]
    _, _, vectors, places = sdh_press.contacts(scene, data)
    normals = np.array([
        np.dot(v, data.contact.frame[k].reshape(3, 3)[0])
        for k, v in enumerate(vectors)
    ])  # fmt: skip
    link = data.body(f"hand/thumb_{which}")
    local = (places - link.xpos) @ link.xmat.reshape(3, 3)
    expected = np.zeros(486)
    for force, point in zip(np.abs(normals), local, strict=True):
        expected[first:last] += force * felt(scene.hand.pads[pad].array, point).ravel()
    assert forces == pytest.approx(expected, abs=1e-6)
    # Nobody but this pad feels anything, and the box feels the same force.
    assert forces[first:last].sum() == pytest.approx(forces.sum())
    box = data.body("object/object").xmat.reshape(3, 3)
    assert (vectors.sum(axis=0) @ box)[0] == pytest.approx(forces.sum(), rel=1e-3)
    assert hand_force(scene, data) == pytest.approx((forces.sum(), 0.0))


def felt(array: TaxelArray, point: np.ndarray) -> np.ndarray:
    """Share that every taxel feels of a force at a point of the link above the array.

    Bilinear between centres, clipped to the outermost ones; the row is found by trying them all.
    """

    def away(row: float) -> float:
        return float(np.sum((array.surface(row, 0.0)[0] - point)[::2] ** 2))

    tried = np.linspace(0.0, array.shape[0] - 1.0, 20 * array.shape[0])
    nearest = tried[int(np.argmin([away(row) for row in tried]))]
    about = np.clip((nearest - 0.1, nearest + 0.1), 0.0, tried[-1])
    row = minimize_scalar(away, bounds=about, method="bounded", options={"xatol": 1e-12}).x
    column = np.clip(point[1] / array.pitch + 2.5, 0.0, 5.0)
    rows = np.clip(1.0 - np.abs(np.arange(array.shape[0]) - row), 0.0, None)
    columns = np.clip(1.0 - np.abs(np.arange(6) - column), 0.0, None)
    share = np.where(array.live, np.outer(rows, columns), 0.0)
    return share / share.sum()


def test_no_contact_is_all_zero(scene):
    data = mujoco.MjData(scene.model)
    data.qpos[scene.arm_qpos] = sdh_press.ARM_POSTURE
    data.qpos[scene.object_qpos : scene.object_qpos + 3] = (0.3, 0.6, 2.0)
    mujoco.mj_forward(scene.model, data)
    assert not taxel_forces(scene, data).any()


def test_a_contact_without_constraint_row_counts_for_nothing(scene):
    press = sdh_press.alone(scene, ("thumb", "proximal"))
    data = sdh_press.against_thumb_proximal(press)
    sdh_press.push(press, data, "thumb_proximal", np.array([15.4e-3, 0, 43.7e-3]), 5.0, 0.3)
    before = taxel_forces(press, data)
    idle = data.ncon // 2
    lost = data.efc_force[data.contact.efc_address[:idle]].sum()
    data.contact.efc_address[:idle] = -1
    assert 0.0 < lost < before.sum()
    assert taxel_forces(press, data).sum() == pytest.approx(before.sum() - lost, rel=1e-2)
    data.contact.efc_address[:] = -1
    assert not taxel_forces(press, data).any()


@pytest.mark.parametrize("which", ["proximal", "distal"])
def test_shapes_and_masked_corners(which, request):
    scene, data = request.getfixturevalue(which)
    flat = taxel_forces(scene, data)
    near, far = arrays(flat)
    assert near.shape == (3, 14, 6)
    assert far.shape == (3, 13, 6)
    assert not far[:, :5, [0, 5]].any()
    assert (near if which == "proximal" else far)[2].any()


def test_arrays_keep_the_order_of_pads():
    near, far = arrays(np.arange(486.0))
    assert near[0, 0, 0] == 0
    assert near[1, 0, 0] == 84  # finger 2
    assert near[2, 13, 5] == 251  # the last cell of the thumb
    assert far[0, 0, 0] == 252
    assert far[2, 3, 4] == 252 + 2 * 78 + 3 * 6 + 4
