"""Shapes of the four grasp objects, in the object frames of the paper, in metres."""

from __future__ import annotations

import numpy as np
import trimesh

from sdh_sim.modelgen import lofts
from sdh_sim.modelgen.object_parts import (
    Array,
    Facts,
    Shape,
    Solid,
    Visual,
    box_solid,
    cylinder_solid,
    label,
    with_discs,
)

MM = 1e-3
# Drawn and outer surfaces have 64 sides (chord error 0.1 mm at the sharpest turn of the oval
# sections); what collides has 56 and few rows (0.2 mm): a sphere against it costs a third less.
SIDES, COLLISION_SIDES = 64, 56

CARTON = (0.90, 0.83, 0.70, 1.0)
PAPER = (0.96, 0.96, 0.93, 1.0)
TEAL = (0.05, 0.42, 0.45, 1.0)
AMBER = (0.95, 0.60, 0.12, 1.0)
INK = (0.16, 0.18, 0.22, 1.0)
GREEN = (0.16, 0.45, 0.27, 1.0)
LIME = (0.66, 0.80, 0.25, 1.0)
SKY = (0.13, 0.45, 0.78, 1.0)
WHITE = (0.95, 0.95, 0.95, 1.0)
RED = (0.80, 0.10, 0.10, 1.0)
PLUM = (0.36, 0.13, 0.38, 1.0)
STEEL = (0.62, 0.64, 0.67, 1.0)


def box(facts: Facts) -> Shape:
    """Carton: a box whose drawn edges are rounded by 1.5 mm, printed band and panels, y up."""
    low, high = np.array(facts.low), np.array(facts.high)
    rows = lofts.edge_rounding(low[1], high[1], 1.5 * MM)
    half, centre = (high - low) / 2, (high + low) / 2
    cuts = (low[1] + 0.052, low[1] + 0.056)

    def piece(bottom: float, top: float) -> trimesh.Trimesh:
        inside = [r for r in rows if bottom < r[1] < top]
        first = [(0.0, bottom)] if bottom > low[1] else rows[:1]
        last = [(0.0, top)] if top < high[1] else rows[-1:]
        kept = first + inside + last
        sections = [
            lofts.rounded_rectangle(
                half[2] - i, half[0] - i, max(1.5 * MM - i, 1e-4), 16, (centre[2], centre[0])
            )
            for i, _ in kept
        ]
        return lofts.loft_sections(sections, [w for _, w in kept], "y")

    visuals = [
        Visual("body", piece(cuts[1], high[1]), CARTON, 0.1),
        Visual("stripe", piece(cuts[0], cuts[1]), AMBER, 0.1),
        Visual("foot", piece(low[1], cuts[0]), TEAL, 0.1),
    ]
    eps = 5e-5

    def panel(x: float, sign: int, y: tuple[float, float], half_z: float) -> trimesh.Trimesh:
        outline = lofts.rounded_rectangle(
            (y[1] - y[0]) / 2, half_z, 0.012, 32, ((y[0] + y[1]) / 2, centre[2])
        )
        ends = sorted((x + sign * eps, x - sign * 1e-3))
        return lofts.loft_sections([outline] * 2, ends, "x")

    y0, y1 = low[1] + 0.072, high[1] - 0.022
    disc = lofts.superellipse(0.026, 0.026, 48, centre=((y0 + y1) / 2, centre[2]))
    for side, x, sign in (("front", high[0], 1), ("back", low[0], -1)):
        visuals.append(Visual(f"panel_{side}", panel(x, sign, (y0, y1), 0.052), PAPER, 0.1))
        ends = sorted((x + sign * 2 * eps, x - sign * 1e-3))
        mark = lofts.loft_sections([disc] * 2, ends, "x")
        visuals.append(Visual(f"mark_{side}", mark, AMBER, 0.1))
    seam = trimesh.creation.box(
        bounds=[
            (centre[0] - 0.0006, high[1] - 1e-3, low[2] + 0.002),
            (centre[0] + 0.0006, high[1] + eps, high[2] - 0.002),
        ]
    )
    visuals.append(Visual("seam", seam, INK, 0.1))
    return Shape(visuals, [box_solid("body", low, high)], _grid_box(low, high, 9 * MM))


