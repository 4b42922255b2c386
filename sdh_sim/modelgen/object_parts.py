"""What an object model is made of: the facts of the paper, coloured parts, collision solids."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import trimesh

from sdh_sim.modelgen import lofts

Array = npt.NDArray[np.float64]
SectionAt = Callable[[float], Array]


@dataclass(frozen=True)
class Facts:
    """Measured properties of one object, in its own frame (Krug et al. 2017, public data).

    mass: [kg]; friction: Coulomb coefficient; com: centre of mass (3,) [m];
    low, high: corners of the bounding box (3,) [m]; up: axis that points up when it stands.
    """

    mass: float
    friction: float
    com: tuple[float, float, float]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    up: str


@dataclass(frozen=True)
class Visual:
    """A coloured part that is drawn only: mesh [m], colour r g b a, shininess 0..1."""

    name: str
    mesh: trimesh.Trimesh
    rgba: tuple[float, float, float, float]
    shininess: float = 0.5


@dataclass(frozen=True)
class Solid:
    """A collision solid: a convex mesh [m], or the primitive it stands for as MJCF attributes."""

    name: str
    mesh: trimesh.Trimesh
    primitive: str = ""


@dataclass(frozen=True)
class Shape:
    """Everything drawn, everything touched, and the closed outer surface of an object."""

    visuals: Sequence[Visual]
    solids: Sequence[Solid]
    outer: trimesh.Trimesh


def box_solid(name: str, low: npt.ArrayLike, high: npt.ArrayLike) -> Solid:
    """Box primitive between two corners [m]."""
    low_, high_ = np.asarray(low), np.asarray(high)
    mesh = trimesh.creation.box(bounds=[low_, high_])
    size, pos = (high_ - low_) / 2, (high_ + low_) / 2
    return Solid(name, mesh, f'type="box" size="{numbers(size)}" pos="{numbers(pos)}"')


def cylinder_solid(
    name: str, radius: float, start: float, stop: float, axis: str = "z", centre=(0.0, 0.0)
) -> Solid:
    """Cylinder primitive along an axis from start to stop [m]; the mesh has 64 sides."""
    mesh = lofts.cylinder(radius, start, stop, axis, centre, n=64)
    ends = [lofts.place(np.array([centre]), w, axis)[0] for w in (start, stop)]
    fromto = numbers(np.concatenate(ends))
    return Solid(name, mesh, f'type="cylinder" size="{numbers([radius])}" fromto="{fromto}"')


def numbers(values: npt.ArrayLike, digits: int = 8) -> str:
    """MJCF list of numbers with the given significant digits, without negative zeros."""
    return " ".join(f"{v + 0.0:.{digits}g}" for v in np.atleast_1d(np.asarray(values, dtype=float)))


def with_discs(
    sections: Sequence[Array], along: Sequence[float] | Array, pitch: float, axis: str = "z"
) -> trimesh.Trimesh:
    """Loft whose flat ends carry concentric rings about `pitch` apart instead of long slivers."""

    def shrunk(section: Array) -> list[Array]:
        centre = section.mean(0)
        count = max(2, round(np.linalg.norm(section - centre, axis=1).min() / pitch))
        return [centre + (section - centre) * i / count for i in range(1, count)]

    start, stop = shrunk(sections[0]), shrunk(sections[-1])[::-1]
    rows = [*start, *sections, *stop]
    heights = [along[0]] * len(start) + list(along) + [along[-1]] * len(stop)
    return lofts.loft_sections(rows, heights, axis)


def label(
    section_at: SectionAt,
    low: float,
    high: float,
    middle: float,
    half_arc: float,
    corner: float,
    axis: str = "z",
    rise: float = 5e-5,
) -> trimesh.Trimesh:
    """Sticker that follows a lofted surface, `rise` proud of it and 1 mm deep: drawn only.

    section_at(w): outline (n, 2) [m] at the axis coordinate w; low, high: its ends [m];
    middle: where along the outline, as a fraction of its length from the first point;
    half_arc: half its width along the outline [m]; corner: radius of its corners [m].
    """
    rows = lofts.edge_rounding(low, high, corner, steps=6)
    middle_rows = np.linspace(low + corner, high - corner, 13)[1:-1]
    rows = rows[:7] + [(0.0, float(w)) for w in middle_rows] + rows[7:]
    # A column on every corner of the outline: a chord past one would dive below the surface.
    _, offsets = _unrolled(section_at((low + high) / 2), middle)
    corners = np.argsort(offsets)
    corners = corners[np.abs(offsets[corners]) < half_arc]
    rings = []
    for inset, w in rows:
        outline = section_at(w)
        normals, offsets = _unrolled(outline, middle)
        half = half_arc - inset
        s = np.concatenate(([-half], np.clip(offsets[corners], -half, half), [half]))
        order = np.argsort(offsets)
        line, outward = (
            np.column_stack([np.interp(s, offsets[order], a[order, i]) for i in range(2)])
            for a in (outline, normals)
        )
        strip = np.concatenate((line + rise * outward, (line - 1e-3 * outward)[::-1]))
        rings.append(lofts.place(strip, w, axis))
    return lofts.loft(rings)


def _unrolled(outline: Array, middle: float) -> tuple[Array, Array]:
    """Outward unit normals (n, 2), arc offsets (n,) from the middle [m]."""
    tangent = np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0)
    normals = np.column_stack((tangent[:, 1], -tangent[:, 0]))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    steps = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    length = float(steps.sum())
    arc = np.cumsum(steps) - steps
    return normals, (arc - middle * length + length / 2) % length - length / 2
