"""Grasp strength: the force between the halves of a cylinder in the hand.

A split cylinder with a load cell between its halves measures what the fingers of one side press
with across the split. Here it is the sum of the contact forces on one side, since the cylinder is
at rest. The closed form of a pinch is what the levers of its sides allow (``pinch_limit``), of a
wrap what statics allow at most with the motors' limits and the friction cones at the contacts
that came about. A hand does not have to reach that: it presses with the torques that its servos
are at, not with those that would press hardest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from experiments.standard_tests.album import Album
from experiments.standard_tests.contact_forces import (
    force_between_halves,
    greatest_between_halves,
)
from experiments.standard_tests.cylinder_grasp import Held, smoother, styles, take
from experiments.standard_tests.load_objects import PIPES
from experiments.standard_tests.result_lines import Line
from experiments.standard_tests.specimen import Specimen
from sdh_sim.robot import HAND, hand_kinematics

TOLERANCE = 0.05  # levers at the centres of the forces; friction bears some of it
SPLITS = {"across": (1.0, 0.0, 0.0), "towards the palm": (0.0, 0.0, 1.0)}
"""Normals of the split in the palm frame: fingers against thumb, and fingers against palm."""


def held_cylinders(
    specimen: Specimen, folders: Mapping[str, Path], seed: int, album: Album
) -> dict[tuple[str, str], Held | str]:
    """Every cylinder taken in every style, by name of cylinder and style."""
    found: dict[tuple[str, str], Held | str] = {}
    for name, (outer, _) in PIPES.items():
        for style in styles(specimen.hand, 0.5e-3 * outer):
            grasp = found[name, style.name] = take(specimen, folders[name], style, seed)
            if isinstance(grasp, Held):
                title = f"{specimen.name}:\n{style.name}, {outer:g} mm"
                data = grasp.trial.simulation.data
                album.take("grasp_strength", title, grasp.trial.scene, data)
    return found


def grasp_strength(specimen: Specimen, held: Mapping[tuple[str, str], Held | str]) -> list[Line]:
    """Force between the halves, for both splits where the cylinder is wrapped."""
    lines = []
    for (name, style), grasp in held.items():
        for split, normal in SPLITS.items():
            if style == "pinch" and split != "across":
                continue
            condition = f"{style}, {PIPES[name][0]:g} mm, {split}"
            if isinstance(grasp, str):
                lines.append(
                    Line("grasp_strength", specimen.name, condition, math.nan, math.nan, note=grasp)
                )
                continue
            across = np.array(normal)
            force = force_between_halves(grasp.found, grasp.centre, across)
            closed, tolerance, note = _closed(specimen, grasp, across, style)
            lines.append(
                Line("grasp_strength", specimen.name, condition, closed, force, tolerance, note)
            )
    return lines


def _closed(
    specimen: Specimen, grasp: Held, across: np.ndarray, style: str
) -> tuple[float, float, str]:
    """Closed form, its tolerance, and a note."""
    felt = grasp.found.normal[grasp.found.sensed].sum() / max(grasp.found.normal.sum(), 1e-9)
    words = f"taxels bear {100.0 * felt:.0f} %"
    settings = specimen.settings
    shared = not np.array_equal(specimen.hand.joined_fingers, np.eye(len(specimen.hand.fingers)))
    if style == "pinch" and not shared:
        return pinch_limit(specimen, grasp), TOLERANCE, words
    if settings.drive != "yield":
        return math.nan, math.nan, f"{words}; no closed form with drives that {settings.drive}"
    most = greatest_between_halves(
        grasp.trial.scene, grasp.angles, smoother(grasp), grasp.centre, across, specimen.limits
    )
    if style == "pinch":
        return most, TOLERANCE, words
    return most, math.nan, f"{words}; closed form: at most"


def pinch_limit(specimen: Specimen, grasp: Held) -> float:
    """What a pinch can press with across, from levers alone [N].

    Each side pushes with Σ τ̄ / |J_jᵀ x| of its fingers. Between motors that yield the weaker side
    gives way to the stronger; with friction in the gears it bears more, as much as the stronger one
    pushes with at most; where gears lock, the stronger side alone says.
    """
    posture = hand_kinematics(specimen.hand).at(grasp.angles)
    sides = {1.0: 0.0, -1.0: 0.0}
    for index, finger in enumerate(specimen.hand.fingers):
        own = np.array([finger_of(grasp, link) == index for link in grasp.found.links])
        weight = grasp.found.normal * own
        if not weight.sum() > 0.0:
            continue
        point = weight @ grasp.found.points / weight.sum()
        link = grasp.found.links[int(np.argmax(weight))]
        levers = np.abs(posture.of_motors(posture.jacobian(link, point))[0])
        pushes = [k for k in finger.stops if levers[k] > 1e-3]
        side = 1.0 if point[0] > grasp.centre[0] else -1.0
        sides[side] += min(specimen.limits[k] / levers[k] for k in pushes)
    weak, strong = sorted(sides.values())
    settings = specimen.settings
    bears = {"yield": 1.0, "hold": 1.0 + settings.gear_friction, "lock": math.inf}
    return min(strong, weak * bears[settings.drive]) if weak > 0.0 else 0.0


def finger_of(grasp: Held, link: str) -> int:
    """Index of the finger that a body of the hand is part of, -1: of none."""
    scene = grasp.trial.scene
    body = scene.model.body(HAND + link).id
    geoms = np.flatnonzero(scene.model.geom_bodyid == body)
    return int(scene.geom_finger[geoms[0]]) if len(geoms) else -1
