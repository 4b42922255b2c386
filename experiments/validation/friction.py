"""Checks of friction: where a pad starts to slip, where a clamped box drops, how a contact creeps.

MuJoCo's friction is regularised: below Coulomb's limit a contact creeps at a speed proportional
to its load, v = f (1 - d) A / (impratio b). The limit itself is found by bisection; *slipping*
means moving several times faster than the creep law lets a contact within its limit move.
"""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.validation.result_rows import Result, Row, threshold
from experiments.validation.rig_readings import (
    advance,
    copy,
    pressed,
    squeezed,
    touches,
)
from experiments.validation.rigs import (
    GRAVITY,
    HONEST,
    TEST_BODY_MASS,
    Frame,
    Shape,
    Spoil,
    bench,
    gripper,
    set_friction,
    settings_for,
)
from sdh_sim.cell import Scene
from sdh_sim.cell.scene_builder import PAD_IMPEDANCE
from sdh_sim.robot import built_in_hand
from sdh_sim.robot import sdh2_constants as c

PRESS = 10.0  # [N]
FRICTION = 0.63  # of the paper's box
SLIP_FACTOR = 10.0  # times the creep law's speed that counts as a slide of a pad
DROP = 1e-4  # [m] in 0.3 s that counts as dropped: a hundred times the creep
PLATE = Shape("box", (0.005, 0.03, 0.05), (0.005, 0.0, 0.0))  # covers the whole proximal pad
MIDDLE = (6.5, 2.5)  # row and column of the middle of a proximal pad

# A box between the distal pads of fingers 1 and 2 opposing each other (spread 90°), 0.3 mm free
# on either side; its middle at row 10.5 of both pads, clear of the proximal ones.
CLAMP_ANGLES = np.array([np.pi / 2, 0, 0, 0, 0, 0, 0])
CLAMP_PUSH = np.array(
    [name in ("finger1_proximal", "finger2_proximal") for name in built_in_hand().motor_names]
)
CLAMP_PLACE = Frame(
    np.array([c.FINGERS[0].base[0], 0.0, c.FINGERS[0].base[2] + c.KNUCKLE_HEIGHT
              + c.PROXIMAL_LENGTH + 0.0275]), np.eye(3),
)  # fmt: skip
CLAMP_BOX = Shape("box", (0.015, 0.0179, 0.012))


def stickiness(scene: Scene, links: np.ndarray | list[str]) -> np.ndarray:
    """Creep resistance impratio b / ((1 - d) A) of one taxel of each link named [N s/m]."""
    model, values = scene.model, []
    for link in links:
        body = model.body(f"hand/{link}").id
        geom = int(np.flatnonzero((model.geom_bodyid == body) & (scene.taxel >= 0))[0])
        a = model.body_invweight0[body, 0] + model.body_invweight0[scene.object_body, 0]
        b = -model.geom_solref[geom, 1]
        values.append(model.opt.impratio * b / ((1.0 - PAD_IMPEDANCE) * a))
    return np.array(values)


def speed_under(scene: Scene, rest: mujoco.MjData, load: float) -> float:
    """Speed of a bench's second joint under a load on it [m/s or rad/s]."""
    data = copy(scene, rest)
    data.qfrc_applied[1] = load
    advance(scene, data, 0.2)
    return float(data.qvel[1])


