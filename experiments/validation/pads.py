"""Checks of the pads' rubber: stiffness of a taxel, patch and pressure of a ball, modulus, recoil.

A pad is an elastic foundation (Winkler bed) of modulus k = E / thickness [N/m³]: a ball of radius
r pressed by F sinks by δ = (F / (π k r))^½ over a patch of area 2 π r δ, with the peak pressure
k δ. Taxels are spheres of radius R whose apexes lie on the pad, so what the bed meets is a ball
of radius r + R. Spheres touch the ball nearer to its axis than their apexes lie, by the share
r / (r + R), and there the array feels their force: its patch is that much narrower than the bed's,
and wider by what sharing between two neighbours adds, pitch² / 6 to the variance along each axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from experiments.validation.forces import from_limits
from experiments.validation.friction import CLAMP_ANGLES, CLAMP_PUSH, PLATE, clamp_rig
from experiments.validation.result_rows import Result, Row
from experiments.validation.rig_engine import MUJOCO, RigEngine
from experiments.validation.rig_readings import advance, pressed
from experiments.validation.rigs import (
    HONEST,
    TAXEL_RADIUS,
    TEST_BODY_MASS,
    Shape,
    Spoil,
    bench,
    settings_for,
)
from sdh_sim.cell.scene_builder import PAD_IMPEDANCE, taxel_stiffness
from sdh_sim.robot import sdh2_constants as c

PAD = "finger1_proximal"
TAXEL_AREA = c.TAXEL_PITCH**2
TOUCHED = 1e-6  # [N] on a taxel that counts as touched


def bed(force: float, radius: float, modulus: float = 1e6) -> tuple[float, float, float]:
    """Sinking [m], patch area [m²] and peak pressure [Pa] of a ball on an elastic foundation."""
    k = modulus / settings_for().pad_thickness
    depth = math.sqrt(force / (math.pi * k * radius))
    return depth, 2.0 * math.pi * radius * depth, k * depth


def counting_error(area: float, offsets: int) -> float:
    """Three times the rms share by which counted taxels miss a disc's area.

    Points of a square lattice in a disc of radius ρ lattice constants number π ρ² with an rms
    error of 0.82 ρ^½; ``offsets`` places of the disc along each side of a taxel refine the lattice
    by that factor.
    """
    rho = offsets * math.sqrt(area / math.pi) / c.TAXEL_PITCH
    return 3.0 * 0.82 * math.sqrt(rho) / (math.pi * rho**2)


def plate(short: bool = False, spoil: Spoil = HONEST, engine: RigEngine = MUJOCO) -> Result:
    """A plate over a whole proximal pad: sinks by F / (84 K), all taxels alike, nothing lost."""
    rows, points = [], []
    for force, modulus in ((10.0, 1e6),) if short else ((2.0, 1e6), (10.0, 1e6), (40.0, 5e6)):
        settings = settings_for(modulus=modulus)
        scene = bench(PAD, 6.5, 2.5, [PLATE], ["press"], settings, 0.5, spoil)
        rest = engine.pressed(scene, force)
        mark = rest.imprint(PAD)
        depth = force / (84 * taxel_stiffness(settings, c.TAXEL_PITCH))
        rows += [
            Row(f"plate, {force:g} N, {modulus / 1e6:g} MPa: sinks by", "µm", 1e6 * depth,
                1e6 * rest.pressed_in, 0.005, "exact by construction; taxels alike"),
            Row(f"plate, {force:g} N, {modulus / 1e6:g} MPa: taxels sum to", "N", force,
                mark.total, 0.001, "at rest; all normals are those of the plate"),
        ]  # fmt: skip
        points.append((force, depth, rest.pressed_in))
    return Result(tuple(rows), {"points": np.array(points)})


@dataclass(frozen=True)
class Balls:
    """A ball pressed at several places within a taxel.

    Attributes:
        area: of the patch, the mean over places [m²].
        peak: pressure under a ball right over a taxel [Pa].
        profile: distance from the ball's axis [m] and pressure [Pa] of every sphere touched, over
            all places (n, 2).
        forces: of the spheres at the last place, rows × columns [N].
        width: root mean square distance from the centre of pressure along an axis, as the array
            reads it, over all places [m].
        off: largest distance of the array's centre of pressure from the ball's axis [m].
    """

    area: float
    peak: float
    profile: np.ndarray
    forces: np.ndarray
    width: float
    off: float


def read_width(force: float, radius: float, modulus: float = 1e6) -> float:
    """What ``Balls.width`` is on the bed that the spheres make [m]."""
    depth, _, _ = bed(force, radius + TAXEL_RADIUS, modulus)
    narrower = radius / (radius + TAXEL_RADIUS)
    # Pressure falls as 1 - (ρ / a)², a² = 2 (r + R) δ: the variance along an axis is a² / 6.
    own = (radius + TAXEL_RADIUS) * depth / 3.0
    return math.sqrt(narrower**2 * own + c.TAXEL_PITCH**2 / 6.0)


def _balls(
    radius: float, force: float, modulus: float, offsets: int, spoil: Spoil,
    engine: RigEngine = MUJOCO,
) -> Balls:  # fmt: skip
    """A ball pressed at several places within a taxel.

    The mean over places measures the area finer than one taxel; the peak is that of a ball right
    over a taxel.
    """
    settings = settings_for(modulus=modulus)
    places = (np.arange(offsets) + 0.5) / offsets - 0.5
    shape = Shape("sphere", (radius,), (radius, 0.0, 0.0))
    counts, profile, peak, forces = [], [], 0.0, np.zeros(0)
    variances, off = [], 0.0
    for row, column in [*((6.5 + i, 2.5 + j) for i in places for j in places), (6.0, 2.0)]:
        scene = bench(PAD, row, column, [shape], ["press"], settings, 0.0, spoil)
        rest = engine.pressed(scene, force)
        forces, read = rest.sphere_forces(PAD), rest.imprint(PAD).forces
        for axis, place in ((1, row), (0, column)):
            line, at = read.sum(axis=axis) / read.sum(), np.arange(read.shape[1 - axis])
            off = max(off, c.TAXEL_PITCH * abs(line @ at - place))
            variances.append(c.TAXEL_PITCH**2 * (line @ at**2 - (line @ at) ** 2))
        rows, columns = np.nonzero(forces > TOUCHED)
        distance = c.TAXEL_PITCH * np.hypot(rows - row, columns - column)
        profile.append(np.column_stack([distance, forces[rows, columns] / TAXEL_AREA]))
        if (row, column) == (6.0, 2.0):
            peak = float(forces.max()) / TAXEL_AREA
        else:
            counts.append(len(rows))
    return Balls(
        float(np.mean(counts)) * TAXEL_AREA, peak, np.concatenate(profile), forces,
        math.sqrt(float(np.mean(variances))), off,
    )  # fmt: skip


def ball(short: bool = False, spoil: Spoil = HONEST, engine: RigEngine = MUJOCO) -> Result:
    """Patch area and peak pressure of a ball pressed into a flat pad."""
    rows, curves = [], []
    offsets = 2 if short else 4
    for radius, force in ((0.02, 10.0),) if short else ((0.02, 10.0), (0.02, 3.0), (0.05, 10.0)):
        balls = _balls(radius, force, 1e6, offsets, spoil, engine)
        area, peak = balls.area, balls.peak
        name = f"ball, r {1e3 * radius:g} mm, {force:g} N"
        _, exact_area, exact_peak = bed(force, radius + TAXEL_RADIUS)
        _, ideal_area, ideal_peak = bed(force, radius)
        share = math.sqrt(1.0 + TAXEL_RADIUS / radius) - 1.0
        edge = counting_error(exact_area, offsets)
        rows += [
            Row(f"{name}: patch area, bed under r + R", "mm²", 1e6 * exact_area, 1e6 * area,
                edge, f"three times the error of counting taxels, {offsets} places a side"),
            Row(f"{name}: peak pressure, bed under r + R", "kPa", 1e-3 * exact_peak, 1e-3 * peak,
                0.05, "sum over taxels for an integral; outer taxels are smaller spheres"),
            Row(f"{name}: patch area, ideal bed", "mm²", 1e6 * ideal_area, 1e6 * area,
                share + edge, "taxel spheres of 13 mm: area up by (1 + R/r)^½", judged=False),
            Row(f"{name}: peak pressure, ideal bed", "kPa", 1e-3 * ideal_peak, 1e-3 * peak,
                share / (1.0 + share) + 0.05, "peak down by (1 + R/r)^½", judged=False),
            Row(f"{name}: rms width that the array reads", "mm", 1e3 * read_width(force, radius),
                1e3 * balls.width, 0.1, "sum over few taxels, at least five, for an integral"),
            Row(f"{name}: rms width, ideal bed", "mm",
                1e3 * math.sqrt(radius * bed(force, radius)[0] / 3.0), 1e3 * balls.width, 0.25,
                "narrower by r / (r + R), wider by sharing", judged=False),
            Row(f"{name}: centre of pressure off the ball", "mm", 0.0, 1e3 * balls.off, 0.1,
                "of a pitch: the guided ball leans on few taxels", scale=1e3 * c.TAXEL_PITCH),
        ]  # fmt: skip
        curves.append((radius, force, balls.profile, balls.forces))
    return Result(tuple(rows), {"balls": curves})


def modulus(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Softer rubber: patch area grows as E^-½, the force that motors can hold does not change."""
    rows, curves = [], []
    moduli = (0.5e6, 4e6) if short else (0.25e6, 0.5e6, 1e6, 2e6, 4e6)
    offsets, radius, force = 2 if short else 4, 0.04, 10.0
    areas = [_balls(radius, force, e, offsets, spoil).area for e in moduli]
    torque = 1.6401
    held = []
    for e in moduli:
        scene = clamp_rig((torque, 1.0934), spoil, modulus=e)
        held.append(from_limits(MUJOCO.squeezed(scene, CLAMP_ANGLES, CLAMP_PUSH), torque))
    exact = [bed(force, radius + TAXEL_RADIUS, e)[1] for e in (moduli[0], moduli[-1])]
    limit = math.hypot(*(counting_error(area, offsets) for area in exact))
    rows.append(Row(
        f"patch at {moduli[0] / 1e6:g} MPa over that at {moduli[-1] / 1e6:g} MPa", "",
        math.sqrt(moduli[-1] / moduli[0]), areas[0] / areas[-1], limit,
        "three times the error of counting taxels in either patch",
    ))  # fmt: skip
    for e, area, (predicted, total) in zip(moduli, areas, held, strict=True):
        rows.append(Row(
            f"held force at {e / 1e6:g} MPa", "N", predicted, total, 0.01,
            "τ̄ over the lever; centre of pressure to 1 mm on a lever of 113 mm",
        ))  # fmt: skip
        curves.append((e, area, predicted, total))
    return Result(tuple(rows), {"points": np.array(curves), "radius": radius, "force": force})


