"""A cylinder in the hand: pinched by the fingertips or wrapped, free and without weight.

The cylinder lies across the palm, along its y. The hand is where a closing for fingertip grasps
has its fingers meet (pinch), or as near to the palm as the open hand lets the cylinder (wrap). Of
a wrap the squeezing motors that nothing has stopped yet close on until something does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.standard_tests.contact_forces import ContactForces, contact_forces
from experiments.standard_tests.specimen import Specimen
from sdh_sim.errors import Diverged
from sdh_sim.grasping import GraspPlan
from sdh_sim.objects import object_info
from sdh_sim.poses import quaternion_of, rotation_of
from sdh_sim.robot import Closing, Hand
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial

STEP, DEEPEST = 0.005, 0.3  # in which wrap depths are tried [m]
STOPPED = 0.5  # share of its limit that a motor bears which something has stopped
CLOSE_ON = 3.0  # [s]
MOST_TRIED = 8  # depths
# Axes of the palm in the cylinder's frame, whose z is its axis: y of the palm along it.
PALM_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Style:
    """A way to take a cylinder.

    Attributes:
        name: ``pinch`` or ``wrap``.
        closing: of the hand.
        centre: of the fingers along the palm's x [m].
        depths: of the axis from the palm that are tried, in this order [m].
    """

    name: str
    closing: Closing
    centre: float
    depths: tuple[float, ...]


def styles(hand: Hand, radius: float) -> list[Style]:
    """How a hand can take a cylinder of a radius [m]; empty where nobody said how it grasps."""
    found = []
    for wanted in ("pinch", "wrap"):
        for name, reach in hand.reaches.items():
            if (reach.precision_depth is not None) != (wanted == "pinch"):
                continue
            if reach.precision_depth is not None:
                depths = (float(np.mean(reach.precision_depth)),)
            else:
                depths = tuple(np.arange(radius, DEEPEST, STEP))
            found.append(Style(wanted, hand.closing(name), reach.centre, depths))
            break
    return found


@dataclass(frozen=True)
class Held:
    """A grasped cylinder at rest.

    Attributes:
        trial: with the simulation.
        found: what the hand presses with.
        centre: of the cylinder, in the palm frame (3,) [m].
        angles: positions of the motors (n,) [rad or m].
        axis: of the cylinder in the palm frame (3,).
    """

    trial: Trial
    found: ContactForces
    centre: np.ndarray
    angles: np.ndarray
    axis: np.ndarray


def take(specimen: Specimen, folder: Path, style: Style, seed: int) -> Held | str:
    """Grasp a cylinder; a string says why that cannot be done.

    A wrap is tried from the palm outward, until links at the ends of fingers touch as well as
    others; where none does so within some steps, the deepest grasp counts.
    """
    settings, why = specimen.settings_with(folder), "no depth was tried"
    tips = {finger.tip for finger in specimen.hand.fingers}
    deepest: Held | None = None
    tried = 0
    for depth in style.depths:
        trial = Trial(settings, seed, plan=_plan(settings, style, depth))
        if trial.infeasible is not None:
            why = trial.infeasible.reason
            continue
        try:
            trial.acquire()
            if style.name == "wrap":
                close_on(trial, style.closing)
        except Diverged:
            why = "the simulation diverged"
            continue
        tried += 1
        if trial.touched:
            held = _held(trial)
            links = set(smoother(held).links)
            if style.name == "pinch" or (links & tips and links - tips):
                return held
            deepest = deepest or held
        else:
            why = "the fingers close past the cylinder"
        if tried == MOST_TRIED:
            break
    return deepest or why


def close_on(trial: Trial, closing: Closing) -> None:
    """Let squeezing motors that bear little close on until they are at their limit."""
    scene, simulation = trial.scene, trial.simulation
    data, limits = simulation.data, simulation.limits
    spans = np.array([motor.span for motor in scene.hand.motors])
    torques = np.abs(data.actuator_force[scene.motors])
    moving = closing.squeezes & (torques < STOPPED * limits)
    sense = np.where(closing.travel < 0.0, -1.0, 1.0)
    speed = np.array([motor.closing_speed for motor in scene.hand.motors])
    reference = data.ctrl[scene.motors].copy()
    for _ in range(round(CLOSE_ON / simulation.tick_time)):
        loads = np.abs(data.actuator_force[scene.motors])
        step = sense * speed * simulation.tick_time * (moving & (loads < limits))
        reference = np.clip(reference + step, *spans.T)
        simulation.tick(hand=reference)
    simulation.wait(1.0)


def _plan(settings: TrialSettings, style: Style, depth: float) -> GraspPlan:
    obj = object_info(settings.object, settings.folder)
    at = -PALM_AXES @ np.array([style.centre, 0.0, depth])
    pose = np.concatenate((at, quaternion_of(PALM_AXES)))
    return GraspPlan.from_pose(obj, pose, style.closing, object_yaw=0.0)


def _held(trial: Trial) -> Held:
    scene, simulation = trial.scene, trial.simulation
    pose = simulation.object_in_hand()
    found = contact_forces(scene, simulation.data)
    axis = rotation_of(pose[3:])[:, 2]
    return Held(trial, found, pose[:3], scene.motor_positions(simulation.data), axis)


def smoother(held: Held) -> ContactForces:
    """The contacts that bear more than a thousandth of the force."""
    found = held.found
    much = found.normal > 1e-3 * found.normal.sum()
    links = tuple(name for name, keep in zip(found.links, much, strict=True) if keep)
    return replace(
        found, points=found.points[much], normals=found.normals[much], forces=found.forces[much],
        links=links, sensed=found.sensed[much],
    )  # fmt: skip
