"""The arm: its model, and inverse kinematics by mink."""

from __future__ import annotations

import math

import mink
import mujoco
import numpy as np

from sdh_sim.model_files import models_dir
from sdh_sim.poses import product, rotate
from sdh_sim.robot.hand import hand_kinematics
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.palm_motion import PalmMotion

ARM = "arm/"  # prefix of its names in a workcell
ARM_JOINTS = tuple(f"joint{k}" for k in range(1, 7))

SOLVER = "daqp"  # an active-set solver for small dense problems, which these 6 × 6 ones are
POSITION_TOLERANCE = 2e-4  # [m]
ROTATION_TOLERANCE = 2e-3  # [rad]
STANDOFF = 0.10  # length of the straight approach [m]


class ArmKinematics(PalmMotion):
    """Finds joint angles of the arm for poses of the palm.

    Args:
        hand: on the arm; None: the SDH-2.

    Attributes:
        model: the arm with a site ``palm`` where the hand's palm frame will be.
        lower, upper: joint limits (6,) [rad].
    """

    standoff = STANDOFF

    def __init__(self, hand: Hand | None = None) -> None:
        spec = arm_spec()
        # The spec's site may be oriented by zaxis or euler; the compiled one has a quaternion.
        flange = spec.compile().site(f"{ARM}flange")
        palm, turn = hand_kinematics(hand).palm_offset()
        offset = rotate(flange.quat, palm)
        parent = spec.site(f"{ARM}flange").parent
        parent.add_site(name="palm", pos=flange.pos + offset, quat=product(flange.quat, turn))
        self.model = spec.compile()
        self.speed_limit = arm_speed_limit(self.model)
        joints = [self.model.joint(ARM + name) for name in ARM_JOINTS]
        self.lower, self.upper = np.array([j.range for j in joints]).T
        self._configuration = mink.Configuration(self.model)
        self._task = mink.FrameTask(
            "palm", "site", position_cost=1.0, orientation_cost=0.3, lm_damping=1e-3
        )
        self._limits = [mink.ConfigurationLimit(self.model)]

    def palm_pose(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As ``PalmMotion`` says."""
        self._configuration.update(np.asarray(q, dtype=float))
        pose = self._configuration.get_transform_frame_to_world("palm", "site")
        return pose.translation(), pose.rotation().as_matrix()

    def solve(
        self, position: np.ndarray, rotation: np.ndarray, start: np.ndarray, steps: int = 60
    ) -> np.ndarray | None:
        """As ``PalmMotion`` says; ``steps`` are those of differential inverse kinematics."""
        target = mink.SE3.from_rotation_and_translation(
            mink.SO3.from_matrix(rotation), np.asarray(position, dtype=float)
        )
        self._task.set_target(target)
        conf = self._configuration
        conf.update(np.clip(start, self.lower, self.upper))
        best = math.inf
        for step in range(steps):
            error = self._task.compute_error(conf)
            size = max(
                float(np.linalg.norm(error[:3])) / POSITION_TOLERANCE,
                float(np.linalg.norm(error[3:])) / ROTATION_TOLERANCE,
            )
            if size < 1.0:
                return conf.q.copy()
            if step % 20 == 19:
                if size > 0.7 * best:
                    return None  # stuck at a joint limit or out of reach
                best = size
            try:
                velocity = mink.solve_ik(
                    conf, [self._task], 1.0, SOLVER, damping=1e-8, limits=self._limits
                )
            except mink.MinkError:
                return None
            # A full step may leap over a singularity; half a radian cannot.
            scale = min(1.0, 0.5 / max(1e-9, float(np.abs(velocity).max())))
            conf.integrate_inplace(velocity * scale, 1.0)
        return None

    def reach(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray | None:
        """As ``PalmMotion`` says; from any of a few postures."""
        turn = -math.atan2(position[1], position[0])  # joint 1 turns about -z
        forward = rotation[2, 2] > -0.7  # else the hand points down
        shoulder, elbow, bend = (0.9, 0.6, 1.5) if forward else (0.5, 0.5, 0.6)
        for wrist4, wrist6 in ((0, 0), (0, 1.57), (0, -1.57), (0, 3.1), (1.4, 0), (-1.4, 0)):
            start = np.array([turn, shoulder, elbow, wrist4, bend, wrist6])
            found = self.solve(position, rotation, start)
            if found is not None:
                return found
        return None


def cell_spec() -> mujoco.MjSpec:
    """The table and what lights it."""
    return mujoco.MjSpec.from_file(str(models_dir() / "cell" / "cell.xml"))


def arm_spec() -> mujoco.MjSpec:
    """Table and arm."""
    spec = cell_spec()
    arm = mujoco.MjSpec.from_file(str(models_dir() / "kuka_kr5_sixx_r850" / "kr5_sixx_r850.xml"))
    spec.attach(arm, prefix=ARM, site=spec.site("arm_mount"))
    return spec


def arm_speed_limit(model: mujoco.MjModel) -> np.ndarray:
    """Greatest joint speeds of the arm (6,) [rad/s], from the arm's MJCF."""
    numeric = next(
        model.numeric(k) for k in range(model.nnumeric)
        if model.numeric(k).name.endswith("joint_speed_limit")
    )  # fmt: skip
    return np.array(numeric.data)
