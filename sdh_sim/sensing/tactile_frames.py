"""From a simulation to readings: frames of the tactile arrays, and the snapshot of the hand."""

from __future__ import annotations

import mujoco
import numpy as np

from sdh_sim.cell import Scene, Simulation
from sdh_sim.cell.contacts import forces_beside_taxels, taxel_forces
from sdh_sim.robot import hand_kinematics
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.sensing.tactile_sensor import FRAME_RATE, TactileSensor


class TactileFrames:
    """An observer of a simulation that feeds a sensor at its frame rate.

    Args:
        sensor: the tactile arrays.
        start: simulated time of the first frame [s].
    """

    def __init__(self, sensor: TactileSensor, start: float = 0.0) -> None:
        self.sensor = sensor
        self._next = start

    def after_tick(self, scene: Scene, data: mujoco.MjData, phase: str) -> None:
        """Hand the forces on the taxels to the sensor when a frame is due."""
        if data.time >= self._next:
            self._next += 1.0 / FRAME_RATE
            self.sensor.frame(taxel_forces(scene, data), forces_beside_taxels(scene, data))


def take_snapshot(simulation: Simulation, sensor: TactileSensor | None = None) -> TactileSnapshot:
    """What the hand senses now.

    Args:
        simulation: as it is at the moment.
        sensor: the tactile arrays, fed so far; None reads the pressure itself.
    """
    scene, data = simulation.scene, simulation.data
    if sensor is None:
        sensor = TactileSensor(None, np.random.default_rng(0), scene.hand)
        sensor.frame(taxel_forces(scene, data))
    # What the gears lose beyond the limits never reaches a joint as torque of its motor.
    torques = np.clip(data.actuator_force[scene.motors], -simulation.limits, simulation.limits)
    return TactileSnapshot(
        tactile=scene.hand.by_kind(sensor.read()),
        joint_angles=scene.motor_positions(data),
        motor_torques=torques,
        object_pose_hand=simulation.object_in_hand(),
        hand_pose_world=simulation.pose(scene.palm),
        gravity=scene.settings.gravity if scene.settings.support == "none" else "",
        joints=data.qpos[scene.hand_qpos].copy() if hand_kinematics(scene.hand).passive else None,
    )
