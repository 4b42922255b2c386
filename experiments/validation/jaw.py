"""Checks of the parallel jaw: pad forces, array sums, torsion, creep, independence of the step.

One motor moves both jaws by q, so by virtual work F δq = N_left δq + N_right δq: pads that press on
an object that is free to move between them press with F / 2 each, and a fixed body that one pad
meets alone takes all of F.
"""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.validation.friction import (
    FRICTION,
    MIDDLE,
    PLATE,
    PRESS,
    creep_row,
    hung,
)
from experiments.validation.result_rows import Result, Row
from experiments.validation.rig_engine import MUJOCO, RigEngine
from experiments.validation.rig_readings import squeezed, touches
from experiments.validation.rigs import (
    HONEST,
    Frame,
    Shape,
    Spoil,
    gripper,
    pad_frame,
    settings_for,
    timestep_in_use,
)
from experiments.validation.torsion import spinning
from sdh_sim.cell import Scene
from sdh_sim.robot import built_in_hand

JAW = built_in_hand("parallel_jaw")
PADS = ("left_pad", "right_pad")
PUSH = np.array([True])
FORCE = 40.0  # of the motor where a check needs one [N]
HALF_WIDTH = 0.02  # of the box between the pads [m]
BOX = Shape("box", (HALF_WIDTH, 0.03, 0.03))  # covers both pads, so that no edge presses on taxels
STAMP = Shape("box", (HALF_WIDTH, 0.0068, 0.0136))  # 4 columns and 8 rows, with edges on the pads
# The middle of both pads, between the jaws.
BETWEEN = Frame(np.array([0.0, 0.0, pad_frame(PADS[0], *MIDDLE, hand=JAW).position[2]]), np.eye(3))
START = np.array([0.05 - 3e-4])  # jaws 0.3 mm from the box [m]
SETTLES = 3.0  # [s]; the rubber of a pad on a fixture moves at a rate of 6/s only


def held(
    force: float, spoil: Spoil = HONEST, friction: float = 0.8, timestep: float | None = None,
    aside: float = 0.0,
) -> tuple[Scene, mujoco.MjData]:  # fmt: skip
    """A box between the pads at rest without gravity, ``aside`` off the middle [m]."""
    scene = jaw_rig(force, spoil, friction, timestep, aside=aside)
    return scene, squeezed(scene, START - abs(aside), PUSH, SETTLES)


def jaw_rig(
    force: float, spoil: Spoil = HONEST, friction: float = 0.8, timestep: float | None = None,
    free: bool = True, aside: float = 0.0, shape: Shape = BOX,
) -> Scene:  # fmt: skip
    """A box between jaws that do not press yet, ``aside`` off the middle [m]."""
    place = Frame(BETWEEN.position + np.array([aside, 0.0, 0.0]), BETWEEN.rotation)
    settings = settings_for(timestep)
    return gripper(place, [shape], free, settings, friction, spoil, hand=JAW, limit=(force,))


