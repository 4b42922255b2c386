"""Colours of OBJ files: drawn where they can be read, and of no effect on the object."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sdh_sim.objects import user_object
from tests.support.object_files import BLOCK_INERTIA, FACTS, block, info_of, object_folder

GREY = (0.55, 0.62, 0.7, 1.0)


def coloured(tmp_path: Path, library: str | None, facts: str = FACTS) -> Path:
    """The block as OBJ: ten triangles of the material ``body``, two of ``lid``; and its MTL."""
    mesh = block()
    lines = ["mtllib block.mtl"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.vertices]
    faces = [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces]
    lines += ["usemtl body", *faces[:10], "usemtl lid", *faces[10:]]
    path = object_folder(tmp_path, "\n".join(lines) + "\n", facts, ending="obj")
    if library is not None:
        (path / "block.mtl").write_text(library)
    return path


def drawn(path: Path) -> dict[tuple[float, ...], int]:
    """Number of drawn triangles by colour."""
    model = user_object(path).spec.compile()
    found: dict[tuple[float, ...], int] = {}
    for geom in np.flatnonzero(model.geom_contype == 0):
        colour = tuple(np.round(model.mat_rgba[model.geom_matid[geom]].astype(float), 6))
        found[colour] = found.get(colour, 0) + int(model.mesh_facenum[model.geom_dataid[geom]])
    return found


def test_materials_are_drawn_in_their_colours(tmp_path):
    library = "newmtl body\nKd 1 0 0\nnewmtl lid\nKd 0 0.5 1\nmap_Kd ../../secret.png\n"
    path = coloured(tmp_path, library)
    assert drawn(path) == {(1.0, 0.0, 0.0, 1.0): 10, (0.0, 0.5, 1.0, 1.0): 2}
    assert "textures left out" in user_object(path).reference.notes
    assert info_of(path).inertia_kgm2 == pytest.approx(BLOCK_INERTIA, abs=1e-9)
    scaled = coloured(tmp_path / "b", library, FACTS + "scale = 0.5")
    model = user_object(scaled).spec.compile()
    assert np.ptp(model.mesh_vert, axis=0).max() == pytest.approx(0.06, abs=1e-6)


def test_a_colour_is_no_part_of_the_object(tmp_path):
    before = user_object(coloured(tmp_path, "newmtl body\nKd 1 0 0\n")).reference.sha256
    assert user_object(coloured(tmp_path, "newmtl body\nKd 0 1 0\n")).reference.sha256 == before
    assert user_object(coloured(tmp_path / "b", None)).reference.sha256 == before


@pytest.mark.parametrize(
    "library", ["", "newmtl body\nKd\n", "Kd 1 0 nan", "newmtl body\nKd 1 0 7", "\0" * 99]
)
def test_what_cannot_be_read_is_drawn_grey(tmp_path, library):
    path = coloured(tmp_path, library)
    assert list(drawn(path)) == [pytest.approx(GREY)]


def test_material_files_outside_are_not_opened(tmp_path):
    path = coloured(tmp_path, None)
    notes = user_object(path).reference.notes
    assert notes == (
        "2 open pieces joined",
        "colours of a material file that cannot be read left out",
    )
    (tmp_path / "secret.mtl").write_text("newmtl body\nKd 1 0 0\n")
    (path / "block.mtl").symlink_to(tmp_path / "secret.mtl")
    assert list(drawn(path)) == [pytest.approx(GREY)]
