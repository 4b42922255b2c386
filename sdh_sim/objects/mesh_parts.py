"""The convex parts of a mesh, and why a mesh cannot be divided into them.

MuJoCo collides the convex hull of a mesh. So a shape that is not convex comes as several closed
convex parts in one file (what tools for convex decomposition write), is decomposed or replaced by
its hull where the user asks for that, or is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sdh_sim.errors import MeshError
from sdh_sim.objects.closed_surfaces import find_surfaces
from sdh_sim.objects.convex_decomposition import decomposed
from sdh_sim.user_files.mesh_limits import MAX_PARTS, MeshPiece

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

HULL_RATIO = 1.05  # a hull of up to so many times the volume counts as the mesh itself


@dataclass(frozen=True)
class Part:
    """One closed surface that collides as its convex hull.

    Attributes:
        vertices: (n, 3) [m].
        faces: corners of the triangles (m, 3).
        volume: enclosed, negative where the surface is inside out [m^3].
        hull_volume: of the convex hull [m^3].
    """

    vertices: np.ndarray
    faces: np.ndarray
    volume: float
    hull_volume: float


@dataclass(frozen=True)
class Parts:
    """What a mesh became.

    Attributes:
        parts: at least one.
        notes: what was done to get there, for the user.
        whole: the mesh is one part as it is in the file.
        replaced: surfaces of the file were replaced by hulls or by what CoACD made of them.
        decomposed: CoACD made some of the parts.
    """

    parts: list[Part]
    notes: tuple[str, ...]
    whole: bool = False
    replaced: bool = False
    decomposed: bool = False


def parts_of(pieces: Sequence[MeshPiece], hull: bool = False, decompose: bool = False) -> Parts:
    """The parts of a mesh, each closed, outward and, without ``hull``, convex.

    Args:
        pieces: vertices (n, 3) [m] and triangles (m, 3) of each.
        hull: what is not closed or not convex is replaced by its hull.
        decompose: it is decomposed into convex parts instead.

    Raises:
        MeshError: the mesh has no such parts, or more than are taken.
    """
    surfaces = find_surfaces(list(pieces))
    notes = []
    if surfaces.joined:
        notes.append(f"{surfaces.joined} open pieces joined")
    if surfaces.weld > 0.0:
        notes.append(f"corners up to {1e6 * surfaces.weld:.2g} µm apart welded")
    if hull or decompose:
        parts = _each(lambda surface: _part(*surface), surfaces.closed)
        parts, cavities = _without_cavities(parts)
        notes += [f"{cavities} inner cavities left out"] if cavities else []
    else:
        parts = [_part(*surface) for surface in surfaces.closed]
    if not parts and surfaces.open is None:
        raise MeshError("holds no triangle with an area, or is flat")
    if surfaces.open is None:
        loose = []
    elif not hull and not decompose:
        raise MeshError(_not_closed(surfaces.open[0], len(parts) + 1))
    else:
        loose = [surfaces.open]
    if decompose:
        return _decomposed(parts, loose, notes)
    if not hull:
        _check_solid(parts)
        return Parts(parts, tuple(notes), whole=len(parts) == 1 and not surfaces.weld)
    inverted = [part for part in parts if part.volume <= 0.0]
    surfaces_left = [*loose, *((part.vertices, part.faces) for part in inverted)]
    hulls = _each(lambda surface: _part(*hull_of(surface[0])), surfaces_left)
    found = [part for part in parts if part.volume > 0.0] + hulls
    if not found:
        raise MeshError("is flat; give it a thickness")
    if hulls:
        notes.append("not closed: mass distribution from the hull")
    whole = len(found) == 1 and not hulls and not surfaces.weld
    return Parts(found, tuple(notes), whole, replaced=bool(hulls))


def hull_ratio(parts: Sequence[Part]) -> float:
    """Volume of the parts' convex hulls over the volume of the parts; 1 where all are convex."""
    return sum(p.hull_volume for p in parts) / sum(p.volume for p in parts)


def _part(vertices: np.ndarray, faces: np.ndarray) -> Part:
    """A closed surface, vertices (n, 3) [m], triangles (m, 3), with its volumes."""
    a, b, c = (vertices - vertices[0])[faces].swapaxes(0, 1)
    volume = float((a * np.cross(b, c)).sum()) / 6.0  # of tetrahedra over a common corner
    return Part(vertices, faces, volume, _qhull(vertices).volume)


