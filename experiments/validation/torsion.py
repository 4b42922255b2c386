"""Checks of torsion: where a patch starts to spin, and how fast one spins that is overloaded."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from experiments.validation.friction import (
    FRICTION,
    MIDDLE,
    PLATE,
    PRESS,
    speed_under,
    stickiness,
)
from experiments.validation.result_rows import Result, Row, threshold
from experiments.validation.rig_readings import (
    Imprint,
    Touch,
    advance,
    copy,
    imprint,
    pressed,
    touches,
)
from experiments.validation.rigs import (
    HONEST,
    Frame,
    Shape,
    Spoil,
    bench,
    pad_frame,
    set_friction,
    settings_for,
)
from sdh_sim.cell import Scene
from sdh_sim.robot import Hand
from sdh_sim.robot import sdh2_constants as c
from sdh_sim.trial.lift import HOLD_TIME, LIFT_TIME
from sdh_sim.trial.outcome import MAX_ROTATION_DEG

SPIN_FACTOR = 2.0  # times the creep speed at which the innermost taxel of a patch yields

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
        return speed_under(scene, rest, load)

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
    for name in () if short else SPUN:
        rows.append(Row(
            f"{name}: moment over τ* that turns it by 10° within lift and hold", "", 1.0,
            _lost(name, spoil), 0.35, "large patches spin slowly, on which 10° wait for a third",
            judged=False,
        ))  # fmt: skip
    return Result(tuple(rows))


def _lost(name: str, spoil: Spoil) -> float:
    """Moment over τ* of the contact points under which a patch turns too far for a trial."""
    pad, at, shape, _ = SPUN[name]
    scene = bench(pad, *at, [shape], ["press", "twist"], settings_for(), FRICTION, spoil)
    rest = pressed(scene, PRESS)
    limit, _ = spin_law(scene, touches(scene, rest), pad_frame(pad, *at), FRICTION)

    def turns(share: float) -> bool:
        data = copy(scene, rest)
        data.qfrc_applied[1] = share * limit
        advance(scene, data, LIFT_TIME + HOLD_TIME)
        return abs(float(data.qpos[1])) > np.radians(MAX_ROTATION_DEG)

    return threshold(turns, 0.8, 2.0)


def spin_law(scene: Scene, touch: Touch, frame: Frame, mu: float) -> tuple[float, float]:
    """Moment that starts a flat patch spinning [N m], and how it grows with the spin [N m s]."""
    arms = np.linalg.norm(((touch.points - frame.position) @ frame.rotation)[:, 1:], axis=1)
    damping = stickiness(scene, touch.links) / scene.model.opt.impratio
    spread = float(damping @ (arms - arms.mean()) ** 2)
    return mu * float(touch.normal @ arms), mu**2 * spread
