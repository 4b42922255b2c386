"""A press for tests: the real scene's object laid against one pad, nothing else in the way."""

from __future__ import annotations

import copy
import dataclasses

import mujoco
import numpy as np

from sdh_sim.cell import Scene
from sdh_sim.robot import HAND
from sdh_sim.robot import sdh2_constants as c
from tests.support.sdh2 import MOTOR_NAMES, PAD_OFFSETS

# Arm posture that holds the hand level, well over the table [rad].
ARM_POSTURE = np.array([0.0, -0.3, 0.0, 0.0, 0.3, 0.0])


def alone(scene: Scene, pad: tuple[str, str]) -> Scene:
    """A copy of a scene without gravity, where the object meets the taxels of one pad only."""
    model, index = copy.copy(scene.model), c.PADS.index(pad)
    model.opt.gravity[:] = 0.0
    kept = (scene.taxel >= PAD_OFFSETS[index]) & (scene.taxel < PAD_OFFSETS[index + 1])
    kept |= model.geom_bodyid == scene.object_body
    model.geom_contype[~kept] = model.geom_conaffinity[~kept] = 0
    return dataclasses.replace(scene, model=model)


def bolted(scene: Scene) -> Scene:
    """The scene with object and arm too heavy to be moved; contacts stay as soft as they were."""
    scene.model.dof_armature[scene.arm_dof] = 1e9
    # The solver's tolerance is relative to the mean mass, which is absurd now.
    scene.model.opt.tolerance = 1e-15
    scene.model.body_mass[scene.object_body] = scene.model.body_inertia[scene.object_body] = 1e6
    return scene


def placed(
    scene: Scene, thumb: tuple[float, float], position: np.ndarray, rotation: np.ndarray
) -> mujoco.MjData:
    """State with the thumb at (proximal, distal) [rad], the object at a pose in the palm frame.

    Args:
        scene: what ``alone`` returned.
        thumb: angles of the thumb's joints; the other fingers stand straight.
        position: of the object's frame (3,) [m].
        rotation: of the object's frame (3, 3).
    """
    model, data = scene.model, mujoco.MjData(scene.model)
    angles = np.zeros(7)
    angles[MOTOR_NAMES.index("thumb_proximal")] = thumb[0]
    angles[MOTOR_NAMES.index("thumb_distal")] = thumb[1]
    data.qpos[scene.motor_qpos] = data.ctrl[scene.motors] = angles
    data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = ARM_POSTURE
    mujoco.mj_kinematics(model, data)
    palm = data.xmat[scene.palm].reshape(3, 3)
    free = data.qpos[scene.object_qpos : scene.object_qpos + 7]
    free[:3] = data.xpos[scene.palm] + palm @ position
    mujoco.mju_mat2Quat(free[3:], (palm @ rotation).ravel())
    mujoco.mj_forward(model, data)
    return data


def push(
    scene: Scene, data: mujoco.MjData, body: str, point: np.ndarray, force: float, duration: float
) -> None:
    """Push the object against a pad: a force [N] along the link's -x through a point of the link.

    Args:
        scene, data: what ``alone`` and ``placed`` returned; the data move on.
        body: link of the pad.
        point: in the link's frame (3,) [m].
        force: its size [N].
        duration: [s].
    """
    model, link = scene.model, scene.model.body(HAND + body).id
    for _ in range(round(duration / model.opt.timestep)):
        turn = data.xmat[link].reshape(3, 3)
        data.qfrc_applied[:] = 0.0
        mujoco.mj_applyFT(
            model, data, -force * turn[:, 0], np.zeros(3), data.xpos[link] + turn @ point,
            scene.object_body, data.qfrc_applied,
        )  # fmt: skip
        mujoco.mj_step(model, data)


def contacts(scene: Scene, data: mujoco.MjData) -> tuple[np.ndarray, ...]:
    """Every contact between a taxel and something, as MuJoCo itself reports it.

    Returns:
        taxel index (n,), indentation (n,) [m], force on the object in the world (n, 3) [N],
        position of the contact in the world (n, 3) [m].
    """
    taxels, depths, forces, positions = [], [], [], []
    for k in range(data.ncon):
        geoms = data.contact.geom[k]
        taxel = scene.taxel[geoms]
        if (taxel < 0).all():
            continue
        local = np.zeros(6)
        mujoco.mj_contactForce(scene.model, data, k, local)
        # The frame's first axis points from the first geom to the second.
        sign = 1.0 if taxel[0] >= 0 else -1.0
        taxels.append(taxel.max())
        depths.append(-data.contact.dist[k])
        forces.append(sign * data.contact.frame[k].reshape(3, 3).T @ local[:3])
        positions.append(data.contact.pos[k].copy())
    return np.array(taxels), np.array(depths), np.array(forces), np.array(positions)


def against_thumb_distal(scene: Scene) -> mujoco.MjData:
    """The box before the flat part of the thumb's distal pad, which stands upright.

    Proximal 20 degrees forward, distal 20 back: the distal axis is at
    (-38.11 + 86.5 sin 20, 91 + 86.5 cos 20) = (-8.525, 172.283) mm, the pad 14.8 mm ahead of it
    and the middle of its flat rows 9 to 12 at 27.55 mm.
    """
    pad = np.array([-8.525 + 14.8, 0.0, 172.283 + 27.55]) * 1e-3
    lean = np.radians(20.0)
    return placed(scene, (lean, -lean), pad + np.array([35.95e-3, -11.6e-3, 8.3e-3]), np.eye(3))


def against_thumb_proximal(scene: Scene) -> mujoco.MjData:
    """The box or the cylindrical bottle laid against the straight thumb's proximal pad."""
    # The pad's surface is at x = -38.11 + 15.4 mm and its middle at z = 91 + 43.7 mm.
    pad = np.array([-38.11 + 15.4, 0.0, 91.0 + 43.7]) * 1e-3
    if scene.settings.object == "box":  # its -x face is at -35.95 mm
        offset, rotation = (35.95e-3, -11.6e-3, 8.3e-3), np.eye(3)
    else:  # a cylinder of radius 34.45 mm about its y, laid along the finger
        offset, rotation = (34.45e-3, 0.0, 20e-3), np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    return placed(scene, (0.0, 0.0), pad + offset, rotation)
