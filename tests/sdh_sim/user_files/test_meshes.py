"""Mesh files: numbers of a block in every format, parts, hulls, and what is refused."""

from __future__ import annotations

import base64
import json
import re
from typing import Any

import numpy as np
import pytest
import trimesh

from sdh_sim.objects import user_object
from tests.support.object_files import (
    BLOCK_INERTIA,
    FACTS,
    A,
    B,
    C,
    block,
    info_of,
    object_folder,
    refusal,
)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off", "glb"])
def test_a_box_has_the_numbers_of_a_box_in_every_format(tmp_path, ending):
    obj = info_of(object_folder(tmp_path, block((0.01, 0.02, 0.03)), ending=ending))
    assert obj.name == "block"
    assert (obj.mass_kg, obj.friction) == (0.4, 0.6)
    assert obj.com_m == pytest.approx((0.01, 0.02, 0.03), abs=1e-8)
    assert obj.extents_m == pytest.approx((A, B, C), abs=1e-8)
    assert obj.inertia_kgm2 == pytest.approx(BLOCK_INERTIA, abs=1e-9)
    assert obj.standing_height == pytest.approx(0.5 * C - 0.03, abs=1e-8)
    assert (obj.height, obj.half_narrow, obj.half_wide) == pytest.approx((C, A / 2, B / 2))
    assert obj.narrow_yaw == 0.0


def test_parts_make_one_body(tmp_path):
    # Two cubes of 40 mm, centres 60 mm apart: parallel axes.
    cubes = trimesh.Scene([block((x, 0, 0), (0.04,) * 3) for x in (-0.03, 0.03)])
    path = object_folder(tmp_path, cubes, ending="glb")
    found = user_object(path)
    assert (found.parts, found.hull_ratio) == (2, pytest.approx(1.0))
    own = 0.4 * 0.04**2 / 6
    wanted = np.diag([own, own + 0.4 * 0.03**2, own + 0.4 * 0.03**2])
    assert info_of(path).inertia_kgm2 == pytest.approx(wanted, abs=1e-9)
    # One surface for both is divided where they are apart in space, whatever their names.
    joined = trimesh.util.concatenate(list(cubes.dump()))
    assert user_object(object_folder(tmp_path / "b", joined)).parts == 2


def test_a_hull_is_taken_only_when_asked_for(tmp_path):
    ring = trimesh.creation.annulus(0.02, 0.04, 0.1)
    text = refusal(object_folder(tmp_path, ring))
    ratio = float(re.search(r"hull has ([\d.]+) times its volume", text)[1])  # type: ignore[index]
    assert ratio == pytest.approx(1 / (1 - 0.25), rel=0.01)
    assert "hull = true" in text
    found = user_object(object_folder(tmp_path, ring, FACTS + "hull = true"))
    assert found.hull_ratio == pytest.approx(ratio, rel=0.01)


def hole() -> trimesh.Trimesh:
    mesh = block()
    mesh.update_faces(np.arange(11))
    return mesh


def inverted() -> trimesh.Trimesh:
    mesh = block()
    mesh.invert()
    return mesh


def turned() -> trimesh.Trimesh:
    mesh = block()
    mesh.faces[3] = mesh.faces[3][::-1]
    return mesh


def hollow():
    inner = block(size=(0.03, 0.03, 0.03))
    inner.invert()
    return trimesh.util.concatenate([block(), inner])


BAD_MESHES = [
    (hole, "is not watertight: it has a hole"),
    (turned, "is not watertight"),
    (inverted, "is inside out: its volume is -0.000576 m³"),
    (hollow, "is inside out (the one of 2 parts around 0, 0, 0 m)"),
    (lambda: block(size=(60, 80, 120)), "its unit, millimetres (scale = 0.001, 120 mm)"),
    (
        lambda: block(size=(6, 8, 12)),
        "millimetres (scale = 0.001, 12 mm) or centimetres (scale = 0.01, 120 mm) or inches "
        "(scale = 0.0254, 304.8 mm)",
    ),
    (
        lambda: block(size=(6e-5, 8e-5, 12e-5)),
        "its largest side must be 10 to 500 mm: set scale",
    ),
    (lambda: block(size=(0.06, 0.08, 0.004)), "no side may be thinner than 0.005 m"),
    (lambda: block(size=(0.06, 0.08, 0.6)), "0.06 × 0.08 × 0.6 m large; its largest"),
    (lambda: trimesh.creation.icosphere(7, 0.04), "more than 100000 triangles"),
    (
        lambda: trimesh.Scene([block((0.07 * k, 0, 0), (0.004,) * 3) for k in range(3)]),
        "no side may be thinner",
    ),
    (
        lambda: trimesh.util.concatenate(
            [block((0.005 * k, 0, 0), (0.004, 0.01, 0.01)) for k in range(70)]
        ),
        "at most 64 are taken",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("mesh", "message"), BAD_MESHES)
def test_meshes_are_refused_in_words(tmp_path, mesh, message):
    assert message in refusal(object_folder(tmp_path, mesh()))


@pytest.mark.parametrize(
    ("ending", "text"),
    [
        ("stl", ""),
        ("stl", "solid x\nendsolid x\n"),
        ("obj", "v 0 0 0\nv 0 0 1\nv 0 nan 0\nv 1 0 0\nf 1 2 3\nf 1 2 4\n"),
        ("obj", "f 1 2 9999999\n"),
        ("ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n"),
        ("off", "OFF\n99999999 999999999 0\n"),
        ("glb", "glTF\x02\x00\x00\x00"),
        ("gltf", '{"asset":{"version":"2.0"},"buffers":[{"byteLength":9,"uri":"../secret.bin"}]}'),
        ("gltf", '{"asset":{"version":"2.0"},"accessors":[{"count":999999999999,"type":"VEC3"}]}'),
        ("gltf", '{"asset":{"version":"2.0"},"accessors":[{"count":1e999,"type":"VEC3"}]}'),
        ("gltf", "[" * 100_000),
        ("xyz", "1 2 3"),
        ("zip", "PK"),
    ],
)
def test_files_that_are_no_mesh(tmp_path, ending, text):
    path = object_folder(tmp_path, text, ending=ending)
    problem = refusal(path).removeprefix(f"object: {path}: ")
    assert re.match(rf"block\.{ending} |no mesh and no MJCF", problem)


def test_one_mesh_shown_many_times_counts_every_time(tmp_path):
    scene = trimesh.Scene(trimesh.creation.icosphere(4, 0.01))
    for k in range(30):
        scene.add_geometry(block((0, 0, 0.1)), node_name=f"n{k}")
    document: Any = scene.export(file_type="gltf")
    text = json.loads(document["model.gltf"])
    many = next(k for k, mesh in enumerate(text["meshes"]) if mesh["name"].startswith("geometry_0"))
    for node in text["nodes"]:
        if "mesh" in node:
            node["mesh"] = many
    for buffer in text["buffers"]:
        data = base64.b64encode(document[buffer["uri"]]).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{data}"
    path = object_folder(tmp_path, json.dumps(text), ending="gltf")
    assert "more than 100000 triangles" in refusal(path)
