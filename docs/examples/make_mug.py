"""Writes mug/mug.obj: a mug as closed convex parts, in millimetres, standing on z = 0.

    python docs/examples/make_mug.py

The body is a filled cylinder, which touches the hand as a hollow one would, since MuJoCo collides
convex hulls. The handle, which is not convex, is seven wedges along an arc.
"""

from __future__ import annotations

import math
from pathlib import Path

SIDES = 48
PROFILE = ((36.0, 0.0), (40.0, 4.0), (40.0, 95.0))  # radius, height
ARC = (40.0, 50.0)  # centre of the handle in x and z
INNER, OUTER, HALF_WIDTH = 22.0, 30.0, 6.0
SEGMENTS, REACH = 7, 110.0  # over so many degrees to either side of the x axis

Part = tuple[list[tuple[float, ...]], list[tuple[int, ...]]]


def body() -> Part:
    """A turned solid; its faces seen from outside, counterclockwise."""
    points = [
        (r * math.cos(a), r * math.sin(a), z)
        for r, z in PROFILE
        for a in (2 * math.pi * k / SIDES for k in range(SIDES))
    ]
    faces: list[tuple[int, ...]] = []
    for ring in range(len(PROFILE) - 1):
        for k in range(SIDES):
            a, b = ring * SIDES + k, ring * SIDES + (k + 1) % SIDES
            faces += [(a, b, b + SIDES), (a, b + SIDES, a + SIDES)]
    top = (len(PROFILE) - 1) * SIDES
    for k in range(1, SIDES - 1):
        faces += [(0, k + 1, k), (top, top + k, top + k + 1)]
    return points, faces


def wedge(start: float, end: float) -> Part:
    """A piece of the handle between two angles [deg]."""
    points = []
    for angle in (math.radians(start), math.radians(end)):
        for radius in (INNER, OUTER):
            for y in (-HALF_WIDTH, HALF_WIDTH):
                x, z = radius * math.cos(angle), radius * math.sin(angle)
                points.append((ARC[0] + x, y, ARC[1] + z))
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return points, [face for a, b, c, d in quads for face in ((a, c, b), (a, d, c))]


def obj() -> str:
    """The mug as OBJ, one object for each part."""
    step = 2 * REACH / SEGMENTS
    parts = {"body": body()}
    for k in range(SEGMENTS):
        parts[f"handle_{k}"] = wedge(k * step - REACH, (k + 1) * step - REACH)
    lines, before = [], 1
    for name, (points, faces) in parts.items():
        lines.append(f"o {name}")
        lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in points]
        lines += [f"f {a + before} {b + before} {c + before}" for a, b, c in faces]
        before += len(points)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    path = Path(__file__).parent / "mug" / "mug.obj"
    path.write_text(obj(), encoding="ascii", newline="\n")
    print(path)
