"""Slip resistance: a cylinder in the hand is pulled along its axis, as by a tensile tester.

A stiff spring pulls at a point that moves away at a constant speed; the hand's base does not
yield. *First slip*: the cylinder slides on the hand half as fast as the point moves, in the mean
over the contacts by their forces. *Peak*: the greatest force until the cylinder has moved by 12
mm. Closed form of both: μ Σ N, of the normal forces before the pull; fingers that wrap a cylinder
press with friction around it as well, which leaves less of it for the axis.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from experiments.standard_tests.album import Album
from experiments.standard_tests.cylinder_grasp import Held
from experiments.standard_tests.load_objects import PIPES
from experiments.standard_tests.result_lines import Line
from experiments.standard_tests.specimen import Specimen
from sdh_sim.cell import Scene
from sdh_sim.errors import Diverged
from sdh_sim.poses import rotation_of

STIFFNESS, DAMPING = 5e3, 50.0  # of the spring [N/m], [N s/m]
SPEED, TRAVEL, TIME = 0.005, 0.012, 60.0  # [m/s], [m], [s] at most
TOLERANCE = 0.08  # part of the friction acts around the cylinder; the pull moves the fingers


@dataclass(frozen=True)
class Pull:
    """A pull along the axis.

    Attributes:
        moved: of the cylinder in the hand, tick by tick (n,) [m].
        force: of the spring (n,) [N].
        first, peak: slip and greatest force [N].
    """

    moved: np.ndarray
    force: np.ndarray
    first: float
    peak: float


def pull(held: Held) -> Pull:
    """Pull a grasped cylinder out of the hand; its simulation is left there.

    Raises:
        Diverged: the simulation did.
    """
    simulation, body = held.trial.simulation, held.trial.scene.object_body
    data = simulation.data
    axis = rotation_of(simulation.pose(body)[3:])[:, 2].copy()
    palm = simulation.pose(held.trial.scene.palm)
    start = (simulation.pose(body)[:3] - palm[:3]) @ axis
    moved, force = [0.0], [0.0]
    before, first = 0.0, math.nan
    for k in range(1, round(TIME / simulation.tick_time)):
        stretch = SPEED * k * simulation.tick_time - moved[-1]
        rate = SPEED - before
        now = float(max(0.0, STIFFNESS * stretch + DAMPING * rate))
        data.xfrc_applied[body, :3] = now * axis
        simulation.tick()
        at = float((simulation.pose(body)[:3] - palm[:3]) @ axis - start)
        before = (at - moved[-1]) / simulation.tick_time
        moved.append(at)
        force.append(now)
        if math.isnan(first) and sliding_speed(held.trial.scene, data, axis) > 0.5 * SPEED:
            first = now
        if at > TRAVEL:
            break
    data.xfrc_applied[body, :3] = 0.0
    return Pull(np.array(moved), np.array(force), first, max(force))


def sliding_speed(scene: Scene, data: mujoco.MjData, axis: np.ndarray) -> float:
    """Speed along an axis at which the object slides on the hand, weighted by the forces [m/s]."""
    model, wrench, twist = scene.model, np.zeros(6), np.zeros(6)
    total = weighted = 0.0
    for k in range(data.ncon):
        bodies = model.geom_bodyid[data.contact.geom[k]]
        if scene.object_body not in bodies or data.contact.efc_address[k] < 0:
            continue
        mujoco.mj_contactForce(model, data, k, wrench)
        speeds = []
        for body in bodies:
            kind = mujoco.mjtObj.mjOBJ_XBODY
            mujoco.mj_objectVelocity(model, data, kind, int(body), twist, 0)
            arm = data.contact.pos[k] - data.xpos[body]
            speeds.append((twist[3:] + np.cross(twist[:3], arm)) @ axis)
        own = 0 if bodies[0] == scene.object_body else 1
        total += wrench[0]
        weighted += wrench[0] * (speeds[own] - speeds[1 - own])
    return float(weighted / total) if total > 0.0 else math.inf


def slip_resistance(
    specimen: Specimen, held: Mapping[tuple[str, str], Held | str], album: Album
) -> list[Line]:
    """First slip and peak of every cylinder."""
    lines = []
    for (name, style), grasp in held.items():
        head = f"{style}, {PIPES[name][0]:g} mm"
        if isinstance(grasp, str):
            for what in ("first slip", "peak"):
                lines.append(
                    Line("slip_resistance", specimen.name, f"{head}, {what}", math.nan, math.nan,
                         note=grasp)
                )  # fmt: skip
            continue
        closed = grasp.trial.scene.obj.friction * float(grasp.found.normal.sum())
        try:
            found = pull(grasp)
        except Diverged:
            continue
        title = f"{specimen.name}:\n{head}, pulled"
        album.take("slip_resistance", title, grasp.trial.scene, grasp.trial.simulation.data)
        tolerance = TOLERANCE if style == "pinch" else math.nan
        note = "" if style == "pinch" else "closed form: near"
        for what, value in (("first slip", found.first), ("peak", found.peak)):
            lines.append(
                Line("slip_resistance", specimen.name, f"{head}, {what}", closed, value, tolerance,
                     note)
            )  # fmt: skip
    return lines
