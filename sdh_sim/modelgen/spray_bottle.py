"""Shape of the spray bottle: oval body, waist to grip, collar, trigger head; z up, in metres."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from trimesh import Trimesh as Mesh

from sdh_sim.modelgen import lofts
from sdh_sim.modelgen.object_parts import (
    Array,
    Facts,
    Shape,
    Solid,
    Visual,
    cylinder_solid,
    label,
)
from sdh_sim.modelgen.object_shapes import (
    AMBER,
    COLLISION_SIDES,
    INK,
    MM,
    PAPER,
    RED,
    SIDES,
    SKY,
    WHITE,
)
from sdh_sim.modelgen.surface_nets import union_surface

# Heights [m] where the barrelled body starts to close, where its outline turns from convex to
# concave, where the waist is narrowest and where the collar begins.
CLOSING, TURN, WAIST, COLLAR = -48 * MM, -14 * MM, 36 * MM, 62 * MM
WAIST_HALF = (15.5 * MM, 19.0 * MM)
WAIST_SEGMENTS = 7  # chord error of the waist outline 0.2 mm
HEEL = 6 * MM
COLLAR_RADIUS = 19.0 * MM

# The head's side view (y, z) [mm], counter-clockwise and convex: the nozzle is towards +y.
SHROUD = np.array(
    [(-13, 82), (13, 82), (26, 92), (37, 97), (38.5, 101), (38.5, 111), (36, 115), (8, 121.5),
     (-4, 122.15), (-16, 122.15), (-23, 120), (-27.5, 115.5), (-29, 108), (-26.5, 98), (-20, 88)]
)  # fmt: skip
# Middle line of the trigger lever (y, z), and its half thickness and half width at each point [mm].
TRIGGER = np.array(
    [(27.0, 95.0, 5.0, 7.5), (31.0, 82.0, 3.6, 7.0), (31.5, 69.0, 3.3, 6.5), (36.5, 54.0, 3.0, 6.0)]
)


def spray_bottle(facts: Facts) -> Shape:
    """Spray bottle; its collision solids are convex pieces, outer is the union of finer ones."""
    hx, hy, hz = facts.high

    def half_width(z: float, full: float, waist: float) -> float:
        slope = 2.0 * (full - waist) / (WAIST - CLOSING)
        if z < CLOSING:
            heel = max(-hz + HEEL - z, 0.0) / HEEL
            barrel = full * (1.0 - 0.03 * ((z - CLOSING) / (hz + CLOSING)) ** 2)
            return barrel - HEEL * (1.0 - np.sqrt(max(1.0 - heel**2, 0.0)))
        if z < TURN:
            return full - 0.5 * slope * (z - CLOSING) ** 2 / (TURN - CLOSING)
        return waist + 0.5 * slope * (WAIST - z) ** 2 / (WAIST - TURN)

    def section_at(z: float, inset: float = 0.0, sides: int = SIDES) -> Array:
        exponent = 2.0 + 0.5 * np.clip((WAIST - z) / (WAIST - CLOSING), 0.0, 1.0)
        u = half_width(z, hx, WAIST_HALF[0]) - inset
        return lofts.superellipse(u, half_width(z, hy, WAIST_HALF[1]) - inset, sides, exponent)

    def coarse(z: float, inset: float = 0.0) -> Array:
        return section_at(z, inset, COLLISION_SIDES)

    def body_rows(heel: int, sides: int, turn: int) -> Array:
        heel_rows = -hz + HEEL * (1.0 - np.cos(np.linspace(0.0, np.pi / 2, heel)))
        side_rows = np.linspace(-hz + HEEL, CLOSING, sides)[1:]
        return np.concatenate((heel_rows, side_rows, np.linspace(CLOSING, TURN, turn)[1:]))

    waist_rows = np.linspace(TURN, COLLAR, WAIST_SEGMENTS + 1)
    fine_body, fine_waist = body_rows(6, 7, 8), np.linspace(TURN, COLLAR, 25)
    fine_rows = np.concatenate((fine_body, fine_waist[1:]))
    body = _piece(section_at, fine_rows)

    solids = [Solid("body", _piece(coarse, body_rows(5, 3, 6)))]
    for i, (a, b) in enumerate(pairwise(waist_rows)):
        solids.append(Solid(f"waist_{i}", _piece(coarse, [a, b])))
    solids.append(cylinder_solid("collar", COLLAR_RADIUS, COLLAR - 2 * MM, 77 * MM))
    solids.append(cylinder_solid("neck", 13.5 * MM, 70 * MM, 90 * MM))
    shroud = _shroud()
    solids.append(Solid("head", lofts.hull(shroud)))
    nozzle = {"radius": 7.5 * MM, "start": 30 * MM, "stop": hy, "axis": "y"}
    nozzle_centre = (106 * MM, 0.0)
    solids.append(cylinder_solid("nozzle", **nozzle, centre=nozzle_centre))
    knuckles = [_knuckle(*row) for row in TRIGGER]
    for i, (a, b) in enumerate(pairwise(knuckles)):
        solids.append(Solid(f"trigger_{i}", lofts.hull(a, b)))

    ribs = 36
    angles = np.arange(ribs) * 2 * np.pi / ribs
    rib_centres = (COLLAR_RADIUS - 0.3 * MM) * np.column_stack((np.cos(angles), np.sin(angles)))
    rib_mesh = lofts.combine(
        *(lofts.cylinder(0.6 * MM, COLLAR + 2 * MM, 75 * MM, "z", c, n=8) for c in rib_centres)
    )
    visuals = [
        Visual("body", body, SKY, 0.8),
        Visual("collar", lofts.cylinder(COLLAR_RADIUS, COLLAR, 77 * MM, edge=1 * MM), WHITE),
        Visual("collar_ribs", rib_mesh, WHITE),
        Visual("collar_neck", lofts.cylinder(13.5 * MM, 70 * MM, 86 * MM), WHITE),
        Visual("head", shroud, WHITE),
        Visual("nozzle", lofts.cylinder(**nozzle, centre=nozzle_centre, edge=0.8 * MM), RED),
        Visual(
            "orifice",
            lofts.cylinder(1.6 * MM, 40 * MM, hy + 5e-5, "y", nozzle_centre, n=16),
            INK,
        ),
        Visual("trigger", _trigger(), RED),
    ]
    for side, middle in (("front", 0.0), ("back", 0.5)):
        paper = label(section_at, -103 * MM, -36 * MM, middle, 36 * MM, 8 * MM)
        band = label(section_at, -96 * MM, -84 * MM, middle, 30 * MM, 2 * MM, rise=1e-4)
        mark = label(section_at, -76 * MM, -44 * MM, middle, 16 * MM, 15.9 * MM, rise=1e-4)
        visuals += [
            Visual(f"label_{side}", paper, PAPER, 0.3),
            Visual(f"band_{side}", band, RED, 0.3),
            Visual(f"mark_{side}", mark, AMBER, 0.3),
        ]
    outer = [_piece(section_at, fine_body)]
    outer += [_piece(section_at, pair) for pair in pairwise(fine_waist)]
    outer += [s.mesh for s in solids if s.name != "body" and not s.name.startswith("waist")]
    return Shape(visuals, solids, union_surface(outer, 4.3 * MM))


def _piece(section_at, rows) -> Mesh:
    """Convex piece of the bottle, ends drawn in by a bevel that lies inside its neighbours.

    The outlines of two neighbours coincide exactly at their common height; past it each goes on
    inside the other, so that no gap and no free edge is left there.
    """
    sections, heights = [section_at(z) for z in rows], list(rows)
    if rows[0] > CLOSING:
        sections.insert(0, section_at(rows[0], 4 * MM))
        heights.insert(0, rows[0] - 2 * MM)
    sections.append(section_at(rows[-1], 4 * MM))
    heights.append(rows[-1] + 2 * MM)
    return lofts.loft_sections(sections, heights)


def _shroud() -> Mesh:
    """The head: its side view drawn 13 mm to either side, the rim rounded by 4 mm."""
    centre = SHROUD.mean(0)
    rows = lofts.edge_rounding(-13 * MM, 13 * MM, 4 * MM)
    sections = [MM * (centre + (SHROUD - centre) * (1.0 - i / (22 * MM))) for i, _ in rows]
    return lofts.loft_sections(sections, [w for _, w in rows], "x")


def _knuckle(y: float, z: float, thickness: float, width: float) -> Mesh:
    """Short rounded roll across the lever at one point of its middle line, arguments in mm."""
    centre = (y * MM, z * MM)
    return lofts.cylinder(thickness * MM, -width * MM, width * MM, "x", centre, edge=1.5 * MM, n=24)


def _trigger() -> Mesh:
    """The lever as one smooth loft along its middle line."""
    t = np.linspace(0.0, 1.0, 25)
    knots = np.linspace(0.0, 1.0, len(TRIGGER))
    line = np.column_stack([np.interp(t, knots, TRIGGER[:, i]) for i in range(4)])
    window = np.ones(7) / 7
    smooth = np.column_stack(
        [np.convolve(np.pad(column, 3, "edge"), window, "valid") for column in line.T]
    )
    smooth[[0, -1]] = line[[0, -1]]
    smooth *= MM
    tangent = np.gradient(smooth[:, :2], axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    rings = []
    for (y, z, thickness, width), (ty, tz) in zip(smooth, tangent, strict=True):
        outline = lofts.superellipse(width, thickness, 32, 3.0)
        normal = np.array([0.0, tz, -ty])
        rings.append(
            np.array([0.0, y, z]) + outline[:, :1] * np.array([1.0, 0, 0]) + outline[:, 1:] * normal
        )
    return lofts.loft(rings)
