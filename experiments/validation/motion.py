"""Checks of motion and numerics: a released object, a whole grasp, independence of the solver."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import mujoco
import numpy as np

from experiments.validation.friction import CLAMP_ANGLES, CLAMP_BOX, CLAMP_PLACE, CLAMP_PUSH
from experiments.validation.result_rows import Result, Row
from experiments.validation.rig_readings import advance, squeezed, torques_of, touches
from experiments.validation.rigs import (
    GRAVITY,
    HONEST,
    TEST_BODY_MASS,
    Spoil,
    gripper,
    settings_for,
    timestep_in_use,
)
from sdh_sim.cell import Scene, build_scene
from sdh_sim.cell.contacts import taxel_forces
from sdh_sim.cell.scene_builder import taxel_stiffness
from sdh_sim.robot import sdh2_constants as c
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial

INERTIA = (2e-4, 5e-4, 6e-4)  # of the released box [kg m²]: three different values
PROXIMAL_AXIS = c.FINGERS[0].base[2] + c.KNUCKLE_HEIGHT  # height of it over the palm frame [m]
SPIN = np.array([3.0, 0.5, -2.0])  # given to it when the fingers have let go [rad/s]
FALL_TIME = 0.24  # [s]; a whole number of every step tried


def _state(scene: Scene, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Momentum (3,), angular momentum about its centre (3,), kinetic and potential energy."""
    model = scene.model
    mujoco.mj_kinematics(model, data)  # a step leaves the orientation of its beginning
    dof, body = scene.object_dof, scene.object_body
    turn = data.xmat[body].reshape(3, 3)
    speed, spin = data.qvel[dof : dof + 3], data.qvel[dof + 3 : dof + 6]
    inertia = model.body_inertia[body]
    momentum = TEST_BODY_MASS * speed
    kinetic = 0.5 * TEST_BODY_MASS * float(speed @ speed) + 0.5 * float(inertia @ spin**2)
    height = float(data.qpos[scene.object_qpos + 2])
    # Gravity points out of the palm, along +z.
    return momentum, turn @ (inertia * spin), kinetic, -TEST_BODY_MASS * GRAVITY * height