def pad_onset(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Pull that starts a plate sliding on a pad pressed with a known force: μ N (Coulomb)."""
    rows, curves = [], {}
    for mu in (FRICTION,) if short else (0.2, 0.4, FRICTION, 0.9):
        for joint in ("pull",) if short else ("pull", "draw"):
            scene = bench("finger1_proximal", *MIDDLE, [PLATE], ["press", joint],
                          settings_for(), mu, spoil)  # fmt: skip
            rest = pressed(scene, PRESS)
            law = 1.0 / stickiness(scene, touches(scene, rest).links).sum()

            def slips(
                load: float, scene: Scene = scene, rest: mujoco.MjData = rest, law: float = law
            ) -> bool:
                return speed_under(scene, rest, load) > SLIP_FACTOR * law * load

            limit = mu * PRESS
            way = "across" if joint == "pull" else "along"
            rows.append(Row(
                f"pull {way} the finger that starts a slide, μ {mu:g}", "N", limit,
                threshold(slips, 0.5 * limit, 1.5 * limit), 0.01,
                "bisection 0.15 %; ten times the creep speed is reached within 0.5 % of the limit",
            ))  # fmt: skip
            loads = limit * np.array([0.1, 0.3, 0.6, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1])
            curves[way, mu] = (
                loads / limit, np.array([speed_under(scene, rest, x) for x in loads]), law * loads,
            )  # fmt: skip
    return Result(tuple(rows), curves)


def clamp(
    torque_limit: tuple[float, float], spoil: Spoil = HONEST, friction: float = 0.8,
    timestep: float | None = None, modulus: float = 1e6,
) -> tuple[Scene, mujoco.MjData]:  # fmt: skip
    """The box squeezed by two fingers, at rest without gravity."""
    scene = clamp_rig(torque_limit, spoil, friction, timestep, modulus)
    return scene, squeezed(scene, CLAMP_ANGLES, CLAMP_PUSH)


def clamp_rig(
    torque_limit: tuple[float, float], spoil: Spoil = HONEST, friction: float = 0.8,
    timestep: float | None = None, modulus: float = 1e6,
) -> Scene:  # fmt: skip
    """A box between two fingers that do not press yet."""
    settings = settings_for(timestep, modulus, torque_limit)
    return gripper(CLAMP_PLACE, [CLAMP_BOX], True, settings, friction, spoil)


def hung(
    scene: Scene, rest: mujoco.MjData, friction: float, seconds: float, axis: int = 0
) -> mujoco.MjData:
    """A clamped box with its weight on, along an axis of the palm frame, ramped up in 0.1 s."""
    set_friction(scene, friction)
    data = copy(scene, rest)
    for share in np.linspace(0.1, 1.0, 10):
        scene.model.opt.gravity[axis] = share * GRAVITY
        advance(scene, data, 0.01)
    advance(scene, data, seconds)
    return data


def clamp_drop(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Friction at which two fingers drop a box: μ = m g / ΣN, N read from the taxels."""
    rows, points, falls = [], [], {}
    for torque in (1.6401,) if short else (0.8, 1.2, 1.6401, 2.1):
        scene, rest = clamp((torque, 1.0934), spoil)
        grip = touches(scene, hung(scene, rest, 1.0, 0.3))
        predicted = TEST_BODY_MASS * GRAVITY / float(grip.normal.sum())

        def holds_not(inverse: float, scene: Scene = scene, rest: mujoco.MjData = rest) -> bool:
            data = hung(scene, rest, spoil.friction / inverse, 0.0)
            before = float(data.qpos[scene.object_qpos])
            advance(scene, data, 0.3)
            return float(data.qpos[scene.object_qpos]) - before > DROP

        found = 1.0 / threshold(holds_not, 0.5 / predicted, 1.5 / predicted)
        rows.append(Row(
            f"friction that drops the box, motors at {torque:.2f} N m", "", predicted, found, 0.01,
            "0.1 mm in 0.3 s needs 0.5 % of excess load; the fingers give way sideways by 0.3 °",
        ))  # fmt: skip
        points.append((predicted, found))
        for share in (0.95, 0.99, 1.01, 1.05):
            data, start = hung(scene, rest, share * predicted * spoil.friction, 0.0), []
            for _ in range(30):
                start.append(float(data.qpos[scene.object_qpos]))
                advance(scene, data, 0.01)
            falls[torque, share] = 1e3 * (np.array(start) - start[0])
    return Result(tuple(rows), {"points": np.array(points), "falls": falls})


def friction_creep(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Creep speed of a hanging box against the law of the regularised friction.

    All contacts resist alike, so a load beside their middle turns the box too: with c the
    resistance of one, n of them at distances r from their middle, and the load at distance e, the
    place of the load creeps at F (1 / (n c) + e² / (c Σ r²)). The law knows no time step and no
    solver tolerance.
    """
    variants = [(0.002, 1e-10, 1000.0), (0.004, 1e-10, 1000.0), (0.002, 1e-10, 100.0)]
    if not short:
        variants += [
            (0.0005, 1e-10, 1000.0), (0.001, 1e-10, 1000.0), (0.002, 1e-8, 1000.0),
            (0.002, 1e-12, 1000.0), (0.002, 1e-10, 10.0),
        ]  # fmt: skip
    rows = []
    for timestep, tolerance, ratio in variants:
        scene, rest = clamp((1.6401, 1.0934), timestep=timestep)
        scene.model.opt.impratio, scene.model.opt.tolerance = ratio, tolerance
        name = f"dt {1e3 * timestep:g} ms, tolerance {tolerance:g}, impratio {ratio:g}"
        rows.append(creep_row(
            name, scene, rest, 0, spoil,
            "the fingers give way sideways by 0.3 °, and 0.1 mm of the patch shifts with it",
        ))  # fmt: skip
    return Result(tuple(rows))


def creep_row(
    name: str, scene: Scene, rest: mujoco.MjData, axis: int, spoil: Spoil, reason: str
) -> Row:
    """Creep speed of a clamped box whose weight hangs along an axis of the palm frame, 0 or 1.

    The fingers press along the other of the two.
    """
    touch = touches(scene, rest)
    sticky = float(stickiness(scene, touch.links)[0])
    plane = touch.points[:, [axis, 2]]
    middle = plane.mean(axis=0)
    beside = float(rest.xpos[scene.object_body, 2] - rest.xpos[scene.palm, 2] - middle[1])
    lean = beside**2 / float(((plane - middle) ** 2).sum())
    law = TEST_BODY_MASS * GRAVITY / sticky * (1.0 / len(plane) + lean)
    scene.model.opt.impratio *= spoil.impratio
    data = hung(scene, rest, 0.8, 1.0, axis)
    place = scene.object_qpos + axis
    before = float(data.qpos[place])
    advance(scene, data, 0.5)
    speed = (float(data.qpos[place]) - before) / 0.5
    return Row(name, "µm/s", 1e6 * law, 1e6 * speed, 0.01, reason)
