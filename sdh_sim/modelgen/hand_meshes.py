"""Meshes of the SDH-2's bodies, lofted from a table of outlines (millimetres, link frames).

Outlines are convex hulls of circles: a corner is a small circle, a straight side the tangent of
two. Insetting such an outline is subtracting from the radii, which rounds edges for free.
Measured outlines: proximal box x ±12, y ±13.9, z 12..79; axles of radius 14; distal front at
x = 12 under a pad whose surface is flat to z = 33.2 and then an arc of radius 63.90 about
(-49.05, 33.17); straight back from (-12.74, 12) to (-7.18, 64.9); nose up to 68.5; knuckle disc
of radius 22.4 with cheeks y -19.75..26.45; palm as the hull of circles about the finger bases.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh

from sdh_sim.modelgen.lofts import (
    Array,
    combine,
    cylinder,
    edge_rounding,
    hull,
    loft_sections,
    superellipse,
)

MM = 1e-3
Circles = Sequence[tuple[float, float, float]]  # (u, v, radius)

ARC_CENTRE, ARC_RADIUS = (-49.05, 33.17), 63.90
PAD_THICKNESS = 3.0  # rubber over the structure; the structure's front is at x = 12


def outline(circles: Circles, n: int = 72, inset: float = 0.0) -> Array:
    """Hull of circles as n points, one for each direction of the outward normal, (n, 2)."""
    table = np.asarray(circles, dtype=float)
    radii = np.maximum(table[:, 2] - inset, 0.05)
    angle = 2 * np.pi * np.arange(n) / n
    normals = np.column_stack((np.cos(angle), np.sin(angle)))
    support = normals @ table[:, :2].T + radii
    best = support.argmax(axis=1)
    return table[best, :2] + radii[best, None] * normals


def prism(xz: Circles, y: tuple[float, float], edge: float, n: int = 72) -> trimesh.Trimesh:
    """Prism along y of an outline given in (x, z), its end edges rounded; millimetres in."""
    zx = [(z, x, r) for x, z, r in xz]
    rows = edge_rounding(y[0], y[1], edge)
    sections = [outline(zx, n, inset) * MM for inset, _ in rows]
    return loft_sections(sections, [w * MM for _, w in rows], "y")


def _arc(depth: float, z0: float, z1: float, radius: float, n: int = 9) -> list:
    """Circles whose outer side follows the distal pad's arc at a depth below its surface."""
    (cx, cz), r = ARC_CENTRE, ARC_RADIUS - depth - radius
    a = np.linspace(np.arcsin((z0 - cz) / ARC_RADIUS), np.arcsin((z1 - cz) / ARC_RADIUS), n)
    return [(cx + r * np.cos(t), cz + r * np.sin(t), radius) for t in a]


def _distal_profile(corner: float) -> list:
    return [
        (12.0 - corner, 14.0, corner),
        *_arc(PAD_THICKNESS - 0.15, 33.2, 60.0, corner, 7),
        (-2.3, 63.5, 5.0),  # nose
        (-12.74 + corner, 12.0 + corner, corner),
        (0.0, 6.0, 6.0),
    ]


def _palm() -> trimesh.Trimesh:
    lower = [(-38.0, 0.0, 19.0), (23.2, 33.0, 23.8), (23.2, -33.0, 23.8)]
    upper = [(-38.11, 0.0, 27.9), (19.05, 33.0, 28.0), (19.05, -33.0, 28.0)]
    rows = [(14.0, lower, 4.0), (15.2, lower, 1.2), (18.0, lower, 0.0), (22.0, lower, 0.0)]
    rows += [
        (22 + 20 * s, [tuple(np.add(np.multiply(a, 1 - s), np.multiply(b, s)))
                       for a, b in zip(lower, upper, strict=True)], 0.0)
        for s in (0.25, 0.5, 0.75, 1.0)
    ]  # fmt: skip
    rows += [(70.3 + 4.0 * np.sin(t), upper, 4.0 * (1 - np.cos(t))) for t in
             np.linspace(0.0, np.pi / 2, 5)]  # fmt: skip
    sections = [outline(circles, 96, inset) * MM for _, circles, inset in rows]
    return loft_sections(sections, [z * MM for z, _, _ in rows], "z")