def _qhull(vertices: np.ndarray) -> ConvexHull:
    """The convex hull of points (n, 3); raises MeshError where they lie in a plane."""
    from scipy.spatial import (  # a fifth of a second, which most processes do not need
        ConvexHull,
        QhullError,
    )

    try:
        return ConvexHull(vertices)
    except (QhullError, ValueError) as error:
        raise MeshError("has a part that is flat; remove it or give it a thickness") from error


def hull_of(vertices: np.ndarray) -> MeshPiece:
    """The convex hull of points (n, 3) as a mesh with its triangles outward."""
    hull = _qhull(vertices)
    used, index = np.unique(hull.simplices, return_inverse=True)
    corners, faces = vertices[used], index.reshape(-1, 3)
    a, b, c = corners[faces].swapaxes(0, 1)
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0.0
    faces[inward] = faces[inward, ::-1]
    return corners, faces


def _without_cavities(parts: list[Part]) -> tuple[list[Part], int]:
    """The parts but for those inside out within the box of another, and the number of these."""
    boxes = [(p.vertices.min(axis=0), p.vertices.max(axis=0)) for p in parts if p.volume > 0.0]

    def is_cavity(part: Part) -> bool:
        low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
        inside = [(low >= below).all() and (high <= above).all() for below, above in boxes]
        return part.volume <= 0.0 and any(inside)

    found = [part for part in parts if not is_cavity(part)]
    return found, len(parts) - len(found)


def _decomposed(parts: list[Part], loose: list[MeshPiece], notes: list[str]) -> Parts:
    """The parts with what is open, inside out or not convex decomposed.

    Args:
        parts: closed surfaces.
        loose: surfaces that are not closed.
        notes: so far.
    """
    found = []
    rest = loose
    for part in parts:
        if part.volume > 0.0 and part.hull_volume <= HULL_RATIO * part.volume:
            found.append(part)
        else:
            rest = [*rest, (part.vertices, part.faces)]
    computed = [piece for surface in rest for piece in decomposed(*surface)]
    found += _each(lambda piece: _part(*hull_of(piece[0])), computed)
    if len(found) > MAX_PARTS:
        raise MeshError(f"is decomposed into {len(found)} parts; at most {MAX_PARTS} are taken")
    if not found:
        raise MeshError("is decomposed into nothing that has a volume")
    if rest:
        notes = [*notes, "decomposed by CoACD, mass distribution from the convex parts"]
    return Parts(found, tuple(notes), replaced=bool(rest), decomposed=bool(rest))


def _each(make: Callable[[MeshPiece], Part], pieces: list[MeshPiece]) -> list[Part]:
    """A part of each piece that is not flat: what is flat has neither volume nor hull."""
    found = []
    for piece in pieces:
        try:
            found.append(make(piece))
        except MeshError:
            continue
    return found


def _check_solid(parts: list[Part]) -> None:
    """Raise MeshError unless every part is outward and convex."""
    for number, part in enumerate(parts):
        if part.volume <= 0.0:
            raise MeshError(
                f"is inside out{_which(parts, number)}: its volume is {part.volume:.3g} m³; flip "
                "the triangles, or leave the surface of an inner cavity out"
            )
    ratios = [part.hull_volume / part.volume for part in parts]
    worst = int(np.argmax(ratios))
    if ratios[worst] > HULL_RATIO:
        raise MeshError(
            f"is not convex{_which(parts, worst)}: its hull has {ratios[worst]:.3g} times its "
            "volume, and MuJoCo collides the hull; divide it into closed convex parts in the same "
            "file, let CoACD do so with decompose = true, or accept the hull with hull = true"
        )


def _not_closed(vertices: np.ndarray, parts: int) -> str:
    """The message for what no tolerance closes, vertices (n, 3) [m]; ``parts`` in all."""
    centre = ", ".join(f"{v:.4g}" for v in 0.5 * (vertices.min(axis=0) + vertices.max(axis=0)))
    which = f" around {centre} m" if parts > 1 else ""
    return (
        f"is not watertight{which}: it has a hole, or triangles that are turned or meet three at "
        "an edge; repair it in a mesh editor, or take its hull with hull = true"
    )


def _which(parts: list[Part], number: int) -> str:
    """Names a part by its place in space: files order and name parts in many ways."""
    if len(parts) == 1:
        return ""
    centre = ", ".join(f"{v:.4g}" for v in parts[number].vertices.mean(axis=0))
    return f" (the one of {len(parts)} parts around {centre} m)"
