"""Checks of friction: where a pad starts to slip, where a patch starts to spin, how it creeps.

MuJoCo's friction is regularised: below Coulomb's limit a contact creeps at a speed proportional
to its load, v = f (1 - d) A / (impratio b). The limit itself is found by bisection; *slipping*
means moving several times faster than the creep law lets a contact within its limit move.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import mujoco
import numpy as np

from experiments.validation.result_rows import Result, Row, threshold
from experiments.validation.rig_readings import (
    Imprint,
    Touch,
    advance,
    copy,
    imprint,
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
    pad_frame,
    set_friction,
    settings_for,
)
from sdh_sim.cell import Scene
from sdh_sim.cell.scene_builder import PAD_IMPEDANCE
from sdh_sim.robot import Hand, built_in_hand
from sdh_sim.robot import sdh2_constants as c

PRESS = 10.0  # [N]
FRICTION = 0.63  # of the paper's box
SLIP_FACTOR = 10.0  # times the creep law's speed that counts as a slide of a pad
SPIN_FACTOR = 2.0  # times the creep speed at which the innermost taxel of a patch yields
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


def _loaded(scene: Scene, rest: mujoco.MjData, load: float) -> float:
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
                return _loaded(scene, rest, load) > SLIP_FACTOR * law * load

            limit = mu * PRESS
            way = "across" if joint == "pull" else "along"
            rows.append(Row(
                f"pull {way} the finger that starts a slide, μ {mu:g}", "N", limit,
                threshold(slips, 0.5 * limit, 1.5 * limit), 0.01,
                "bisection 0.15 %; ten times the creep speed is reached within 0.5 % of the limit",
            ))  # fmt: skip
            loads = limit * np.array([0.1, 0.3, 0.6, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1])
            curves[way, mu] = (
                loads / limit, np.array([_loaded(scene, rest, x) for x in loads]), law * loads,
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


SPUN = {
    # name: link, row and column, shape, radius of curvature [m] (inf: flat)
    "plate on the whole proximal pad": ("finger1_proximal", MIDDLE, PLATE, np.inf),
    "stamp of 10.5 mm": (
        "finger1_proximal", MIDDLE, Shape("box", (0.005, 0.00525, 0.00525), (0.005, 0, 0)), np.inf),
    "bar along the finger, r 30 mm": (
        "finger1_proximal", MIDDLE, Shape("cylinder", (0.03, 0.05), (0.03, 0, 0)), 0.03),
    "bar across the fingertip, r 30 mm": (
        "finger1_distal", (6.0, 2.5),
        Shape("cylinder", (0.03, 0.03), (0.03, 0, 0), (0, 1, 0)), 0.03),
    "ball, r 40 mm": (
        "finger1_proximal", MIDDLE, Shape("sphere", (0.04,), (0.04, 0, 0)), 0.04),
    "ball, r 20 mm": (
        "finger1_proximal", MIDDLE, Shape("sphere", (0.02,), (0.02, 0, 0)), 0.02),
}  # fmt: skip


class Spin(NamedTuple):
    """A patch that is twisted about its middle.

    Attributes:
        mark: the pad's tactile array.
        exact: μ ΣN l of the contact points [N m].
        found: moment that starts it spinning [N m].
        law: speed of the creep per moment [rad/s per N m].
        speed: at a moment, of the simulation.
    """

    mark: Imprint
    exact: float
    found: float
    law: float
    speed: Callable[[float], float]


def spinning(
    pad: str, at: tuple[float, float], shape: Shape, spoil: Spoil, hand: Hand | None = None
) -> Spin:
    """A shape pressed on a pad at a row and column, and the moment that starts it spinning."""
    # Pressed without friction: spinning, none is left to carry load towards the middle.
    scene = bench(pad, *at, [shape], ["press", "twist"], settings_for(), 0.0, spoil, hand)
    rest = pressed(scene, PRESS)
    set_friction(scene, FRICTION * spoil.friction)
    mark, touch = imprint(scene, rest, pad), touches(scene, rest)
    frame = pad_frame(pad, *at, hand=hand)
    arms = np.linalg.norm(((touch.points - frame.position) @ frame.rotation)[:, 1:], axis=1)
    exact = FRICTION * float(touch.normal @ arms)
    sticky = stickiness(scene, touch.links)
    yielded = SPIN_FACTOR * FRICTION * float((touch.normal / (sticky * arms)).max())

    def speed(load: float) -> float:
        return _loaded(scene, rest, load)

    found = threshold(lambda load: speed(load) > yielded, 0.3 * exact, 1.7 * exact)
    return Spin(mark, exact, found, 1.0 / float(sticky @ arms**2), speed)


def torsion_onset(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Moment that starts a patch spinning against equation 7's τ*.

    The judged row of a curved test body uses the contact points. The array feels forces where they
    act, shared between neighbours: that widens a patch of few taxels by pitch² / 3 in the mean
    square of the distance, and equation 7 with it. The other row reports the gap.
    """
    rows, curves = [], {}
    chosen = ("plate on the whole proximal pad", "ball, r 40 mm") if short else tuple(SPUN)
    for name in chosen:
        link, at, shape, radius = SPUN[name]
        spin = spinning(link, at, shape, spoil)
        seventh = FRICTION * spin.mark.total * spin.mark.torsion_arm
        flat = np.isinf(radius)
        if flat:
            rows.append(Row(
                f"{name}: eq. 7, tactile array", "N m", seventh, spin.found, 0.02,
                "the last taxel has yielded 1 % beyond the limit; bisection 0.2 %",
            ))  # fmt: skip
        else:
            rows.append(Row(
                f"{name}: μ ΣN l, contact points", "N m", spin.exact, spin.found, 0.05,
                "few taxels: a slip of microns shifts load between them",
            ))  # fmt: skip
            arm = spin.exact / (FRICTION * spin.mark.total)
            rows.append(Row(
                f"{name}: eq. 7, tactile array", "N m", seventh, spin.found,
                1.0 - 1.0 / np.sqrt(1.0 + c.TAXEL_PITCH**2 / 3.0 / arm**2) + 0.05,
                "sharing between taxels widens the patch", judged=False,
            ))  # fmt: skip
        shares = np.array([0.3, 0.6, 0.8, 0.9, 0.97, 1.0, 1.03, 1.06, 1.1, 1.2, 1.5])
        speeds = np.array([spin.speed(x * seventh) for x in shares])
        curves[name] = (
            shares, speeds, spin.law * shares * seventh, spin.mark.forces, spin.found / seventh,
        )  # fmt: skip
    return Result(tuple(rows), curves)


