"""Driving a validation rig to rest, and reading forces and taxels from it."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

import graspq as gq
from sdh_sim.cell import Scene
from sdh_sim.cell.contacts import taxel_forces
from sdh_sim.robot import HAND, Hand, hand_kinematics

TICK = 0.01  # [s] between two set points of the motors


def advance(scene: Scene, data: mujoco.MjData, seconds: float) -> None:
    """Step for a time [s]."""
    for _ in range(round(seconds / scene.model.opt.timestep)):
        mujoco.mj_step(scene.model, data)


def copy(scene: Scene, data: mujoco.MjData) -> mujoco.MjData:
    """An independent copy of a state."""
    other = mujoco.MjData(scene.model)
    mujoco.mj_copyData(other, scene.model, data)
    return other


def pressed(scene: Scene, force: float) -> mujoco.MjData:
    """A bench whose test body has come to rest under a force [N] on its pad.

    Rubber of this contact model settles within 0.1 s or so, whatever the test body's mass.
    """
    data = mujoco.MjData(scene.model)
    data.qfrc_applied[0] = -force
    for _ in range(30):
        before = float(data.qpos[0])
        advance(scene, data, 0.1)
        if abs(float(data.qpos[0]) - before) < 2e-4 * abs(before):
            break
    return data


def squeezed(
    scene: Scene, angles: np.ndarray, pushing: np.ndarray, seconds: float = 1.0
) -> mujoco.MjData:
    """A gripper whose motors ``pushing`` (n,) bool have been driven to their limits.

    Args:
        scene: the rig.
        angles: motor positions to start from, kept by the other motors (n,) [rad or m].
        pushing: motors that close until their torque limit stops them (n,) bool.
        seconds: time at the limit after a ramp of 0.5 s [s].
    """
    data = mujoco.MjData(scene.model)
    scene.pose_hand(data, angles)
    for references in squeezing(scene, angles, pushing):
        data.ctrl[scene.motors] = references
        advance(scene, data, TICK)
    advance(scene, data, seconds)
    return data


def squeezing(scene: Scene, angles: np.ndarray, pushing: np.ndarray) -> np.ndarray:
    """References (ticks, n) that drive motors to their limits, one every ``TICK``."""
    limits = scene.model.actuator_forcerange[scene.motors, 1]
    # Enough to saturate with the pad's yielding and the gap before it (0.05 rad or m) included.
    reach = pushing * (1.25 * limits / scene.model.actuator_gainprm[scene.motors, 0] + 0.05)
    return angles + np.linspace(0.0, 1.0, 50)[:, None] * reach


@dataclass(frozen=True)
class Touch:
    """Contacts of the hand with the test body.

    Attributes:
        points: palm frame (n, 3) [m].
        forces: on the test body, palm frame (n, 3) [N].
        normal: normal parts [N] (n,).
        links: names of the links (n,).
        sensed: whether a taxel carries it (n,) bool.
    """

    points: np.ndarray
    forces: np.ndarray
    normal: np.ndarray
    links: np.ndarray
    sensed: np.ndarray


def touches(scene: Scene, data: mujoco.MjData) -> Touch:
    """All contacts between hand and test body, or a real scene's object.

    Read from MuJoCo on its own, not by ``sdh_sim.cell.contacts``, which is under test here.
    """
    model, wrench = scene.model, np.zeros(6)
    palm, turn = data.xpos[scene.palm], data.xmat[scene.palm].reshape(3, 3)
    points, forces, normal, links, sensed = [], [], [], [], []
    for k in range(data.ncon):
        pair = data.contact.geom[k]
        bodies = model.geom_bodyid[pair]
        if scene.object_body not in bodies or data.contact.efc_address[k] < 0:
            continue
        if scene.table in pair:
            continue
        mujoco.mj_contactForce(model, data, k, wrench)
        # The force is that on the second geom.
        sign = 1.0 if bodies[1] == scene.object_body else -1.0
        other = 0 if bodies[1] == scene.object_body else 1
        points.append(turn.T @ (data.contact.pos[k] - palm))
        forces.append(sign * turn.T @ data.contact.frame[k].reshape(3, 3).T @ wrench[:3])
        normal.append(wrench[0])
        links.append(model.body(int(bodies[other])).name.removeprefix(HAND))
        sensed.append(scene.taxel[pair[other]] >= 0)
    return Touch(
        np.reshape(points, (-1, 3)), np.reshape(forces, (-1, 3)), np.array(normal),
        np.array(links, dtype=str), np.array(sensed, dtype=bool),
    )  # fmt: skip


def torques_of(scene: Scene, angles: np.ndarray, touch: Touch) -> np.ndarray:
    """Motor torques that hold contact forces at motor positions (n,), Σ Jᵀ f (n,) [N m or N]."""
    hand = hand_kinematics(scene.hand).at(angles)
    torque = np.zeros(len(scene.motors))
    for point, force, link in zip(touch.points, touch.forces, touch.links, strict=True):
        torque += hand.jacobian(str(link), point).T @ force
    return torque


@dataclass(frozen=True)
class Imprint:
    """One pad's tactile array as the metric sees it.

    Attributes:
        forces: rows × columns [N].
        total: their sum [N].
        point, normal: pressure-weighted centre on the pad and the pad's normal there, link
            frame (3,) [m].
        torsion_arm: Σ ĝ l / Σ ĝ of equation 7 [m], taxels in the tangent plane.
    """

    forces: np.ndarray
    total: float
    point: np.ndarray
    normal: np.ndarray
    torsion_arm: float


def sphere_forces(scene: Scene, data: mujoco.MjData, pad: str) -> np.ndarray:
    """Normal force that each sphere of a pad's rubber bears, rows × columns [N].

    Of the springs of the bed, that is: what a taxel reads acts on it, whichever sphere bears it.
    Read from MuJoCo on its own, as ``touches``.
    """
    hand = scene.hand
    index = hand.pad_names.index(pad)
    array, first = hand.pads[index].array, hand.pad_offsets[index]
    forces, wrench = np.zeros(array.live.size), np.zeros(6)
    for k in range(data.ncon):
        place = int(scene.taxel[data.contact.geom[k]].max()) - first
        if data.contact.efc_address[k] >= 0 and 0 <= place < array.live.size:
            mujoco.mj_contactForce(scene.model, data, k, wrench)
            forces[place] += wrench[0]
    return forces.reshape(array.shape)


def imprint(scene: Scene, data: mujoco.MjData, pad: str) -> Imprint:
    """Tactile array of a pad, centre and torsion arm found as for a prediction."""
    return imprint_of(scene.hand, taxel_forces(scene, data), pad)


def imprint_of(hand: Hand, felt: np.ndarray, pad: str) -> Imprint:
    """Tactile array of a pad from the normal forces on all taxels of a hand (taxels,) [N]."""
    index = hand.pad_names.index(pad)
    array = hand.pads[index].array
    flat = felt[hand.pad_offsets[index] : hand.pad_offsets[index + 1]]
    forces = flat.reshape(array.shape)
    rows, columns = np.nonzero(forces > 0.0)
    if len(rows) == 0:
        nothing = np.full(3, np.nan)
        return Imprint(forces, 0.0, nothing, nothing, np.nan)
    weight = forces[rows, columns]
    point, normal = array.surface(
        float(np.average(rows, weights=weight)), float(np.average(columns, weights=weight))
    )
    centres = array.centres[rows, columns]
    flat_centres = centres - np.outer((centres - point) @ normal, normal)
    arm = gq.max_torsion(1.0, 1.0, weight, flat_centres, point)
    return Imprint(forces, float(weight.sum()), point, normal, arm)