def oval_bottle(facts: Facts) -> Shape:
    """Bottle of oval section: slightly barrelled body, domed shoulders, neck, screw cap, z up."""
    hx, hy, hz = facts.high
    shoulder, top, neck = 48 * MM, 101 * MM, 15 * MM

    def section_at(z: float, sides: int = SIDES) -> Array:
        barrel = 1.0 - 0.05 * ((z + 0.02) / 0.1) ** 2
        t = np.clip((z - shoulder) / (top - shoulder), 0.0, 1.0)
        dome = np.sqrt(max(1.0 - 0.965 * t**2, 0.0))
        heel = max(-hz + 7 * MM - z, 0.0) / (7 * MM)
        inset = 7 * MM * (1.0 - np.sqrt(max(1.0 - heel**2, 0.0)))
        u = neck + (hx - neck) * dome if t > 0 else hx
        v = neck + (hy - neck) * dome if t > 0 else hy
        barrel = barrel if t == 0 else barrel * (1 - t) + t * 0.98 * barrel
        return lofts.superellipse(u * barrel - inset, v * barrel - inset, sides, 2.2)

    def rows_of(heel: int, sides: np.ndarray, dome: int) -> Array:
        heel_rows = -hz + 7 * MM * (1.0 - np.cos(np.linspace(0.0, np.pi / 2, heel)))
        dome_rows = shoulder + (top - shoulder) * np.sin(np.linspace(0.0, np.pi / 2, dome))
        return np.concatenate((heel_rows, sides, dome_rows))

    rows = rows_of(6, np.arange(-12, 5) * 10 * MM, 12)
    few = rows_of(5, np.array([-91, -55, -20, 14]) * MM, 10)
    solid = lofts.loft_sections([section_at(z, COLLISION_SIDES) for z in few], few)
    body = lofts.loft_sections([section_at(z) for z in rows], rows)
    cap_low, cap_radius = 106 * MM, 17.5 * MM
    neck_mesh = lofts.cylinder(neck, 90 * MM, 110 * MM)
    cap = lofts.cylinder(cap_radius, cap_low, hz, edge=1.5 * MM, n=SIDES)
    visuals = [
        Visual("body", body, GREEN, 0.8),
        Visual("neck", neck_mesh, GREEN, 0.8),
        Visual("cap", cap, WHITE, 0.6),
        Visual("cap_ribs", _ribs(cap_radius, cap_low + 2 * MM, hz - 5 * MM, "z"), WHITE, 0.6),
    ]
    for side, middle in (("front", 0.0), ("back", 0.5)):
        paper = label(section_at, -95 * MM, 35 * MM, middle, 40 * MM, 10 * MM)
        band = label(section_at, -62 * MM, -36 * MM, middle, 40 * MM, 1 * MM, rise=1e-4)
        drop = label(section_at, -22 * MM, 16 * MM, middle, 19 * MM, 18.9 * MM, rise=1e-4)
        visuals += [
            Visual(f"label_{side}", paper, PAPER, 0.3),
            Visual(f"band_{side}", band, LIME, 0.3),
            Visual(f"mark_{side}", drop, GREEN, 0.3),
        ]
    solids = [
        Solid("body", solid),
        cylinder_solid("neck", neck, 80 * MM, 115 * MM),
        cylinder_solid("cap", cap_radius, cap_low, hz),
    ]
    around = np.concatenate((rows, [top, cap_low, cap_low, 114 * MM, 122 * MM, 130 * MM, hz]))
    outline = [section_at(z) for z in rows]
    outline += [lofts.superellipse(neck, neck, SIDES)] * 2
    outline += [lofts.superellipse(cap_radius, cap_radius, SIDES)] * 5
    return Shape(visuals, solids, with_discs(outline, around, 5 * MM))


