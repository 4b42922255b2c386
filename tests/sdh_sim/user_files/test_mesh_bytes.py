"""Binary meshes: STL told from text by its length, MuJoCo's MSH."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from sdh_sim.errors import MeshError
from sdh_sim.objects import user_object
from sdh_sim.user_files.mesh_bytes import read_msh, stl_kind
from tests.support.object_files import (
    BLOCK_INERTIA,
    A,
    B,
    C,
    block,
    info_of,
    object_folder,
    refusal,
)


def stl_bytes(header: bytes = b"") -> bytes:
    data: bytes = block().export(file_type="stl")  # type: ignore[assignment]
    return header.ljust(80) + data[80:]


def msh_bytes(normals: int = 0) -> bytes:
    """The block as MSH, with so many normals."""
    mesh = block()
    counts = (len(mesh.vertices), normals, 0, len(mesh.faces))
    arrays = (mesh.vertices.astype("<f4"), np.zeros((normals, 3), "<f4"), mesh.faces.astype("<i4"))
    return struct.pack("<4i", *counts) + b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)


def test_binary_stl_is_never_read_as_text(tmp_path):
    # The two bytes behind each triangle read as lines of text that would divide the mesh.
    data = bytearray(stl_bytes(b"solid of a writer that says so"))
    for row in range(12):
        data[84 + 50 * row + 48 :][:2] = b"\ng"
    path = object_folder(tmp_path)
    (path / "block.stl").write_bytes(bytes(data))
    assert info_of(path).extents_m == pytest.approx((A, B, C), abs=1e-8)
    many = bytearray(block().subdivide().subdivide().subdivide().export(file_type="stl"))  # type: ignore[arg-type]
    triangles = (len(many) - 84) // 50
    for row in range(triangles):
        many[84 + 50 * row + 48 : 84 + 50 * row + 50] = b"\ng"
    assert bytes(many).count(b"\ng") > 700
    (path / "block.stl").write_bytes(bytes(many))
    assert user_object(path).parts == 1


def test_bytes_behind_the_last_triangle_are_left_out(tmp_path):
    path = object_folder(tmp_path)
    (path / "block.stl").write_bytes(stl_bytes() + b"made by a scanner")
    assert info_of(path).extents_m == pytest.approx((A, B, C), abs=1e-8)
    (path / "block.stl").write_bytes(stl_bytes()[:-1])
    text = refusal(path)
    assert "as binary it claims 12 triangles, 684 bytes, and has 683" in text


def test_text_is_told_from_binary():
    text = b"\n Solid x\nendsolid x\n"
    assert stl_kind(text) == (text, "stl_ascii")
    assert stl_kind(stl_bytes(b"solid"))[1] == "stl"
    with pytest.raises(MeshError, match="as text it would begin with solid"):
        stl_kind(b"facet normal 0 0 1")


@pytest.mark.parametrize("normals", [0, 8])
def test_msh_is_read(tmp_path, normals):
    path = object_folder(tmp_path)
    (path / "block.stl").unlink()
    (path / "block.msh").write_bytes(msh_bytes(normals))
    obj = info_of(path)
    assert obj.extents_m == pytest.approx((A, B, C), abs=1e-8)
    assert obj.inertia_kgm2 == pytest.approx(BLOCK_INERTIA, abs=1e-9)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        msh_bytes()[:-4],
        struct.pack("<4i", 8, 0, 0, -1),
        struct.pack("<4i", 2**30, 0, 0, 2**30),
    ],
)
def test_msh_whose_counts_do_not_fit_is_refused(data):
    with pytest.raises(MeshError, match="is not a mesh that can be read as MSH"):
        read_msh(data)
