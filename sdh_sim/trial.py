"""One trial: place, approach, close, squeeze, snapshot, lift, hold, verdict."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from sdh_sim import outcome
from sdh_sim.arm import ArmKinematics, along
from sdh_sim.control import FingerControl
from sdh_sim.grasps import OBJECT_POSITION, STANDOFF, GraspPlan, sample_grasp
from sdh_sim.hand import HandKinematics, preshape_angles, torque_limits
from sdh_sim.log import LogWriter, TrialLog
from sdh_sim.objects import ObjectInfo, object_info
from sdh_sim.prediction import Prediction, predict
from sdh_sim.scene import (
    ARM_GEOM,
    HAND_GEOM,
    OBJECT_GEOM,
    TABLE_GEOM,
    Scene,
    build_scene,
)  # fmt: skip
from sdh_sim.settings import TrialSettings
from sdh_sim.tactile import TactileSnapshot, arrays, readings, taxel_forces

TICK = 0.01  # control period [s]
APPROACH_TIME, CLOSE_TIME, SQUEEZE_TIME = 0.8, 2.2, 2.0  # the last two at most [s]
REST_TIME, LIFT_TIME, HOLD_TIME = 0.5, 1.5, 2.0  # [s]
LIFT_HEIGHT = 0.15  # [m]
REST_SPEED, REST_SPIN = 1e-3, 1e-2  # object at rest below these [m/s], [rad/s]
GONE_MM = 80.0  # an object this far from its place in the hand has left it; no need to go on
OPENINGS = (0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)  # closing ratios tried for the approach
MAX_DRAWS = 500


@dataclass(frozen=True)
class TrialResult:
    """What a trial leaves: its row of the table, and the log if one was asked for."""

    row: dict[str, Any]
    log: TrialLog | None
    sim_seconds: float
    wall_seconds: float


@dataclass(frozen=True)
class Course:
    """A feasible plan: joint paths of the arm and the opening of the hand."""

    plan: GraspPlan
    approach: np.ndarray
    lift: np.ndarray
    opening: float
    unreachable: int
    colliding: int


class Diverged(Exception):
    """The simulation left the finite numbers."""


@lru_cache(maxsize=8)
def _scene(settings: TrialSettings) -> Scene:
    return build_scene(settings)


@lru_cache(maxsize=1)
def _kinematics() -> tuple[ArmKinematics, HandKinematics]:
    return ArmKinematics(), HandKinematics()


def run_trial(settings: TrialSettings, seed: int, log: bool = False) -> TrialResult:
    """Run one trial; settings and seed decide it completely, a log changes nothing.

    Args:
        settings: object, torque limits and so on.
        seed: of everything random in the trial.
        log: keep poses, tactile arrays and torques at 30 Hz.

    Raises:
        SettingsError: no such object.
    """
    begin = time.perf_counter()
    scene, thing = _scene(settings), object_info(settings.object)
    course = find_course(scene, thing, np.random.default_rng(seed))
    run = _Run(scene, thing, course, LogWriter(scene) if log else None)
    row = run.execute()
    row |= {"object": settings.object, "seed": seed, **_plan_columns(course)}
    record = run.writer.finish(row, run.prediction) if run.writer is not None else None
    return TrialResult(row, record, run.time, time.perf_counter() - begin)


def find_course(scene: Scene, thing: ObjectInfo, rng: np.random.Generator) -> Course:
    """Draw grasps until one is within reach and free of collisions."""
    arm, _ = _kinematics()
    data = mujoco.MjData(scene.model)
    unreachable = colliding = 0
    for _ in range(MAX_DRAWS):
        plan = sample_grasp(thing, rng)
        rotation, position = plan.palm_rotation(), plan.palm_position()
        final = arm.reach(position, rotation)
        back = None if final is None else arm.straight(final, -STANDOFF * rotation[:, 2])
        if final is None or back is None:
            unreachable += 1
            continue
        opening = free_opening(scene, data, thing, plan, back)
        if opening is None:
            colliding += 1
            continue
        lift = arm.straight(final, np.array([0.0, 0.0, LIFT_HEIGHT]))
        if lift is None:
            unreachable += 1
            continue
        return Course(plan, back[::-1], lift, opening, unreachable, colliding)
    raise RuntimeError(f"no feasible grasp of {thing.name} in {MAX_DRAWS} draws")


def free_opening(
    scene: Scene, data: mujoco.MjData, thing: ObjectInfo, plan: GraspPlan, path: np.ndarray
) -> float | None:
    """The tightest opening of the preshape with which the approach touches nothing, or None."""
    for opening in OPENINGS:
        # The check closes the hand a little further than the approach will: a margin.
        if all(
            not _collides(scene, data, thing, plan, arm, opening + margin)
            for arm in (path[0], path[len(path) // 3], path[-1])
            for margin in (0.08, 0.0)
        ):
            return opening
    return None


def _place(
    scene: Scene, data: mujoco.MjData, thing: ObjectInfo, plan: GraspPlan, arm: np.ndarray,
    opening: float,
) -> None:  # fmt: skip
    """Object on the table, arm and hand at given joint angles."""
    mujoco.mj_resetData(scene.model, data)
    angles = preshape_angles(plan.preshape, opening)
    data.qpos[scene.arm_qpos] = arm
    data.qpos[scene.motor_qpos] = angles
    data.qpos[scene.coupled_qpos] = angles[0]
    yaw = np.array([math.cos(plan.object_yaw / 2), 0.0, 0.0, math.sin(plan.object_yaw / 2)])
    free = data.qpos[scene.object_qpos : scene.object_qpos + 7]
    mujoco.mju_mulQuat(free[3:], yaw, thing.standing_quat)
    free[:3] = (*OBJECT_POSITION, thing.standing_height)
    data.ctrl[scene.arm_motors] = arm
    data.ctrl[scene.motors] = angles


def _collides(
    scene: Scene, data: mujoco.MjData, thing: ObjectInfo, plan: GraspPlan, arm: np.ndarray,
    opening: float,
) -> bool:  # fmt: skip
    _place(scene, data, thing, plan, arm, opening)
    mujoco.mj_kinematics(scene.model, data)
    mujoco.mj_collision(scene.model, data)
    groups = scene.geom_group[data.contact.geom]
    return bool(np.isin(groups, (HAND_GEOM, ARM_GEOM)).any())


class _Run:
    """The simulation of one course; state: MuJoCo's data, the peak torques, the clock."""

    def __init__(
        self, scene: Scene, thing: ObjectInfo, course: Course, writer: LogWriter | None
    ) -> None:
        self.scene, self.thing, self.course, self.writer = scene, thing, course, writer
        self.data = mujoco.MjData(scene.model)
        self.steps = max(1, round(TICK / scene.settings.timestep))
        self.tick_time = self.steps * scene.settings.timestep
        self.peak = np.zeros(7)
        self.limits = torque_limits(scene.settings.torque_limit)
        self.prediction: Prediction | None = None
        self.phase = ""

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.data.time)

    def execute(self) -> dict[str, Any]:
        """Run to the verdict; the row lacks only what the plan knows."""
        settings, thing = self.scene.settings, self.thing
        row: dict[str, Any] = {
            "mass_kg": thing.mass_kg,
            "friction": thing.friction,
            "torque_limit_nm": self.limits,
        }
        failure, moved, turned = "unstable_simulation", math.nan, math.nan
        try:
            self._acquire()
            snapshot, touched = self._snapshot(row)
            _, hand = _kinematics()
            self.prediction = predict(snapshot, thing, settings.torque_limit, settings.pads, hand)
            row |= {
                "q_linf": self.prediction.q_linf,
                "q_l1": self.prediction.q_l1,
                "q_reason": self.prediction.reason,
                "contacts": len(self.prediction.contacts),
            }
            if touched:
                moved, turned, on_table = self._lift(snapshot.object_pose_hand)
                failure = outcome.classify(touched, on_table, moved, turned)
            else:
                failure = "no_contact"
        except Diverged:
            moved = turned = math.nan
        row |= {
            "success": failure == "none",
            "failure": failure,
            "displacement_mm": moved,
            "rotation_deg": turned,
            "peak_torque_nm": self.peak,
            "sim_seconds": self.time,
        }
        return row

    def _acquire(self) -> None:
        """Approach, close and squeeze until the object is at rest."""
        course, data, scene = self.course, self.data, self.scene
        _place(scene, data, self.thing, course.plan, course.approach[0], course.opening)
        arm, _ = _kinematics()
        self._follow("approach", course.approach, arm.duration(course.approach, APPROACH_TIME))
        fingers = FingerControl(
            course.plan.preshape,
            course.opening,
            self.limits,
            scene.model.actuator_gainprm[scene.motors, 0],
        )
        self.phase = "close"
        for _ in range(round(CLOSE_TIME / self.tick_time)):
            torques = data.actuator_force[scene.motors]
            data.ctrl[scene.motors] = fingers.close(torques, self.tick_time)
            self._tick()
            if fingers.closed:
                break
        self.phase = "squeeze"
        quiet = 0.0
        for _ in range(round(SQUEEZE_TIME / self.tick_time)):
            angles = data.qpos[scene.motor_qpos]
            data.ctrl[scene.motors] = fingers.squeeze(angles, self.tick_time)
            self._tick()
            speed = data.qvel[scene.object_dof : scene.object_dof + 6]
            still = np.linalg.norm(speed[:3]) < REST_SPEED and np.linalg.norm(speed[3:]) < REST_SPIN
            quiet = quiet + self.tick_time if still else 0.0
            if quiet > 0.1 and fingers.settled:
                break
        self.phase = "rest"
        self._wait(REST_TIME)

    def _snapshot(self, row: dict[str, Any]) -> tuple[TactileSnapshot, bool]:
        data, scene = self.data, self.scene
        forces = taxel_forces(scene, data)
        proximal, distal = arrays(readings(forces, scene.settings.sensor))
        snapshot = TactileSnapshot(
            proximal=proximal,
            distal=distal,
            joint_angles=data.qpos[scene.motor_qpos].copy(),
            motor_torques=data.actuator_force[scene.motors].copy(),
            object_pose_hand=self._object_in_hand(),
            hand_pose_world=np.concatenate((data.xpos[scene.palm], data.xquat[scene.palm])),
        )
        row |= {
            "tactile_proximal": proximal,
            "tactile_distal": distal,
            "joint_angles_rad": snapshot.joint_angles,
            "motor_torque_nm": snapshot.motor_torques,
            "object_pose_hand": snapshot.object_pose_hand,
            "hand_pose_world": snapshot.hand_pose_world,
        }
        return snapshot, bool(forces.sum() > 0.0)

    def _lift(self, before: np.ndarray) -> tuple[float, float, bool]:
        """Lift and hold; greatest displacement [mm], rotation [deg], and whether it fell."""
        arm, _ = _kinematics()
        duration = arm.duration(self.course.lift, LIFT_TIME)
        ticks = round((duration + HOLD_TIME) / self.tick_time)
        moved = turned = 0.0
        for k in range(1, ticks + 1):
            share = k * self.tick_time / duration
            self.phase = "lift" if share <= 1.0 else "hold"
            self.data.ctrl[self.scene.arm_motors] = along(self.course.lift, share)
            self._tick()
            step = outcome.motion(before, self._object_in_hand(), self.thing.com_m)
            moved, turned = max(moved, step[0]), max(turned, step[1])
            if moved > GONE_MM:
                return moved, turned, True
        return moved, turned, self._on_table()

    def _follow(self, phase: str, path: np.ndarray, duration: float) -> None:
        self.phase = phase
        for k in range(1, round(duration / self.tick_time) + 1):
            self.data.ctrl[self.scene.arm_motors] = along(path, k * self.tick_time / duration)
            self._tick()
        self._wait(0.1)

    def _wait(self, duration: float) -> None:
        for _ in range(round(duration / self.tick_time)):
            self._tick()

    def _tick(self) -> None:
        """One control period; peaks are read at every step, divergence within the tick."""
        model, data, motors = self.scene.model, self.data, self.scene.motors
        for _ in range(self.steps):
            mujoco.mj_step(model, data)
            np.maximum(self.peak, np.abs(data.actuator_force[motors]), out=self.peak)
        if not np.isfinite(data.qacc).all() or np.abs(data.qvel).max() > 1e3:
            raise Diverged
        if self.writer is not None:
            self.writer.sample(data, self.phase)

    def _on_table(self) -> bool:
        groups = np.sort(self.scene.geom_group[self.data.contact.geom], axis=1)
        return bool((groups == (OBJECT_GEOM, TABLE_GEOM)).all(axis=1).any())

    def _object_in_hand(self) -> np.ndarray:
        """Pose of the object in the palm frame, x y z qw qx qy qz (7,)."""
        data, palm, body = self.data, self.scene.palm, self.scene.object
        inverse, pose = np.empty(4), np.empty(7)
        mujoco.mju_negQuat(inverse, data.xquat[palm])
        mujoco.mju_rotVecQuat(pose[:3], data.xpos[body] - data.xpos[palm], inverse)
        mujoco.mju_mulQuat(pose[3:], inverse, data.xquat[body])
        return pose


def _plan_columns(course: Course) -> dict[str, Any]:
    plan = course.plan
    return {
        "approach": plan.approach,
        "preshape": plan.preshape,
        "plan_azimuth_rad": plan.azimuth,
        "plan_roll_rad": plan.roll,
        "plan_tilt_rad": plan.tilt,
        "plan_height_m": plan.height,
        "plan_depth_m": plan.depth,
        "plan_offset_m": plan.offset,
        "object_yaw_rad": plan.object_yaw,
        "resampled_unreachable": course.unreachable,
        "resampled_colliding": course.colliding,
    }