def _palm_core() -> trimesh.Trimesh:
    """Few-vertex convex body just inside the palm's outline, for contacts."""
    upper = [(-38.11, 0.0, 27.9), (19.05, 33.0, 28.0), (19.05, -33.0, 28.0)]
    ring = outline(upper, 24)
    low = np.column_stack((ring * 0.93, np.full(len(ring), 14.0)))
    mid = np.column_stack((ring, np.full(len(ring), 42.0)))
    top = np.column_stack((ring, np.full(len(ring), 74.3)))
    return hull(np.concatenate((low, mid, top)) * MM)


def _knuckle() -> trimesh.Trimesh:
    foot, dome = [(-10.0, 4.0, 2.0), (10.0, 4.0, 2.0)], [(0.0, 16.5, 14.0)]
    disc = cylinder(22.4 * MM, -0.2 * MM, 5.0 * MM, edge=1.0 * MM)
    inner = prism(foot + dome, (-19.75, -14.2), 1.2)
    outer = prism(foot + dome, (14.2, 26.45), 2.0)
    block = prism([(-8.0, 4.0, 2.0), (8.0, 4.0, 2.0), (0.0, 8.0, 2.0)], (-15.0, 15.0), 0.5)
    return combine(disc, inner, outer, block)


def _proximal() -> trimesh.Trimesh:
    corners = [(x, z, 3.0) for x in (-9.0, 9.0) for z in (15.0, 76.0)]
    link = prism(corners, (-13.9, 13.9), 2.5)
    axle = cylinder(14.0 * MM, -13.9 * MM, 13.9 * MM, "y", edge=1.2 * MM)
    neck = prism([(-8.5, 8.0, 2.0), (8.5, 8.0, 2.0), (-8.5, 20.0, 2.0), (8.5, 20.0, 2.0)],
                 (-11.0, 11.0), 1.0)  # fmt: skip
    fork = [(-8.0, 74.0, 2.0), (8.0, 74.0, 2.0), (0.0, 86.5, 9.5)]
    left, right = prism(fork, (-15.4, -13.9), 0.5), prism(fork, (13.9, 15.4), 0.5)
    return combine(link, axle, neck, left, right)


def _distal() -> trimesh.Trimesh:
    link = prism(_distal_profile(2.5), (-13.9, 13.9), 3.5)
    axle = cylinder(14.0 * MM, -13.85 * MM, 13.85 * MM, "y", edge=1.2 * MM)
    return combine(link, axle)


def _distal_core() -> trimesh.Trimesh:
    profile = outline([(x, z, r) for x, z, r in _distal_profile(1.0)], 20)
    sides = [np.insert(profile, 1, y, axis=1) for y in (-13.0, 13.0)]
    return hull(np.concatenate(sides) * MM)


def _proximal_pad() -> trimesh.Trimesh:
    corners = [(x, z, 1.0) for x in (11.0, 14.29) for z in (19.75, 66.75)]
    return prism(corners, (-12.0, 12.0), 0.9)


def _distal_pad() -> trimesh.Trimesh:
    surface = [(13.85, 19.93, 1.0), *_arc(0.0, 33.2, 66.0, 1.0, 9)]
    back = [(9.0, 20.0, 1.0), (0.5, 62.5, 1.0)]
    return prism(surface + back, (-11.0, 11.0), 0.9)


def hand_meshes() -> dict[str, trimesh.Trimesh]:
    """All meshes of the hand by name [m], deterministic."""
    ring = superellipse(34.0 * MM, 34.0 * MM, 64)
    boss = loft_sections([ring * 0.97, ring, ring], [-7.5 * MM, -6.5 * MM, 16.0 * MM])
    plate_outline = [(-38.11, 0.0, 23.5), (19.05, 33.0, 23.5), (19.05, -33.0, 23.5)]
    plate = loft_sections(
        [outline(plate_outline, 96) * MM, outline(plate_outline, 96, 0.4) * MM],
        [73.0 * MM, 74.7 * MM],
    )
    return {
        "palm": _palm(),
        "palm_plate": combine(plate, boss),
        "palm_core": _palm_core(),
        "knuckle": _knuckle(),
        "proximal": _proximal(),
        "proximal_pad": _proximal_pad(),
        "distal": _distal(),
        "distal_pad": _distal_pad(),
        "distal_core": _distal_core(),
    }
