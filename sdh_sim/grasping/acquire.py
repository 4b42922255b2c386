"""From the object on the table to the object in the hand: approach, close, squeeze, rest."""

from __future__ import annotations

import numpy as np

from sdh_sim.cell import Simulation
from sdh_sim.grasping.finger_control import FingerControl
from sdh_sim.grasping.motion_plan import MotionPlan, place
from sdh_sim.robot import along

APPROACH_TIME, CLOSE_TIME, SQUEEZE_TIME = 0.8, 2.2, 2.0  # the last two at most [s]
QUIET_TIME = 0.1  # that long at rest ends the squeeze [s]
REST_TIME = 0.5  # [s]
REST_SPEED, REST_SPIN = 1e-3, 1e-2  # object at rest below these [m/s], [rad/s]


def acquire(simulation: Simulation, motion: MotionPlan) -> None:
    """Grasp the object; the simulation ends at rest, ready for the snapshot.

    Without a table a fixture holds the object while the fingers close and squeeze. It lets go
    before the rest, so that nothing but the hand bears on the object at the snapshot.

    Args:
        simulation: of the scene, in any state: it is set to the start of the approach.
        motion: with the grasp.

    Raises:
        Diverged: the simulation did.
    """
    scene, data = simulation.scene, simulation.data
    place(scene, data, motion.grasp, motion.approach[0], motion.opening)
    simulation.free_drives()
    simulation.fix_object()
    duration = scene.palm_motion.duration(motion.approach, APPROACH_TIME)
    simulation.phase = "approach"
    simulation.follow(lambda share: along(motion.approach, share), duration)
    simulation.wait(0.1)
    fingers = FingerControl(
        scene.hand,
        motion.grasp.closing,
        motion.opening,
        simulation.limits,
        scene.model.actuator_gainprm[scene.motors, 0],
        scene.motor_damping(),
        scene.drives.friction,
    )
    _close(simulation, fingers)
    _squeeze(simulation, fingers)
    simulation.release_object()
    simulation.phase = "rest"
    simulation.wait(REST_TIME)


def _close(simulation: Simulation, fingers: FingerControl) -> None:
    """Close until every finger is stopped by the object, closed fully, or time is up."""
    simulation.phase = "close"
    torque, motors = simulation.data.actuator_force, simulation.scene.motors
    time = max(CLOSE_TIME, 1.1 / fingers.closing.rate)
    for _ in range(round(time / simulation.tick_time)):
        simulation.tick(hand=fingers.close(torque[motors], simulation.tick_time))
        if fingers.closed:
            return


def _squeeze(simulation: Simulation, fingers: FingerControl) -> None:
    """Build up the grip, until it is complete and the object at rest, or time is up."""
    simulation.phase = "squeeze"
    scene, data = simulation.scene, simulation.data
    at_rest = 0.0  # for so long [s]
    for _ in range(round(SQUEEZE_TIME / simulation.tick_time)):
        angles = scene.motor_positions(data)
        simulation.tick(hand=fingers.squeeze(angles, simulation.tick_time))
        speed = data.qvel[scene.object_dof : scene.object_dof + 6]
        still = np.linalg.norm(speed[:3]) < REST_SPEED and np.linalg.norm(speed[3:]) < REST_SPIN
        at_rest = at_rest + simulation.tick_time if still else 0.0
        if at_rest > QUIET_TIME and fingers.settled:
            return
