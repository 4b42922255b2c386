"""Closed surfaces: parts that touch are told apart, open pieces joined, corners welded."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sdh_sim.errors import MeshError
from sdh_sim.objects.closed_surfaces import Surfaces, find_surfaces
from tests.support.object_files import block

SIZE = (0.02, 0.03, 0.05)
# A second block beside the one at the origin: what they share, and by how much it is shifted.
SHARED = {
    "a corner": (1, 1, 1),
    "an edge": (1, 1, 0),
    "a face": (1, 0, 0),
    "nothing": (2, 0, 0),
}


def triangles(*meshes: trimesh.Trimesh) -> list[tuple[np.ndarray, np.ndarray]]:
    """Meshes as one piece of a file that shares no corners, as STL has it."""
    corners = np.concatenate([np.asarray(mesh.triangles) for mesh in meshes])
    corners = np.round(corners, 9)  # corners at one place are so to the last bit
    return [(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))]


def volumes(found: Surfaces) -> list[float]:
    return [trimesh.Trimesh(*part, process=False).volume for part in found.closed]


@pytest.mark.parametrize("shared", SHARED)
@pytest.mark.parametrize("order", ["one after the other", "mixed"])
def test_blocks_that_touch_are_two(shared, order):
    shift = np.multiply(SHARED[shared], SIZE)
    [(vertices, faces)] = triangles(block(size=SIZE), block(shift, SIZE))
    if order == "mixed":
        faces = np.random.default_rng(3).permutation(faces)
    found = find_surfaces([(vertices, faces)])
    assert volumes(found) == pytest.approx([np.prod(SIZE)] * 2)
    middles = [0.5 * np.ptp(part[0], axis=0) + part[0].min(axis=0) for part in found.closed]
    middles.sort(key=np.linalg.norm)
    assert np.array(middles) == pytest.approx(np.array([np.zeros(3), shift]), abs=1e-8)
    assert (found.open, found.joined, found.weld) == (None, 0, 0.0)


def test_parts_that_overlap_and_share_an_edge_are_told_apart_by_their_order():
    # Two blocks with the edge x = y = 0 in common, the second turned about it by 30 degrees: going
    # round the edge, one begins within the other.
    first = block(0.5 * np.array(SIZE), SIZE)
    second = first.copy()
    second.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 6, [0, 0, 1]))
    assert volumes(find_surfaces(triangles(first, second))) == pytest.approx([np.prod(SIZE)] * 2)


def test_sixty_four_blocks_of_a_wall_are_sixty_four():
    places = np.stack(np.meshgrid(*[range(4)] * 3), axis=-1).reshape(-1, 3)
    wall = [block(place * SIZE, SIZE) for place in places]
    assert volumes(find_surfaces(triangles(*wall))) == pytest.approx([np.prod(SIZE)] * 64)
    with pytest.raises(MeshError, match="at most 64 are taken"):
        find_surfaces(triangles(*wall, block((1, 1, 1), SIZE)))


def test_one_solid_that_touches_itself_stays_one():
    # Three sides of a square, whose ends touch the fourth along an edge: a ring, not two parts.
    ring = trimesh.creation.annulus(0.02, 0.04, 0.1, sections=8)
    assert len(find_surfaces(triangles(ring)).closed) == 1


def test_pieces_open_alone_and_closed_together_are_one():
    body = block(size=SIZE)
    lid = np.isin(np.arange(12), np.flatnonzero(body.face_normals[:, 2] > 0.5))
    pieces = [(np.array(body.vertices), np.array(body.faces[rows])) for rows in (~lid, lid)]
    found = find_surfaces(pieces)
    assert volumes(found) == pytest.approx([np.prod(SIZE)])
    assert (found.joined, found.open) == (2, None)
    # A closed block between them stays a part of its own, in the order of the file.
    other = triangles(block((0.1, 0, 0), SIZE))
    found = find_surfaces([pieces[0], *other, pieces[1]])
    assert [round(part[0][:, 0].mean(), 3) for part in found.closed] == [0.0, 0.1]


@pytest.mark.parametrize(("noise", "closes"), [(1e-8, True), (3e-7, True), (1e-4, False)])
def test_corners_are_welded_within_a_tolerance_tied_to_the_size(noise, closes):
    [(vertices, faces)] = triangles(block(size=SIZE))
    rng = np.random.default_rng(1)
    for scale in (1.0, 1000.0):  # the same in any unit
        moved = scale * (vertices + rng.uniform(-noise, noise, vertices.shape))
        found = find_surfaces([(moved, faces)])
        assert (found.open is None) == closes
        if closes:
            assert volumes(found) == pytest.approx([scale**3 * np.prod(SIZE)], rel=1e-4)
            assert 0.0 < found.weld < scale * 8 * noise


def test_parts_nearer_than_the_tolerance_are_not_welded():
    # A gap of a micrometre: exact corners need no weld, so nothing is joined.
    found = find_surfaces(triangles(block(size=SIZE), block((SIZE[0] + 1e-6, 0, 0), SIZE)))
    assert volumes(found) == pytest.approx([np.prod(SIZE)] * 2)
    assert found.weld == 0.0


def test_what_nothing_closes_is_left():
    mesh = block(size=SIZE)
    found = find_surfaces([(np.array(mesh.vertices), np.array(mesh.faces[:11]))])
    assert found.closed == []
    assert found.open is not None
    assert len(found.open[1]) == 11
    # A soup of points far nearer to each other than the tolerance is no reason to weld them all.
    rng = np.random.default_rng(0)
    soup = np.concatenate((rng.normal(size=(999, 3)) * 1e-6, [[1, 1, 1.0], [1, 0, 0], [0, 1, 0]]))
    found = find_surfaces([(soup, np.arange(1002).reshape(-1, 3))])
    assert found.open is not None
    assert len(found.open[1]) == 334