# Pressed with [N], friction, and times the moment that starts it spinning.
OVERLOADS = ((10.0, FRICTION, 1.05), (10.0, FRICTION, 1.15), (20.0, FRICTION, 1.05),
             (10.0, 0.3, 1.05))  # fmt: skip
STEADY = 0.6  # until an overloaded patch spins evenly [s]


def torsion_overload(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """How fast a flat patch spins under a moment beyond equation 7's τ*.

    By Coulomb's law nothing but inertia would hold it back. In this contact model a contact that
    slips at a speed v presses harder by μ c v, with c its damping b / ((1 - d) A) against
    penetration: that keeps the tangential law a convex problem (regularised maximum dissipation
    allows slip only along the cone's normal). With the sum of the normal forces given, contacts
    far from the middle gain what those near it lose, so the moment grows with the spin ω by
    μ² c ω Σ (l - l̄)², l being distances from the middle and l̄ their mean.
    """
    rows = []
    for force, mu, share in OVERLOADS[:1] if short else OVERLOADS:
        pad, at, shape, _ = SPUN["plate on the whole proximal pad"]
        scene = bench(pad, *at, [shape], ["press", "twist"], settings_for(), mu, spoil)
        rest = pressed(scene, force)
        limit, resisted = spin_law(scene, touches(scene, rest), pad_frame(pad, *at), mu)
        data = copy(scene, rest)
        data.qfrc_applied[1] = share * limit
        advance(scene, data, STEADY)
        rows.append(Row(
            f"plate pressed with {force:g} N, μ {mu:g}: spins under {share:g} τ* at", "mrad/s",
            1e3 * (share - 1.0) * limit / resisted, 1e3 * float(data.qvel[1]), 0.01,
            "an even spin is reached to 0.1 %; Coulomb's law knows none",
        ))  # fmt: skip
    return Result(tuple(rows))


def spin_law(scene: Scene, touch: Touch, frame: Frame, mu: float) -> tuple[float, float]:
    """Moment that starts a flat patch spinning [N m], and how it grows with the spin [N m s]."""
    arms = np.linalg.norm(((touch.points - frame.position) @ frame.rotation)[:, 1:], axis=1)
    damping = stickiness(scene, touch.links) / scene.model.opt.impratio
    spread = float(damping @ (arms - arms.mean()) ** 2)
    return mu * float(touch.normal @ arms), mu**2 * spread


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