def release(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """A box let go by two fingers falls out of the hand: momentum, spin and energy in free fall.

    One step of the semi-implicit Euler method gives velocities exactly and places that are
    ½ g t dt behind, so its energy falls behind by ½ m g² t dt: the closed form of the drift.
    Torque-free rotation is integrated to (ω dt)² a step.
    """
    rows, curves = [], {}
    for timestep in (0.002,) if short else (0.0005, 0.001, 0.002, 0.004):
        scene = gripper(CLAMP_PLACE, [CLAMP_BOX], True, settings_for(timestep), 0.6,
                        inertia=INERTIA)  # fmt: skip
        data = squeezed(scene, CLAMP_ANGLES, CLAMP_PUSH, 0.5)
        data.ctrl[scene.motors] = CLAMP_ANGLES - 0.5 * CLAMP_PUSH
        for _ in range(round(0.5 / timestep)):
            advance(scene, data, timestep)
            if len(touches(scene, data).normal) == 0:
                break
        else:
            raise RuntimeError("the fingers did not let go of the box within 0.5 s")
        kick = data.qvel[scene.object_dof : scene.object_dof + 3].copy()
        advance(scene, data, 0.2)  # let the fingers clear the box's corners
        data.qvel[scene.object_dof + 3 : scene.object_dof + 6] = SPIN
        scene.model.opt.gravity[2] = GRAVITY * spoil.gravity
        mujoco.mj_forward(scene.model, data)
        before = _state(scene, data)
        times, drift, turned, now = [], [], [], before
        for _ in range(round(FALL_TIME / timestep)):
            advance(scene, data, timestep)
            now = _state(scene, data)
            times.append((len(times) + 1) * timestep)
            drift.append(now[2] + now[3] - before[2] - before[3])
            turned.append(float(np.linalg.norm(now[1] - before[1]) / np.linalg.norm(before[1])))
        gained = float(now[0][2] - before[0][2])
        law = -0.5 * TEST_BODY_MASS * GRAVITY**2 * times[-1] * timestep
        spin2 = float(SPIN @ SPIN)
        energy = 0.5 * TEST_BODY_MASS * (GRAVITY * times[-1]) ** 2
        step = f"{1e3 * timestep:g} ms"
        rows += [
            Row(f"momentum gained in {FALL_TIME:g} s of fall, dt {step}", "N s",
                TEST_BODY_MASS * GRAVITY * times[-1], gained, 1e-6, "exact but for round-off"),
            Row(f"energy drift in the fall, dt {step}", "mJ", 1e3 * law, 1e3 * drift[-1],
                spin2 * timestep * times[-1] * 0.5 * float(np.dot(INERTIA, SPIN**2)) / energy,
                "½ m g² t dt; rotation to ω² t dt of its energy", scale=1e3 * energy),
            Row(f"angular momentum lost, dt {step}", "", 0.0, turned[-1],
                spin2 * timestep * times[-1], "(ω dt)² a step", scale=1.0),
            Row(f"speed left by the opening fingers, dt {step}", "mm/s", 0.0,
                1e3 * float(np.linalg.norm(kick)), 1.0,
                "pads let go give back e^-2 of their energy at most",
                scale=1e3 * _recoil_speed(scene)),
        ]  # fmt: skip
        curves[timestep] = (np.array(times), np.array(drift), np.array(turned))
    return Result(tuple(rows), {"falls": curves})


def _recoil_speed(scene: Scene) -> float:
    """Speed [m/s] of the box if it took e^-2 of the elastic energy of both pads."""
    torque = scene.model.actuator_forcerange[scene.motors[CLAMP_PUSH], 1][0]
    force = torque / float(CLAMP_PLACE.position[2] - PROXIMAL_AXIS)
    pad = 30 * taxel_stiffness(scene.settings, c.TAXEL_PITCH)  # taxels under the box on either side
    return math.sqrt(2.0 * force**2 / pad * math.exp(-2.0) / TEST_BODY_MASS)


@dataclass(frozen=True)
class Held:
    """A real object in the real hand after acquisition.

    Attributes:
        sensed, unsensed: normal force on taxels and on the rest of the hand [N].
        position: of the object in the palm frame (3,) [m].
        quat: its orientation there, w x y z (4,).
        residual: largest |Σ Jᵀ f - τ| over motors off their joint limits [N m].
        tactile: sum of the tactile arrays [N].
        sums: Σ Jᵀ f (7,), motor torques (7,) [N m] and motors off their joint limits (7,) bool.
    """

    sensed: float
    unsensed: float
    position: np.ndarray
    quat: np.ndarray
    residual: float
    tactile: float
    sums: tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Numerics:
    """Time step [s], solver tolerance and ratio of friction to normal impedance."""

    timestep: float = field(default_factory=timestep_in_use.get)
    tolerance: float = 1e-10
    impratio: float = 100.0


def hold(name: str, seed: int, numerics: Numerics, spoil: Spoil = HONEST) -> Held:
    """Grasp an object in the real workcell as a trial does, under other numerics."""
    # The motion is planned with the default settings, so that all variants run the same one.
    motion = Trial(TrialSettings(name), seed).motion
    settings = TrialSettings(name, timestep=numerics.timestep)
    scene = build_scene(settings)
    scene.model.opt.tolerance = numerics.tolerance
    scene.model.opt.impratio = numerics.impratio
    scene.model.geom_solref[scene.taxel >= 0] *= (spoil.stiffness, math.sqrt(spoil.stiffness))
    scene.model.body_gravcomp[:] *= spoil.gravity
    trial = Trial(settings, seed, scene=scene, motion=motion)
    trial.acquire()
    data = trial.simulation.data
    motors = data.actuator_force[scene.motors].copy()
    angles = data.qpos[scene.motor_qpos]
    sums = torques_of(scene, angles, touches(scene, data))
    reach = scene.model.jnt_range[scene.model.dof_jntid[scene.motor_dof]]
    # A joint against its stop is held by the stop too.
    free = (angles > reach[:, 0] + 1e-3) & (angles < reach[:, 1] - 1e-3)
    sensed, unsensed = trial.simulation.hand_force()
    pose = trial.simulation.object_in_hand()
    return Held(
        sensed, unsensed, pose[:3], pose[3:], float(np.abs(sums - motors)[free].max()),
        float(taxel_forces(scene, data).sum()), (sums, motors, free),
    )  # fmt: skip


GRASPS = (("cylindrical_bottle", 1), ("box", 0), ("box", 1), ("cylindrical_bottle", 0))


def whole_grasp(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Grasps of the real workcell at rest: motor torques against all contact forces."""
    rows, sums = [], []
    for name, seed in GRASPS[:1] if short else GRASPS:
        held = hold(name, seed, Numerics(), spoil)
        limit = TrialSettings(name).torque_limit[0]
        rows += [
            Row(f"{name}, seed {seed}: Σ Jᵀf less τ, worst motor", "N m", 0.0, held.residual, 2e-3,
                "statics are exact; solver tolerance and what motion is left",
                scale=limit),
            Row(f"{name}, seed {seed}: sum of the arrays", "N", held.sensed, held.tactile, 1e-9,
                "every taxel contact is in an array, once"),
        ]  # fmt: skip
        sums.append((f"{name}, seed {seed}", *held.sums))
    return Result(tuple(rows), {"sums": sums})


def numerics(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Force and pose of a grasp under other time steps, tolerances and impratios.

    Impratio 10 is shown for contrast: friction creeps ten times faster, and what the fingers
    lock into the grasp while they close is partly gone when they rest. Where hard parts of the
    hand carry load beside the pads, how the two share it is statically indeterminate and hangs on
    tenths of a millimetre: there the taxels' part of the force is noted, not judged.
    """
    variants = {
        "dt 0.5 ms": Numerics(timestep=0.0005),
        "dt 1 ms": Numerics(timestep=0.001),
        "dt 2 ms": Numerics(timestep=0.002),
        "dt 4 ms": Numerics(timestep=0.004),
        "tolerance 1e-8": Numerics(tolerance=1e-8),
        "tolerance 1e-12": Numerics(tolerance=1e-12),
        "impratio 10": Numerics(impratio=10.0),
        "impratio 1000": Numerics(impratio=1000.0),
    }
    variants.pop(f"dt {1e3 * timestep_in_use.get():g} ms", None)  # the usual one
    if short:
        variants = {k: v for k, v in variants.items() if k in ("dt 4 ms", "impratio 1000")}
    rows, points = [], []
    for name, seed in GRASPS[:1] if short else GRASPS:
        usual = hold(name, seed, Numerics())
        for label, variant in variants.items():
            held = hold(name, seed, variant, spoil)
            moved = 1e3 * float(np.linalg.norm(held.position - usual.position))
            turned = math.degrees(2.0 * math.acos(min(1.0, abs(float(held.quat @ usual.quat)))))
            force = usual.sensed + usual.unsensed
            judged = label != "impratio 10"
            known = f"{name} {seed}, {label}"
            rows += [
                Row(f"{known}: force of the hand", "N", force, held.sensed + held.unsensed, 0.05,
                    "motors at their limits fix it; the others follow the pose by 20 N m/rad",
                    judged=judged),
                Row(f"{known}: of it on taxels", "N", usual.sensed, held.sensed, 0.05,
                    "as above; shared with hard parts of the hand it is indeterminate",
                    judged=judged and usual.unsensed == 0.0),
                Row(f"{known}: object displaced", "mm", 0.0, moved, 0.1,
                    "a tenth of the 10 mm that decide the label", scale=10.0, judged=judged),
                Row(f"{known}: object turned", "°", 0.0, turned, 0.1,
                    "a tenth of the 10° that decide the label", scale=10.0, judged=judged),
            ]  # fmt: skip
            points.append(
                (
                    f"{name}, seed {seed}",
                    label,
                    (held.sensed + held.unsensed) / force,
                    moved,
                    turned,
                )
            )
    return Result(tuple(rows), {"points": points})