def cylindrical_bottle(facts: Facts) -> Shape:
    """Round bottle along y: heel a little wider than the body, domed shoulder, wide cap, y up."""
    hx, hy, hz = facts.high
    radius, shoulder, top, cap_radius = hz, 50 * MM, 72 * MM, 19.5 * MM
    heel = np.array(  # y, half width along z, half width along x [mm]
        [
            (-hy / MM, 31.0, 31.0),
            (-104.5, 32.4, 32.5),
            (-103.0, 33.6, 33.8),
            (-100.5, 34.3, 34.55),
            (-97.0, hz / MM, hx / MM),
            (-90.0, hz / MM, 34.65),
            (-84.0, 33.8, 34.4),
            (-80.0, 33.0, 33.0),  # inside the body
        ]
    )
    heel_rows = [lofts.superellipse(z * MM, x * MM, SIDES) for _, z, x in heel]
    t = np.sin(np.linspace(0.0, np.pi / 2, 10))
    dome = cap_radius + (radius - cap_radius) * np.sqrt(1.0 - 0.99 * t**2)
    dome_y = shoulder + (top - shoulder) * t
    circle = [lofts.superellipse(r, r, SIDES) for r in dome]
    inside = lofts.superellipse(radius - 1.5 * MM, radius - 1.5 * MM, SIDES)
    heel_mesh = lofts.loft_sections(heel_rows, heel[:, 0] * MM, "y")
    dome_mesh = lofts.loft_sections([inside, *circle], [46 * MM, *dome_y], "y")
    cap_low = 75 * MM

    def round_at(_: float) -> Array:
        return lofts.superellipse(radius, radius, 128)

    visuals = [
        Visual("body", lofts.cylinder(radius, -95 * MM, shoulder, "y", n=128), WHITE, 0.7),
        Visual("heel", heel_mesh, WHITE, 0.7),
        Visual("shoulder", dome_mesh, WHITE, 0.7),
        Visual("neck", lofts.cylinder(18 * MM, 60 * MM, 90 * MM, "y"), STEEL, 0.7),
        Visual("cap", lofts.cylinder(cap_radius, cap_low, hy, "y", edge=1.5 * MM), PLUM, 0.6),
        Visual("cap_ribs", _ribs(cap_radius, cap_low + 2 * MM, hy - 8 * MM, "y"), PLUM, 0.6),
        Visual("label", _wrap(radius, -70 * MM, 30 * MM), PLUM, 0.4),
        Visual("label_stripe", _wrap(radius, -66 * MM, -61 * MM, 1e-4), AMBER, 0.4),
    ]
    for side, middle in (("front", 0.25), ("back", 0.75)):
        mark = label(round_at, -40 * MM, 12 * MM, middle, 22 * MM, 6 * MM, "y", rise=1e-4)
        visuals.append(Visual(f"mark_{side}", mark, PAPER, 0.4))
    solids = [
        cylinder_solid("body", radius, -92 * MM, shoulder + 2 * MM, "y"),
        Solid("heel", heel_mesh),
        Solid("shoulder", dome_mesh),
        cylinder_solid("cap", cap_radius, 65 * MM, hy, "y"),
    ]
    outline = [lofts.superellipse(z * MM, x * MM, 48) for _, z, x in heel[:6]]
    side_y = np.linspace(-82 * MM, shoulder, 22)
    cap_y = np.linspace(top + 5 * MM, hy, 6)
    outline += [lofts.superellipse(radius, radius, 48)] * len(side_y)
    outline += [lofts.superellipse(r, r, 48) for r in dome[1:]]
    outline += [lofts.superellipse(cap_radius, cap_radius, 48)] * len(cap_y)
    along = np.concatenate((heel[:6, 0] * MM, side_y, dome_y[1:], cap_y))
    return Shape(visuals, solids, with_discs(outline, along, 5 * MM, "y"))


def _wrap(radius: float, low: float, high: float, rise: float = 5e-5) -> trimesh.Trimesh:
    """Label all around a round bottle along y."""
    return lofts.cylinder(radius + rise, low, high, "y", n=128)


def _ribs(radius: float, low: float, high: float, axis: str, count: int = 40) -> trimesh.Trimesh:
    """Grip ribs of a screw cap, 0.25 mm proud of it: drawn only."""
    angles = np.arange(count) * 2 * np.pi / count
    centres = (radius - 0.3 * MM) * np.column_stack((np.cos(angles), np.sin(angles)))
    return lofts.combine(
        *(lofts.cylinder(0.55 * MM, low, high, axis, c, edge=0.3 * MM, n=8) for c in centres)
    )


def _grid_box(low: Array, high: Array, pitch: float) -> trimesh.Trimesh:
    """Closed box with a grid of vertices about `pitch` apart on every face."""
    count = np.ceil((high - low) / pitch).astype(int)
    vertices: dict[tuple[int, ...], int] = {}
    faces = []

    def index(node: np.ndarray) -> int:
        return vertices.setdefault(tuple(int(i) for i in node), len(vertices))

    for axis in range(3):
        u, v = np.roll(np.eye(3, dtype=int), -axis, axis=0)[1:]
        for side in (0, 1):
            for i in range(count[(axis + 1) % 3]):
                for j in range(count[(axis + 2) % 3]):
                    start = i * u + j * v + side * count[axis] * np.eye(3, dtype=int)[axis]
                    a, b, c, d = (index(start + s) for s in (0 * u, u, u + v, v))
                    quad = (a, b, c, d) if side else (d, c, b, a)
                    faces += [quad[:3], (quad[0], *quad[2:])]
    points = low + (high - low) * np.array(list(vertices)) / count
    return trimesh.Trimesh(points, np.array(faces), process=False)
