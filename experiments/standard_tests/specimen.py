"""What is tested: a hand with its torque limits and drives, and the scenes that it is tested in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sdh_sim.cell import Scene, Simulation, build_scene
from sdh_sim.objects import user_object
from sdh_sim.robot import Hand
from sdh_sim.robot.find_hand import find_hand, hand_in
from sdh_sim.settings import DATASHEET_TORQUE_LIMIT, PAPER_TORQUE_LIMIT, TrialSettings

PALM_AT = np.array([0.3, 0.0, 0.6])  # in the world, its z up [m]


@dataclass(frozen=True)
class Specimen:
    """A hand under test.

    Attributes:
        name: in tables.
        settings: hand, limits and drives; their object does not matter.
    """

    name: str
    settings: TrialSettings

    @property
    def hand(self) -> Hand:
        """The hand."""
        return hand_in(self.settings)

    @property
    def limits(self) -> np.ndarray:
        """Limits of its motors (n,) [N m or N]."""
        hand = self.hand
        return hand.torque_limits(self.settings.torque_limit or hand.rated_limits)

    def settings_with(self, folder: Path, drive: str | None = None) -> TrialSettings:
        """Settings for a test object of a folder: the hand floats, nothing has weight.

        Args:
            folder: of the object.
            drive: instead of the specimen's own.
        """
        found, own = user_object(folder), self.settings
        return TrialSettings(
            found.name, folder=found.reference, hand=own.hand, hand_folder=own.hand_folder,
            torque_limit=own.torque_limit, drive=drive or own.drive,
            gear_friction=own.gear_friction, timestep=own.timestep, arm="none", support="none",
        )  # fmt: skip

    def rig(self, folder: Path, drive: str | None = None) -> Rig:
        """A scene with a test object, at its beginning; arguments as ``settings_with``."""
        return Rig(build_scene(self.settings_with(folder, drive)))


def specimens(hand: str | None, drive: str) -> list[Specimen]:
    """The hands to test: those of the models, or a user's own at its rated limits.

    Raises:
        HandError: no such hand, or a folder that cannot be used.
    """
    if hand is not None:
        name, folder = find_hand(hand)
        return [Specimen(name, TrialSettings("box", hand=name, hand_folder=folder, drive=drive))]
    limits = {"data sheet": DATASHEET_TORQUE_LIMIT, "paper": PAPER_TORQUE_LIMIT}
    found = [
        Specimen(f"SDH-2, {name}", TrialSettings("box", torque_limit=limit, drive=drive))
        for name, limit in limits.items()
    ]
    jaw = TrialSettings("box", hand="parallel_jaw", drive=drive)
    return [*found, Specimen("parallel jaw, 100 N", jaw)]


class Rig:
    """A hand on its stiff base and a test object that a fixture holds, without weight.

    Attributes:
        scene, simulation: as of a trial.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.simulation = scene, Simulation(scene)

    def put(self, angles: np.ndarray, point: np.ndarray, axes: np.ndarray) -> None:
        """Start anew: motors at positions (n,), the object where it is wanted.

        Args:
            angles: positions of the motors [rad or m].
            point: of the object's frame, in the palm frame (3,) [m].
            axes: its axes as columns in the palm frame (3, 3).
        """
        import mujoco

        scene, data = self.scene, self.simulation.data
        mujoco.mj_resetData(scene.model, data)
        base = scene.palm_motion.reach(PALM_AT, np.eye(3))
        assert base is not None  # the base reaches everything
        data.qpos[scene.arm_qpos] = data.ctrl[scene.arm_motors] = base
        scene.pose_hand(data, angles)
        data.ctrl[scene.motors] = angles
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, np.ascontiguousarray(axes).ravel())
        at = scene.object_qpos
        data.qpos[at : at + 3], data.qpos[at + 3 : at + 7] = PALM_AT + point, quat
        self.simulation.free_drives()
        self.simulation.fix_object()
        mujoco.mj_forward(scene.model, data)
