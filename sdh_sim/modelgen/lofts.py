"""Closed triangle meshes from cross-sections: lofts, revolutions, rounded boxes and hulls.

Lengths in metres. A section is an (n, 2) outline, counter-clockwise, in the plane across an axis.
The axis is named "x", "y" or "z" and coordinates (u, v, w) = (section, section, along the axis)
are laid out cyclically: z gives (u, v, w), x gives (w, u, v), y gives (v, w, u). So a section's
(u, v) are (x, y) for axis z, (y, z) for axis x and (z, x) for axis y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import trimesh

Array = npt.NDArray[np.float64]

_SHIFT = {"z": 0, "x": 1, "y": 2}


def superellipse(
    half_u: float,
    half_v: float,
    n: int = 64,
    exponent: float = 2.0,
    centre: npt.ArrayLike = (0.0, 0.0),
) -> Array:
    """Outline |u/half_u|^e + |v/half_v|^e = 1 in n equal steps of arc length, shape (n, 2) [m].

    Exponent 2 is an ellipse; 3 to 5 look like moulded plastic. n is a multiple of 4, so that the
    four extreme points are always vertices and the extents are exact.
    """
    if n % 4:
        raise ValueError(f"n = {n} must be a multiple of 4, so that the extreme points are kept")
    theta = np.linspace(0.0, np.pi / 2, 32 * n + 1)
    u = half_u * np.cos(theta) ** (2.0 / exponent)
    v = half_v * np.sin(theta) ** (2.0 / exponent)
    u[-1] = v[0] = 0.0
    arc = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(u), np.diff(v)))))
    s = np.linspace(0.0, arc[-1], n // 4 + 1)
    return _four_quadrants(np.interp(s, arc, u), np.interp(s, arc, v)) + np.asarray(centre)


def rounded_rectangle(
    half_u: float,
    half_v: float,
    radius: float,
    n: int = 64,
    centre: npt.ArrayLike = (0.0, 0.0),
) -> Array:
    """Outline of a rectangle with corner arcs of n/4 points each, shape (n, 2) [m].

    The sides themselves carry no vertices, so n can be small (8 is a bevelled rectangle).
    """
    if n % 4 or n < 8:
        raise ValueError(f"n = {n} must be a multiple of 4 and at least 8: n/4 points per corner")
    radius = min(radius, half_u, half_v)
    theta = np.linspace(0.0, np.pi / 2, n // 4)
    corners = []
    for quarter, (su, sv) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = theta + quarter * np.pi / 2
        u = su * (half_u - radius) + radius * np.cos(angle)
        v = sv * (half_v - radius) + radius * np.sin(angle)
        corners.append(np.column_stack((u, v)))
    return np.concatenate(corners) + np.asarray(centre)


def place(section: Array, along: float, axis: str = "z") -> Array:
    """Ring of the section (n, 2) at the coordinate `along` of the axis, shape (n, 3) [m]."""
    ring = np.column_stack((section, np.full(len(section), along)))
    return np.roll(ring, _shift(axis), axis=1)


def loft(rings: Sequence[Array] | Array) -> trimesh.Trimesh:
    """Closed mesh through m rings of n points each, (m, n, 3) [m], the ends closed by fans.

    Rings run counter-clockwise about the direction of travel; corresponding points are joined.
    Raises ValueError for rings of unequal length or a surface that encloses no positive volume.
    """
    if len({np.shape(r) for r in rings}) != 1:
        raise ValueError(f"rings of shapes {[np.shape(r) for r in rings]}: want one shape (n, 3)")
    points = np.asarray(rings, dtype=float)
    m, n, _ = points.shape
    here = np.arange(n)
    after = np.roll(here, -1)
    faces = []
    for i in range(m - 1):
        a, b, c, d = i * n + here, i * n + after, (i + 1) * n + after, (i + 1) * n + here
        faces += [np.column_stack((a, b, c)), np.column_stack((a, c, d))]
    bottom, top = m * n, m * n + 1
    faces.append(np.column_stack((after, here, np.full(n, bottom))))
    last = (m - 1) * n
    faces.append(np.column_stack((last + here, last + after, np.full(n, top))))
    vertices = np.concatenate((points.reshape(-1, 3), [points[0].mean(0), points[-1].mean(0)]))
    mesh = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
    if not mesh.volume > 0.0:
        raise ValueError("the loft is inside out: order sections by increasing axis coordinate")
    return mesh


def loft_sections(
    sections: Sequence[Array], along: Sequence[float] | npt.NDArray, axis: str = "z"
) -> trimesh.Trimesh:
    """Closed loft of sections (n, 2) at increasing coordinates of an axis [m]."""
    return loft([place(s, w, axis) for s, w in zip(sections, along, strict=True)])


def revolve(
    profile: Sequence[Sequence[float]] | Array,
    n: int = 64,
    axis: str = "z",
    centre: npt.ArrayLike = (0.0, 0.0),
) -> trimesh.Trimesh:
    """Solid of revolution; profile (k, 2) of (radius, coordinate along the axis) upwards [m].

    `centre` is where the axis passes in section coordinates (u, v).
    """
    profile = np.asarray(profile, dtype=float)
    sections = [superellipse(r, r, n, centre=centre) for r in profile[:, 0]]
    return loft_sections(sections, profile[:, 1], axis)


def edge_rounding(
    start: float, stop: float, radius: float, steps: int = 4
) -> list[tuple[float, float]]:
    """Rows (inset, coordinate) that round both end edges of a prism from start to stop [m].

    Shrink the section by each row's inset and place it at its coordinate: a quarter circle of the
    given radius at either end.
    """
    radius = min(radius, 0.499 * (stop - start))
    angle = np.linspace(0.0, np.pi / 2, steps + 1)
    inset = radius * (1.0 - np.sin(angle))
    rise = radius * (1.0 - np.cos(angle))
    low = [(float(i), float(start + r)) for i, r in zip(inset, rise, strict=True)]
    return low + [(i, float(stop - (w - start))) for i, w in reversed(low)]


def cylinder(
    radius: float,
    start: float,
    stop: float,
    axis: str = "z",
    centre: npt.ArrayLike = (0.0, 0.0),
    edge: float = 0.0,
    n: int = 48,
) -> trimesh.Trimesh:
    """Cylinder along an axis from start to stop with end edges rounded by `edge` [m]."""
    rows = edge_rounding(start, stop, edge) if edge > 0 else [(0.0, start), (0.0, stop)]
    return revolve([(radius - inset, w) for inset, w in rows], n, axis, centre)


def rounded_box(
    low: Sequence[float],
    high: Sequence[float],
    corner: float,
    edge: float = 0.0,
    axis: str = "z",
    n: int = 32,
) -> trimesh.Trimesh:
    """Box between two corners; edges along the axis rounded by `corner`, others by `edge` [m]."""
    lo = np.roll(np.asarray(low, dtype=float), -_shift(axis))
    hi = np.roll(np.asarray(high, dtype=float), -_shift(axis))
    (hu, hv), centre = (hi[:2] - lo[:2]) / 2, (hi[:2] + lo[:2]) / 2
    rows = edge_rounding(lo[2], hi[2], edge) if edge > 0 else [(0.0, lo[2]), (0.0, hi[2])]
    sections = [
        rounded_rectangle(hu - i, hv - i, max(corner - i, 1e-4), n, centre) for i, _ in rows
    ]
    return loft_sections(sections, [w for _, w in rows], axis)


def hull(*shapes: trimesh.Trimesh | Array) -> trimesh.Trimesh:
    """Convex hull of meshes and points (k, 3) together."""
    points = [s.vertices if isinstance(s, trimesh.Trimesh) else np.asarray(s) for s in shapes]
    return trimesh.convex.convex_hull(np.concatenate(points))


def combine(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    """One mesh of several closed surfaces, for drawing (overlaps stay: not for volumes)."""
    offsets = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    faces = [m.faces + offset for m, offset in zip(meshes, offsets, strict=True)]
    vertices = np.concatenate([m.vertices for m in meshes])
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)


def solid_inertia(mesh: trimesh.Trimesh, mass: float) -> tuple[Array, Array]:
    """Centroid (3,) [m] and inertia (3, 3) about it [kg m²] of a homogeneous closed solid.

    Axes are the mesh's. Raises ValueError when the surface is not closed: it has no volume.
    """
    if not mesh.is_watertight or mesh.volume <= 0.0:
        raise ValueError("inertia needs a closed surface with outward faces")
    scale = mass / mesh.volume
    return np.array(mesh.center_mass), np.array(mesh.moment_inertia) * scale


def write_obj(path: Path, mesh: trimesh.Trimesh, decimals: int = 6) -> None:
    """Write vertices [m] and triangles as Wavefront OBJ, in the mesh's own order."""
    lines = [f"v {_tidy(v, decimals)}" for v in mesh.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in np.asarray(mesh.faces) + 1]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


def write_model(
    folder: Path, texts: Mapping[str, str], meshes: Mapping[str, trimesh.Trimesh]
) -> None:
    """Write text files by their names, and ``assets/NAME.obj``, into a folder, creating it."""
    for name, mesh in meshes.items():
        write_obj(folder / "assets" / f"{name}.obj", mesh)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def _four_quadrants(u: Array, v: Array) -> Array:
    """Full outline from its first quadrant, both axis points included in the input."""
    first = np.column_stack((u, v))
    half = np.concatenate((first, (first * (-1, 1))[::-1][1:]))
    return np.concatenate((half, -half[1:-1]))


def _shift(axis: str) -> int:
    if axis not in _SHIFT:
        raise ValueError(f'axis = {axis!r}: want one of "x", "y", "z"')
    return _SHIFT[axis]


def _tidy(vector: Array, decimals: int) -> str:
    """Numbers without negative zeros and without trailing zeros."""
    return " ".join(
        f"{x + 0.0:.{decimals}f}".rstrip("0").rstrip(".") for x in vector.round(decimals)
    )
