"""Shapes of the KUKA KR5 sixx R850's links: castings, covers and flange, in metres.

Everything is in the base frame at the zero pose and lies inside the measured boxes of the links;
what the outlines look like within those boxes is own design.
"""

from __future__ import annotations

import math

import trimesh

from sdh_sim.modelgen.lofts import (
    cylinder,
    hull,
    loft_sections,
    rounded_box,
    rounded_rectangle,
    superellipse,
)

# A point on each joint's line [m]. Joint 4's lies between the links it joins.
JOINT_POINTS: tuple[tuple[float, float, float], ...] = (
    (0, 0, 0.335),
    (0.075, 0, 0.335),
    (0.075, 0, 0.700),
    (0.293, 0, 0.790),
    (0.480, 0, 0.790),
    (0.522, 0, 0.790),
)


def _disc(joint: int, y0: float, y1: float, radius: float, edge: float = 0.004) -> trimesh.Trimesh:
    """Cylinder about joint 2, 3 or 5 (counted from 1) between two y coordinates [m]."""
    x, _, z = JOINT_POINTS[joint - 1]
    return cylinder(radius, y0, y1, "y", (z, x), edge, n=40)


def _wrist_disc(x0: float, x1: float, radius: float, edge: float = 0.003) -> trimesh.Trimesh:
    """Cylinder about the line of joints 4 and 6 between two x coordinates [m]."""
    return cylinder(radius, x0, x1, "x", (0.0, 0.79), edge, n=40)


def _bolts(x: float, radius: float) -> list[trimesh.Trimesh]:
    """Seven screw heads on the flange circle, standing 1 mm out of the plane at x [m]."""
    angles = [math.radians(a) for a in (0, 45, 90, 135, 180, 225, 315)]
    at = [(radius * math.cos(a), 0.79 + radius * math.sin(a)) for a in angles]
    return [cylinder(0.0035, x - 0.002, x + 0.001, "x", c, n=12) for c in at]


def _forearm() -> trimesh.Trimesh:
    """Casting from the round bearing of joint 4 to the fork's root, along x."""
    stations = (
        (0.297, 0.0, 0.790, 0.052, 0.050, 2.0),
        (0.325, 0.0, 0.790, 0.052, 0.050, 2.0),
        (0.360, 0.003, 0.794, 0.058, 0.053, 2.6),
        (0.400, 0.0055, 0.795, 0.066, 0.053, 3.2),
        (0.425, 0.0055, 0.794, 0.069, 0.050, 3.6),
        (0.432, 0.0055, 0.793, 0.064, 0.044, 3.6),
    )
    outlines = [superellipse(u, v, 48, e, (y, z)) for _, y, z, u, v, e in stations]
    return loft_sections(outlines, [s[0] for s in stations], "x")


def link_solids() -> list[dict[str, list[trimesh.Trimesh]]]:
    """Closed solids of the base and the six links by material, in the base frame at zero [m]."""
    foot = rounded_box((-0.166, -0.108, 0), (0.108, 0.108, 0.032), 0.025, 0.005)
    socket = rounded_box((-0.166, -0.070, 0.03), (-0.05, 0.070, 0.150), 0.012, 0.008)
    radii = ((0.106, 0.03), (0.105, 0.06), (0.105, 0.095), (0.105, 0.105), (0.102, 0.102))
    outlines = [rounded_rectangle(h, h, r, 48) for h, r in radii]
    column = loft_sections(outlines, (0.028, 0.070, 0.130, 0.204, 0.209))
    plugs = [
        cylinder(0.016, -0.176, -0.160, "x", (y, 0.095), 0.002, n=24) for y in (-0.035, 0, 0.035)
    ]
    turret = cylinder(0.107, 0.212, 0.252, edge=0.010)
    shoulder = hull(
        cylinder(0.100, 0.245, 0.262, edge=0.008), _disc(2, -0.098, 0.040, 0.083, 0.014)
    )
    upper_arm = hull(_disc(2, 0.060, 0.126, 0.066, 0.014), _disc(3, 0.060, 0.122, 0.058, 0.014))
    elbow = hull(
        _disc(3, -0.080, 0.042, 0.071, 0.012),
        rounded_box((0.025, -0.068, 0.745), (0.215, 0.060, 0.842), 0.028, 0.018, "x"),
    )
    housing = hull(
        rounded_box((0.150, -0.060, 0.738), (0.230, 0.058, 0.840), 0.035, 0.010, "x"),
        _wrist_disc(0.265, 0.285, 0.052, 0.006),
    )
    forks = [
        hull(_disc(5, y0, y1, 0.043, 0.006), cylinder(0.040, y0, y1, "y", (0.793, 0.405), 0.006))
        for y0, y1 in ((0.0325, 0.0735), (-0.0645, -0.0325))
    ]
    ball = hull(_disc(5, -0.0285, 0.0285, 0.0385, 0.004), _wrist_disc(0.505, 0.520, 0.0285, 0.004))
    return [
        {"kr5_black": [foot, socket, column], "kr5_steel": plugs},
        {
            "kr5_orange": [turret, shoulder],
            "kr5_black": [_disc(2, -0.109, -0.095, 0.052), _disc(2, 0.038, 0.0485, 0.074)],
        },
        {
            "kr5_orange": [
                upper_arm,
                _disc(2, 0.050, 0.152, 0.086, 0.012),
                _disc(3, 0.050, 0.140, 0.074, 0.012),
            ],
            "kr5_black": [_disc(2, 0.148, 0.171, 0.060, 0.008), _disc(3, 0.136, 0.146, 0.048)],
        },
        {
            "kr5_orange": [elbow, housing],
            "kr5_black": [
                _disc(3, -0.089, -0.076, 0.048),
                _disc(3, 0.038, 0.0495, 0.064),
                _wrist_disc(0.283, 0.2925, 0.049),
            ],
        },
        {
            "kr5_orange": [_forearm(), *forks],
            "kr5_black": [_disc(5, 0.071, 0.0775, 0.030, 0.002), _disc(5, -0.0665, -0.062, 0.030)],
            "kr5_steel": [_wrist_disc(0.2932, 0.299, 0.047, 0.001)],
        },
        {"kr5_orange": [ball], "kr5_black": [_wrist_disc(0.515, 0.5225, 0.0275, 0.001)]},
        {
            "kr5_black": [_wrist_disc(0.523, 0.550, 0.032, 0.002)],
            "kr5_steel": [_wrist_disc(0.548, 0.559, 0.0315, 0.001), *_bolts(0.559, 0.0225)],
        },
    ]