def recoil(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """A pressed plate let go: how fast the pad throws it off.

    A contact of solref (-k, -2 k^½) moves a light test body as a critically damped spring of rate
    k^½:
    let go at a depth δ it leaves at δ k^½ / e. Rubber would be far faster, (84 K / m)^½ instead of
    k^½; of the energy stored the pad gives back next to nothing, so it cannot kick an object.
    """
    scene = bench(PAD, 6.5, 2.5, [PLATE], ["press"], settings_for(), 0.5, spoil)
    force, settings = 20.0, scene.settings
    data = pressed(scene, force)
    data.qfrc_applied[0] = 0.0
    advance(scene, data, 1.0)
    speed = float(data.qvel[0])
    stiffness = taxel_stiffness(settings, c.TAXEL_PITCH)
    depth = force / (84 * stiffness)
    a = scene.model.body_invweight0[scene.object_body, 0]
    rate = math.sqrt(stiffness * (1.0 - PAD_IMPEDANCE) * a)
    rows = (
        Row("speed of a plate thrown off by a pad", "µm/s", 1e6 * depth * rate / math.e,
            1e6 * speed, 1.0 - PAD_IMPEDANCE, "damping and rate are right to 1 - d"),
        Row("energy given back of that stored", "mJ", 0.0, 5e2 * TEST_BODY_MASS * speed**2,
            math.exp(-2.0), "a critically damped spring gives back e^-2 at most",
            scale=5e2 * force * depth),
    )  # fmt: skip
    return Result(rows)