def jaw_force(short: bool = False, spoil: Spoil = HONEST, engine: RigEngine = MUJOCO) -> Result:
    """Force of each pad and sum of its array against the motor's force.

    Where an edge of the object lies on a pad and is pressed in deeply, spheres beside it bear on it
    too, with slanted normals: the readings sum to more than the force on the pad.
    """
    rows = []
    for force in (FORCE,) if short else (10.0, FORCE, 100.0):
        for free, aside, shares in (
            (True, 0.0, (0.5, 0.5)), (True, 2e-3, (0.5, 0.5)), (False, 2e-3, (0.0, 1.0)),
        ):  # fmt: skip
            scene = jaw_rig(force, spoil, free=free, aside=aside)
            rest = engine.squeezed(scene, START - abs(aside), PUSH, SETTLES)
            touch = rest.touches()
            where = f"{force:g} N, box {'free' if free else 'fixed'}, {1e3 * aside:g} mm aside"
            for pad, share, inward in zip(PADS, shares, (1.0, -1.0), strict=True):
                link = pad.replace("pad", "jaw")
                pressed = inward * float(touch.forces[touch.links == link, 0].sum())
                rows.append(Row(
                    f"{where}: {pad} presses with", "N", share * force, pressed, 1e-3,
                    "statics are exact; the coupling yields by a quarter of a micrometre",
                    scale=force,
                ))  # fmt: skip
                rows.append(Row(
                    f"{where}: sum of the {pad}'s array", "N", share * force,
                    rest.imprint(pad).total, 1e-3, "as above; all normals are the box's",
                    scale=force,
                ))  # fmt: skip
    for force in () if short else (FORCE, 100.0):
        scene = jaw_rig(force, spoil, free=False, aside=2e-3, shape=STAMP)
        rest = engine.squeezed(scene, START - 2e-3, PUSH, SETTLES)
        rows.append(Row(
            f"{force:g} N, edges on the pad: sum of the right_pad's array", "N", force,
            rest.imprint(PADS[1]).total, 0.05, "normals at an edge are slanted",
            judged=False,
        ))  # fmt: skip
    return Result(tuple(rows))


def jaw_torsion(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Moment that starts a flat patch spinning on a pad, against equation 7's τ*."""
    shapes = {
        "plate on the whole pad": PLATE,
        "stamp of 10.5 mm": Shape("box", (0.005, 0.00525, 0.00525), (0.005, 0.0, 0.0)),
    }
    rows = []
    for name in list(shapes)[:1] if short else shapes:
        spin = spinning(PADS[0], MIDDLE, shapes[name], spoil, JAW)
        seventh = FRICTION * spin.mark.total * spin.mark.torsion_arm
        rows += [
            Row(f"{name}: sum of the array", "N", PRESS, spin.mark.total, 1e-3, "at rest"),
            Row(f"{name}: eq. 7, tactile array", "N m", seventh, spin.found, 0.02,
                "the last taxel has yielded 1 % beyond the limit; bisection 0.2 %"),
        ]  # fmt: skip
    return Result(tuple(rows))


def jaw_creep(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Creep speed of a box that hangs across the fingers, against the law of friction's creep."""
    rows = []
    variants = [(0.002, 1000.0), (0.004, 1000.0), (0.002, 100.0)]
    for timestep, ratio in variants if short else [(0.001, 1000.0), *variants]:
        scene, rest = held(FORCE, timestep=timestep)
        scene.model.opt.impratio = ratio
        name = f"dt {1e3 * timestep:g} ms, impratio {ratio:g}"
        rows.append(creep_row(name, scene, rest, 1, spoil, "what the solver leaves"))
    return Result(tuple(rows))


def jaw_step(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """A box squeezed off the middle and hung from the pads: force and place at other steps."""
    usual_step = timestep_in_use.get()
    usual = _carried(usual_step)
    rows = []
    for step in (usual_step / 2,) if short else (0.0005, 0.001, 0.002, 0.004):
        if step == usual_step:
            continue
        force, place = _carried(step, spoil)
        moved = float(np.linalg.norm(place - usual[1]))
        rows += [
            Row(f"dt {1e3 * step:g} ms: force of both pads", "N", usual[0], force, 1e-3,
                "the motor fixes it"),
            Row(f"dt {1e3 * step:g} ms: box displaced", "mm", 0.0, 1e3 * moved, 1e-3,
                "a thousandth of the 10 mm that decide the label", scale=10.0),
        ]  # fmt: skip
    return Result(tuple(rows))


def _carried(timestep: float, spoil: Spoil = HONEST) -> tuple[float, np.ndarray]:
    """Normal force [N] on a box hung from the pads, and its place in the palm frame (3,) [m]."""
    scene, rest = held(FORCE, spoil, timestep=timestep, aside=2e-3)
    data = hung(scene, rest, FRICTION, 0.5, axis=1)
    place = data.xpos[scene.object_body] - data.xpos[scene.palm]
    return float(touches(scene, data).normal.sum()), place
