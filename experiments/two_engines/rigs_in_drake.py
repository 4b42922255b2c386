"""Rigs of the validation at rest in Drake, read as those in MuJoCo are."""

# pyright: reportMissingImports=false
from __future__ import annotations

import mujoco
import numpy as np

from experiments.two_engines.alignment import Alignment
from experiments.two_engines.closing import taxel_forces_in_drake
from experiments.two_engines.engine import DrakeSimulation, pose_of
from experiments.two_engines.translate import translate
from experiments.validation.rig_engine import GROWTH, WATCHED, Shift
from experiments.validation.rig_readings import Imprint, Touch, imprint_of, squeezing
from experiments.validation.rigs import set_friction
from sdh_sim import poses
from sdh_sim.cell import Scene
from sdh_sim.robot import HAND

ORIGIN = np.zeros(3)


class DrakeRig:
    """A rig at rest in Drake.

    Args:
        simulation: of it.
        force: that acts on the test body's frame, in the world (3,) [N].
    """

    def __init__(self, simulation: DrakeSimulation, force: np.ndarray) -> None:
        self.simulation, self._force = simulation, force
        self._state = simulation.save()

    @property
    def scene(self) -> Scene:
        """The rig's."""
        return self.simulation.made.scene

    @property
    def angles(self) -> np.ndarray:
        """Positions of the motors (n,) [rad or m]."""
        return self.simulation.motor_positions()

    @property
    def torques(self) -> np.ndarray:
        """Of the motors (n,) [N m or N]."""
        return self.simulation.motor_torques()

    @property
    def pressed_in(self) -> float:
        """How far the test body of a bench has moved into the pad [m]."""
        joints = self.simulation.made.object_joints
        if not joints:
            raise ValueError("a test body that is free or fixed is pressed into no pad")
        positions = self.simulation.made.plant.GetPositions(self.simulation.context)
        return -float(positions[next(iter(joints.values())).position_start()])

    def touches(self) -> Touch:
        """Contacts of the hand with the test body."""
        made, found = self.simulation.made, self.simulation.object_contacts()
        scene = made.scene
        palm = made.plant.EvalBodyPoseInWorld(self.simulation.context, made.palm)
        into_palm = palm.inverse()
        points = [into_palm.multiply(contact.point) for contact in found]
        forces = [into_palm.rotation().multiply(contact.force) for contact in found]
        geoms = np.array([contact.geom for contact in found], dtype=int)
        links = [scene.model.body(int(b)).name for b in scene.model.geom_bodyid[geoms]]
        return Touch(
            np.reshape(points, (-1, 3)), np.reshape(forces, (-1, 3)),
            np.array([contact.normal for contact in found]),
            np.array([name.removeprefix(HAND) for name in links], dtype=str),
            scene.taxel[geoms] >= 0,
        )  # fmt: skip

    def imprint(self, pad: str) -> Imprint:
        """Tactile array of a pad."""
        return imprint_of(self.scene.hand, taxel_forces_in_drake(self.simulation), pad)

    def sphere_forces(self, pad: str) -> np.ndarray:
        """Normal force on each sphere of a pad's rubber, rows × columns [N]."""
        hand = self.scene.hand
        index = hand.pad_names.index(pad)
        array, first = hand.pads[index].array, hand.pad_offsets[index]
        forces = np.zeros(array.live.size)
        for contact in self.simulation.object_contacts():
            place = int(self.scene.taxel[contact.geom]) - first
            if 0 <= place < array.live.size:
                forces[place] += contact.normal
        return forces.reshape(array.shape)

    def with_friction(self, friction: float) -> DrakeRig:
        """The same state with another coefficient of friction, which the scene keeps."""
        set_friction(self.scene, friction)
        before = self.simulation
        after = _set_off(self.scene, before.made.alignment, references=before.references)
        after.restore(self._state)
        after.set_force(self._force, ORIGIN)
        return DrakeRig(after, self._force)

    def loaded(self, force: np.ndarray, torque: np.ndarray, wait: float = 0.0) -> Shift:
        """As ``RigAtRest.loaded``."""
        simulation, made = self.simulation, self.simulation.made
        simulation.restore(self._state)
        ticks = round(GROWTH / simulation.tick_time)
        for k in range(1, ticks + 1):
            simulation.set_force(self._force + k / ticks * force, ORIGIN, k / ticks * torque)
            simulation.tick()
        for _ in range(round(wait / simulation.tick_time)):
            simulation.tick()
        normal = float(self.touches().normal.sum())
        before = pose_of(made.plant.EvalBodyPoseInWorld(simulation.context, made.obj))
        for _ in range(round(WATCHED / simulation.tick_time)):
            simulation.tick()
        after = pose_of(made.plant.EvalBodyPoseInWorld(simulation.context, made.obj))
        simulation.restore(self._state)
        simulation.set_force(self._force, ORIGIN)
        return Shift(after[:3] - before[:3], poses.turn_between(before, after), normal)


class Drake:
    """Brings rigs to rest in Drake.

    Args:
        alignment: of the translation.
    """

    def __init__(self, alignment: Alignment) -> None:
        self.alignment = alignment

    def pressed(self, scene: Scene, force: float) -> DrakeRig:
        """As ``rig_readings.pressed``."""
        simulation = _set_off(scene, self.alignment)
        made = simulation.made
        turn = made.plant.EvalBodyPoseInWorld(simulation.context, made.obj).rotation().matrix()
        push = -force * turn[:, 0]
        simulation.set_force(push, ORIGIN)
        rig = DrakeRig(simulation, push)
        for _ in range(30):
            before = rig.pressed_in
            for _ in range(10):
                simulation.tick()
            if abs(rig.pressed_in - before) < 2e-4 * abs(before):
                break
        return DrakeRig(simulation, push)

    def squeezed(
        self, scene: Scene, angles: np.ndarray, pushing: np.ndarray, seconds: float = 1.0
    ) -> DrakeRig:
        """As ``rig_readings.squeezed``."""
        simulation = _set_off(scene, self.alignment, angles)
        for references in squeezing(scene, angles, pushing):
            simulation.tick(references=references)
        for _ in range(round(seconds / simulation.tick_time)):
            simulation.tick()
        return DrakeRig(simulation, ORIGIN)


def _set_off(
    scene: Scene, alignment: Alignment, angles: np.ndarray | None = None,
    references: np.ndarray | None = None,
) -> DrakeSimulation:  # fmt: skip
    """A rig as MuJoCo has it at the start, without forces on the test body.

    Args:
        scene: the rig.
        alignment: of the translation.
        angles: motor positions (n,) [rad or m]; None: the model's own.
        references: of the servos (n,) [rad or m]; None: the positions.
    """
    data = mujoco.MjData(scene.model)
    if angles is not None:
        scene.pose_hand(data, angles)
    mujoco.mj_forward(scene.model, data)
    palm, body = (poses.body_pose(data, b) for b in (scene.palm, scene.object_body))
    simulation = DrakeSimulation(translate(scene, palm, body, alignment))
    if references is None:
        references = np.zeros(len(scene.motors)) if angles is None else angles
    simulation.set_to(data.qpos, body, references)
    simulation.set_force(ORIGIN, ORIGIN)
    return simulation
