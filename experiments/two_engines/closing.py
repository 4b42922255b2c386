"""The trials' grasp in Drake: from the open hand around the object to the hand at rest."""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.two_engines.engine import DrakeSimulation, pose_of
from experiments.two_engines.translate import translate
from sdh_sim import poses
from sdh_sim.cell import Scene
from sdh_sim.grasping import MotionPlan, place
from sdh_sim.grasping.acquire import (
    CLOSE_TIME,
    QUIET_TIME,
    REST_SPEED,
    REST_SPIN,
    REST_TIME,
    SQUEEZE_TIME,
)
from sdh_sim.grasping.finger_control import FingerControl
from sdh_sim.sensing import TactileSensor, TactileSnapshot


def close_in_drake(scene: Scene, motion: MotionPlan) -> DrakeSimulation:
    """Close, squeeze and rest, as ``sdh_sim.grasping.acquire`` does after the approach.

    Args:
        scene: of MuJoCo.
        motion: the grasp; the hand starts where the approach ends.

    Raises:
        Diverged: Drake did.
    """
    data = mujoco.MjData(scene.model)
    place(scene, data, motion.grasp, motion.approach[-1], motion.opening)
    mujoco.mj_forward(scene.model, data)
    palm, obj = (poses.body_pose(data, body) for body in (scene.palm, scene.object_body))
    simulation = DrakeSimulation(translate(scene, palm, obj))
    simulation.set_to(data.qpos, obj, data.ctrl[scene.motors])
    fingers = FingerControl(
        scene.hand,
        motion.grasp.closing,
        motion.opening,
        scene.hand.torque_limits(scene.torque_limit),
        scene.model.actuator_gainprm[scene.motors, 0],
        scene.motor_damping(),
    )
    for _ in range(10):  # as the trials wait after the approach
        simulation.tick()
    tick = simulation.tick_time
    for _ in range(round(max(CLOSE_TIME, 1.1 / fingers.closing.rate) / tick)):
        simulation.tick(references=fingers.close(simulation.motor_torques(), tick))
        if fingers.closed:
            break
    at_rest = 0.0
    for _ in range(round(SQUEEZE_TIME / tick)):
        simulation.tick(references=fingers.squeeze(simulation.motor_positions(), tick))
        speed, spin = simulation.object_speed()
        at_rest = at_rest + tick if speed < REST_SPEED and spin < REST_SPIN else 0.0
        if at_rest > QUIET_TIME and fingers.settled:
            break
    for _ in range(round(REST_TIME / tick)):
        simulation.tick()
    return simulation


def taxel_forces_in_drake(simulation: DrakeSimulation) -> np.ndarray:
    """Normal force that every taxel feels, as ``cell.contacts.taxel_forces`` (taxels,) [N]."""
    made, scene = simulation.made, simulation.made.scene
    forces = np.zeros(scene.hand.tactile_size)
    arrays, offsets = list(scene.hand.arrays.values()), scene.hand.pad_offsets
    for contact in simulation.object_contacts():
        taxel = scene.taxel[contact.geom]
        if taxel < 0:
            continue
        place = made.plant.EvalBodyPoseInWorld(simulation.context, contact.link)
        local = place.inverse().multiply(contact.point)
        pad = int(np.searchsorted(offsets, taxel, side="right")) - 1
        taxels, shares = arrays[scene.hand.pad_kinds[pad]].shares(local[None])
        np.add.at(forces, taxels[0] + offsets[pad], contact.normal * shares[0])
    return forces


def snapshot_in_drake(simulation: DrakeSimulation) -> TactileSnapshot:
    """What a hand of ideal arrays would sense now, as ``sensing.take_snapshot``."""
    made = simulation.made
    sensor = TactileSensor(None, np.random.default_rng(0), made.scene.hand)
    sensor.frame(taxel_forces_in_drake(simulation))
    palm = made.plant.EvalBodyPoseInWorld(simulation.context, made.palm)
    return TactileSnapshot(
        tactile=made.scene.hand.by_kind(sensor.read()),
        joint_angles=simulation.motor_positions(),
        motor_torques=simulation.motor_torques(),
        object_pose_hand=simulation.object_in_hand(),
        hand_pose_world=pose_of(palm),
    )
