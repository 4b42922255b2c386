"""Objects of users: numbers against closed forms, every refusal in words, runs that repeat."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from sdh_sim import records
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.cell.scene import OBJECT_GEOM
from sdh_sim.cell.scene_builder import build_scene
from sdh_sim.cli.app import main
from sdh_sim.errors import ObjectError, SettingsError
from sdh_sim.grasping.grasp_sampler import sample_grasp
from sdh_sim.metrics.built_in import evaluate
from sdh_sim.metrics.stored_grasps import grasp_of
from sdh_sim.model_files import models_dir
from sdh_sim.objects.catalogue import (
    find_objects,
    object_info,
    object_names,
    object_spec,
    user_object,
)
from sdh_sim.objects.facts import DEFAULT_SPREAD
from sdh_sim.objects.object_info import ObjectInfo, Spread
from sdh_sim.robot.hand import HandKinematics
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import ObjectFolder
from tests.support.repository import ROOT

MUG = ROOT / "docs" / "examples" / "mug"
FACTS = "mass = 0.4\nfriction = 0.6\n"
A, B, C = 0.06, 0.08, 0.12
BOX_INERTIA = 0.4 / 12 * np.diag([B * B + C * C, A * A + C * C, A * A + B * B])


def box(centre=(0.0, 0.0, 0.0), size=(A, B, C)) -> trimesh.Trimesh:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(centre)
    return mesh


def folder(tmp_path: Path, shape=None, facts: str = FACTS, ending: str = "stl") -> Path:
    """An object's folder; the shape is a mesh, a scene, or the text of a file."""
    path = tmp_path / "thing"
    (path / "assets").mkdir(parents=True, exist_ok=True)
    (path / "object.toml").write_text(facts)
    shape = box() if shape is None else shape
    if isinstance(shape, str):
        (path / f"thing.{ending}").write_text(shape)
    else:
        shape.export(path / f"thing.{ending}")
    return path


def info(path: Path) -> ObjectInfo:
    thing = user_object(path)
    return object_info(thing.name, thing.reference)


def refusal(path: Path) -> str:
    with pytest.raises(ObjectError) as caught:
        user_object(path)
    text = str(caught.value)
    assert text.startswith(f"object: {path}: ")
    assert text.isprintable()
    return text


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off", "glb"])
def test_a_box_has_the_numbers_of_a_box_in_every_format(tmp_path, ending):
    thing = info(folder(tmp_path, box((0.01, 0.02, 0.03)), ending=ending))
    assert thing.name == "thing"
    assert (thing.mass_kg, thing.friction) == (0.4, 0.6)
    assert thing.com_m == pytest.approx((0.01, 0.02, 0.03), abs=1e-8)
    assert thing.extents_m == pytest.approx((A, B, C), abs=1e-8)
    assert thing.inertia_kgm2 == pytest.approx(BOX_INERTIA, abs=1e-9)
    assert thing.standing_height == pytest.approx(0.5 * C - 0.03, abs=1e-8)
    assert (thing.height, thing.half_narrow, thing.half_wide) == pytest.approx((C, A / 2, B / 2))
    assert thing.narrow_yaw == 0.0


def test_what_object_toml_gives_is_taken(tmp_path):
    facts = FACTS + (
        'name = "tin"\ncom = [0.001, -0.002, 0.01]\ninertia = [1e-3, 9e-4, 6e-4, 1e-5, 0, -2e-5]\n'
        'scale = 0.001\nup = "y"\n[grasp]\nside = 0.2\nyaw = 0.1\n'
    )
    thing = info(folder(tmp_path, box(size=(60, 80, 120)), facts))
    assert thing.name == "tin"
    assert thing.com_m == pytest.approx((0.001, -0.002, 0.01))
    wanted = np.array([[1e-3, 1e-5, 0], [1e-5, 9e-4, -2e-5], [0, -2e-5, 6e-4]])
    assert thing.inertia_kgm2 == pytest.approx(wanted, abs=1e-10)
    assert thing.height == pytest.approx(0.08)
    assert thing.spread == Spread(0.2, DEFAULT_SPREAD.wide, DEFAULT_SPREAD.offset, 0.1)


@pytest.mark.parametrize(("up", "axis"), [("x", 0), ("y", 1), ("z", 2)])
def test_the_axis_named_points_up(tmp_path, up, axis):
    path = folder(tmp_path, box((0.01, 0.02, 0.03)), FACTS + f'up = "{up}"')
    thing = user_object(path)
    model = thing.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    rotation = data.body("object").xmat.reshape(3, 3)
    assert rotation[:, axis] == pytest.approx((0, 0, 1), abs=1e-9)
    assert object_info(thing.name, thing.reference).height == pytest.approx((A, B, C)[axis])
    assert data.site("base").xpos == pytest.approx(np.zeros(3), abs=1e-9)
    assert data.site("base").xmat.reshape(3, 3) == pytest.approx(np.eye(3), abs=1e-9)


def test_parts_make_one_body(tmp_path):
    # Two cubes of 40 mm, centres 60 mm apart: parallel axes.
    cubes = trimesh.Scene([box((x, 0, 0), (0.04,) * 3) for x in (-0.03, 0.03)])
    path = folder(tmp_path, cubes, ending="glb")
    thing = user_object(path)
    assert (thing.parts, thing.hull_ratio) == (2, pytest.approx(1.0))
    own = 0.4 * 0.04**2 / 6
    wanted = np.diag([own, own + 0.4 * 0.03**2, own + 0.4 * 0.03**2])
    assert info(path).inertia_kgm2 == pytest.approx(wanted, abs=1e-9)
    joined = trimesh.util.concatenate(list(cubes.dump()))
    assert user_object(folder(tmp_path / "b", joined)).parts == 2  # apart in space: no names needed


def test_a_hull_is_taken_only_when_asked_for(tmp_path):
    ring = trimesh.creation.annulus(0.02, 0.04, 0.1)
    text = refusal(folder(tmp_path, ring))
    ratio = float(re.search(r"hull has ([\d.]+) times its volume", text)[1])  # type: ignore[index]
    assert ratio == pytest.approx(1 / (1 - 0.25), rel=0.01)
    assert "hull = true" in text
    thing = user_object(folder(tmp_path, ring, FACTS + "hull = true"))
    assert thing.hull_ratio == pytest.approx(ratio, rel=0.01)


MJCF = """<mujoco><compiler angle="degree"/><worldbody><body name="x" pos="9 9 9"><freejoint/>
{}</body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("geom", "extents", "moments"),
    [
        ('type="sphere" size="0.04"', (0.08,) * 3, (2 / 5 * 0.04**2,) * 3),
        (
            'type="cylinder" size="0.03 0.05"',
            (0.06, 0.06, 0.1),
            (0.03**2 / 4 + 0.1**2 / 12,) * 2 + (0.03**2 / 2,),
        ),
        (
            'type="ellipsoid" size="0.03 0.04 0.05"',
            (0.06, 0.08, 0.1),
            ((0.04**2 + 0.05**2) / 5, (0.03**2 + 0.05**2) / 5, (0.03**2 + 0.04**2) / 5),
        ),
        (
            'type="box" size="0.03 0.04 0.06" euler="0 0 90"',
            (B, A, C),
            ((A * A + C * C) / 12, (B * B + C * C) / 12, (A * A + B * B) / 12),
        ),
    ],
)
def test_primitives_of_mjcf(tmp_path, geom, extents, moments):
    thing = info(folder(tmp_path, MJCF.format(f"<geom {geom}/>"), ending="xml"))
    assert thing.extents_m == pytest.approx(extents, abs=1e-9)
    assert thing.inertia_kgm2 == pytest.approx(0.4 * np.diag(moments), abs=1e-9)
    assert thing.height == pytest.approx(extents[2])


def test_a_tilted_cylinder_stands_on_its_edge_and_not_on_its_box(tmp_path):
    # Tilted by 30 degrees, its top edge is at r sin 30 + h cos 30; a foot keeps it upright.
    geoms = (
        '<geom type="cylinder" size="0.03 0.04" pos="0 0 0.1" euler="30 0 0"/>'
        '<geom type="box" size="0.05 0.05 0.02" pos="0 0 0.02"/>'
    )
    thing = info(folder(tmp_path, MJCF.format(geoms), ending="xml"))
    assert thing.height == pytest.approx(0.1 + 0.03 * 0.5 + 0.04 * np.sqrt(0.75), abs=2e-5)


@pytest.mark.parametrize("name", object_names())
def test_a_built_in_object_as_a_user_s_is_the_same(tmp_path, name):
    path = tmp_path / name
    shutil.copytree(models_dir() / "objects" / name, path)
    known = object_info(name)
    text = (path / f"{name}.xml").read_text()
    full = re.search(r'fullinertia="([^"]*)"', text)[1].split()  # type: ignore[index]
    text = re.sub(r"<inertial.*?/>", "", text, flags=re.DOTALL)
    text = re.sub(r' quat="[^"]*">', ">", text)
    text = re.sub(r'condim="3"\s*friction="[^"]*"', "", text).replace('inertia="shell"', "")
    (path / f"{name}.xml").write_text(text)
    up = "y" if known.standing_quat[0] < 0.9 else "z"
    (path / "object.toml").write_text(
        f'name = "mine"\nmass = {known.mass_kg}\nfriction = {known.friction}\nup = "{up}"\n'
        f"com = {known.com_m.tolist()}\ninertia = [{', '.join(full)}]\n"
    )
    mine = info(path)
    for field in ObjectInfo.__dataclass_fields__:
        if field not in ("name", "spread", "folder"):
            assert getattr(mine, field) == pytest.approx(getattr(known, field), abs=1e-8), field


def test_contacts_of_a_user_s_object_are_those_of_a_built_in_one(tmp_path):
    thing = user_object(MUG)
    scene = build_scene(TrialSettings(thing.name, folder=thing.reference))
    of_box = build_scene(TrialSettings("box"))

    def touching(some):
        geoms = np.flatnonzero((some.geom_group == OBJECT_GEOM) & (some.model.geom_contype > 0))
        names = ("contype", "conaffinity", "condim", "group", "margin", "gap", "priority")
        same = {tuple(int(getattr(some.model, f"geom_{n}")[g]) for n in names) for g in geoms}
        return same, {tuple(some.model.geom_solref[g]) for g in geoms}

    assert touching(scene) == touching(of_box)
    felt = scene.model.geom_friction[scene.taxel >= 0, 0]
    assert np.unique(felt) == pytest.approx([0.55])


def test_low_objects_are_taken_from_above_and_the_spread_is_obeyed(tmp_path):
    low = info(folder(tmp_path, box(size=(0.06, 0.06, 0.05))))
    rng = np.random.default_rng(0)
    plans = [sample_grasp(low, rng) for _ in range(50)]
    assert {p.approach for p in plans} == {"top"}
    assert all(0.0 < p.height < 0.05 for p in plans)
    sides = info(folder(tmp_path / "b", facts=FACTS + "[grasp]\nside = 1.0\noffset = 0.0\n"))
    plans = [sample_grasp(sides, rng) for _ in range(50)]
    assert {p.approach for p in plans} == {"side"}
    assert all((p.offset == 0.0).all() for p in plans)


BAD_TOML = [
    ("", "lacks mass; give a number 0.01 to 5 kg"),
    ("mass = 1\n", "lacks friction; give a number 0.05 to 2"),
    ("mass = ", "is not TOML"),
    ("mass = 1\nmass = 2", "is not TOML"),
    ("\udcff", "is not TOML"),
    ("a = " + "[" * 9000, "is not TOML"),
    ("x = 1" * 9000, "more than 16384 bytes"),
    ('mass = "1"\nfriction = 1', "mass is '1'; give a number 0.01 to 5 kg"),
    ("mass = true\nfriction = 1", "mass is True"),
    ("mass = nan\nfriction = 1", "mass is nan"),
    ("mass = inf\nfriction = 1", "mass is inf"),
    ("mass = 350\nfriction = 1", "mass is 350"),
    (f"mass = {10**400}\nfriction = 1", "mass is 1000"),
    ("mass = 1\nfriction = -1", "friction is -1"),
    (FACTS + "masss = 1", "unknown key 'masss'; known are name, mass, friction"),
    (FACTS + "[grasp]\nfront = 1", "unknown key 'grasp.front'; known are side, wide"),
    (FACTS + "[grasp]\nside = 2", "grasp.side is 2; give a number 0 to 1"),
    (FACTS + "grasp = 1", "expected a table [grasp]"),
    (FACTS + "com = [0, 0]", "com is [0, 0]; give 3 numbers [x, y, z in m]"),
    (FACTS + "com = [0, 0, nan]", "give 3 numbers"),
    (FACTS + "com = [0, 0, 0.061]", "com is 0.0, 0.0, 61.0 mm, outside the shape"),
    (FACTS + "inertia = [1e-3, 1e-4, 1e-4, 0, 0, 0]", "no body has it"),
    (FACTS + "inertia = [-1e-3, 1e-3, 1e-3, 0, 0, 0]", "no body has it"),
    (FACTS + "inertia = [0.5, 0.5, 0.5, 0, 0, 0]", "more than the mass in the farthest corner"),
    (FACTS + "inertia = [1e-9, 1e-9, 1e-9, 0, 0, 0]", "as if all mass were in one point"),
    (FACTS + 'up = "w"', 'give "x", "y" or "z"'),
    (FACTS + 'hull = "yes"', "give true or false"),
    (FACTS + 'name = "all"', "the name 'all' cannot be used"),
    (FACTS + 'name = "a/b"', "the name 'a/b' cannot be used"),
    (FACTS + 'name = "a b"', "cannot be used"),
    (FACTS + 'name = "\\u001b[2J"', "cannot be used"),
    (FACTS + 'model = "/etc/passwd"', "its name must end in one of"),
    (FACTS + 'model = "/etc/passwd.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "../thing/thing.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "assets/../thing.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "~/thing.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "other.stl"', "cannot read 'other.stl': No such file"),
    (FACTS + "scale = 1000", "set scale = 1"),
    (FACTS + "scale = 0", "scale is 0; give a number"),
]


@pytest.mark.parametrize(("facts", "words"), BAD_TOML)
def test_object_toml_is_refused_in_words(tmp_path, facts, words):
    path = folder(tmp_path)
    (path / "object.toml").write_bytes(facts.encode("utf-8", "surrogateescape"))
    assert words in refusal(path)


def hole() -> trimesh.Trimesh:
    mesh = box()
    mesh.update_faces(np.arange(11))
    return mesh


def inverted() -> trimesh.Trimesh:
    mesh = box()
    mesh.invert()
    return mesh


def turned() -> trimesh.Trimesh:
    mesh = box()
    mesh.faces[3] = mesh.faces[3][::-1]
    return mesh


def hollow():
    inner = box(size=(0.03, 0.03, 0.03))
    inner.invert()
    return trimesh.util.concatenate([box(), inner])


BAD_MESHES = [
    (hole, "is not watertight: it has a hole"),
    (turned, "is not watertight"),
    (inverted, "is inside out: its volume is -0.000576 m³"),
    (hollow, "is inside out (the one of 2 parts around 0, 0, 0 m)"),
    (lambda: box(size=(60, 80, 120)), "looks like millimetres: set scale = 0.001"),
    (lambda: box(size=(6, 8, 12)), "looks like centimetres: set scale = 0.01"),
    (lambda: box(size=(6e-5, 8e-5, 12e-5)), "its unit looks 1000 times as large: set scale = 1000"),
    (lambda: box(size=(0.06, 0.08, 0.004)), "no side may be thinner than 0.005 m"),
    (lambda: box(size=(0.06, 0.08, 0.6)), "0.06 × 0.08 × 0.6 m large; set scale so that it"),
    (lambda: trimesh.creation.icosphere(7, 0.04), "more than 100000 triangles"),
    (
        lambda: trimesh.Scene([box((0.07 * k, 0, 0), (0.004,) * 3) for k in range(3)]),
        "no side may be thinner",
    ),
    (
        lambda: trimesh.util.concatenate(
            [box((0.005 * k, 0, 0), (0.004, 0.01, 0.01)) for k in range(70)]
        ),
        "at most 64 are taken",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("mesh", "words"), BAD_MESHES)
def test_meshes_are_refused_in_words(tmp_path, mesh, words):
    assert words in refusal(folder(tmp_path, mesh()))


def test_what_falls_over_is_refused(tmp_path):
    leaning = box((0.0, 0.0, 0.06))
    leaning.vertices[:, 0] += leaning.vertices[:, 2]  # sheared by 45 degrees
    assert "it falls over: standing on z up, its centre of mass is 30.0 mm beside" in refusal(
        folder(tmp_path, leaning)
    )


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
    path = folder(tmp_path, text, ending=ending)
    assert re.search("thing|no mesh and no MJCF", refusal(path))


BAD_MJCF = [
    ("<worldbody/>", "0 bodies"),
    ("<include file='/etc/passwd'/>", "<include> in <mujoco>", "it would read another file"),
    ("<extension><plugin plugin='a.b'/></extension>", "<extension>", "run other code"),
    ("<actuator/>", "<actuator>"),
    ("<keyframe/>", "<keyframe>"),
    ("<option timestep='1'/>", "<option>"),
    ("<asset><texture type='2d' file='/etc/passwd'/></asset>", "<texture>"),
    ("<asset><hfield name='h' file='x.png'/></asset>", "<hfield>"),
    ("<asset><mesh file='/etc/passwd.stl'/></asset>", "not the name of a file in this folder"),
    ("<asset><mesh file='../thing.stl'/></asset>", "not the name of a file in this folder"),
    ("<asset><mesh file='thing.msh'/></asset>", "must be STL, OBJ, PLY, OFF or GLB"),
    ("<asset><mesh file='a.stl' content_type='x'/></asset>", "'content_type' of <mesh>"),
    ("<compiler meshdir='/etc'/><asset><mesh file='a.stl'/></asset>", "in this folder"),
    ("<compiler meshdir='..'/><asset><mesh file='thing/a.stl'/></asset>", "in this folder"),
    ("<compiler strippath='true'/>", "'strippath' of <compiler>"),
    ("<worldbody><body><geom/><body/></body></worldbody>", "an object is one body"),
    ("<worldbody><body><geom/></body><body><geom/></body></worldbody>", "has 2 bodies"),
    ("<worldbody><body><joint type='hinge'/><geom/></body></worldbody>", "<joint>"),
    ("<worldbody><body quat='0 1 0 0'><geom/></body></worldbody>", "which axis is up"),
    ("<worldbody><body><inertial/></body></worldbody>", "object.toml"),
    ("<worldbody><body><geom type='plane' size='1 1 1'/></body></worldbody>", "'plane'"),
    ("<worldbody><body><geom type='sdf'/></body></worldbody>", "'sdf'"),
    ("<worldbody><body><geom size='nan'/></body></worldbody>", "finite numbers"),
    ("<worldbody><body><geom size='1 2 3 4'/></body></worldbody>", "finite numbers"),
    ("<worldbody><body><geom mass='1'/></body></worldbody>", "'mass' of <geom>", "object.toml"),
    ("<worldbody><body><geom solref='1 1'/></body></worldbody>", "'solref' of <geom>"),
    ("<worldbody><body><geom type='sphere'/></body></worldbody>", "cannot be compiled"),
    ("<worldbody><body><geom size='0.04' contype='0' conaffinity='0'/></body></worldbody>",
     "no geom that touches"),
    ("<worldbody><body>" + "<geom size='1'/>" * 65 + "</body></worldbody>", "65 elements <geom>"),
    ("<worldbody>" * 20, "deeper than 16"),
    ("<geom/>" * 3000, "more than 2000"),
    ("<worldbody>", "is not XML"),
]  # fmt: skip


@pytest.mark.parametrize("case", BAD_MJCF, ids=lambda case: case[0][:40])
def test_mjcf_is_refused_in_words(tmp_path, case):
    inside, *words = case
    if "<asset>" in inside:
        inside += "<worldbody><body><geom size='0.04'/></body></worldbody>"
    text = refusal(folder(tmp_path, f"<mujoco>{inside}</mujoco>", ending="xml"))
    for word in words:
        assert word in text


def test_messages_carry_no_control_characters(tmp_path):
    for name in ("a\u202eb", "\u009b2J"):
        refusal(folder(tmp_path, f'<mujoco xmlns="{name}"/>', ending="xml"))
    path = folder(tmp_path / "b")
    box().export(path / "a\x1b[2J.stl")
    refusal(path)
    (path / "thing.stl").unlink()
    assert "is not the name of a file in this folder" in refusal(path)


def test_one_mesh_shown_many_times_counts_every_time(tmp_path):
    scene = trimesh.Scene(trimesh.creation.icosphere(4, 0.01))
    for k in range(30):
        scene.add_geometry(box((0, 0, 0.1)), node_name=f"n{k}")
    document: Any = scene.export(file_type="gltf")
    text = json.loads(document["model.gltf"])
    many = next(k for k, mesh in enumerate(text["meshes"]) if mesh["name"].startswith("geometry_0"))
    for node in text["nodes"]:
        if "mesh" in node:
            node["mesh"] = many
    for buffer in text["buffers"]:
        data = base64.b64encode(document[buffer["uri"]]).decode()
        buffer["uri"] = f"data:application/octet-stream;base64,{data}"
    path = folder(tmp_path, json.dumps(text), ending="gltf")
    assert "more than 100000 triangles" in refusal(path)


def test_entities_are_not_expanded(tmp_path):
    levels = "".join(
        f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' if k else '<!ENTITY a0 "x">' for k in range(12)
    )
    bomb = f'<!DOCTYPE mujoco [{levels}]><mujoco model="&a11;"/>'
    assert "declares a document type" in refusal(folder(tmp_path, bomb, ending="xml"))
    outside = '<!DOCTYPE mujoco [<!ENTITY a SYSTEM "file:///etc/passwd">]><mujoco>&a;</mujoco>'
    assert "declares a document type" in refusal(folder(tmp_path, outside, ending="xml"))


def test_links_and_pipes_lead_nowhere(tmp_path):
    secret = tmp_path / "secret.stl"
    box().export(secret)
    path = folder(tmp_path)
    (path / "thing.stl").unlink()
    (path / "thing.stl").symlink_to(secret)
    assert "is a link that leads out of this folder" in refusal(path)
    (path / "thing.stl").unlink()
    (path / "thing.stl").symlink_to("thing.stl")
    assert "cannot read 'thing.stl'" in refusal(path)
    (path / "thing.stl").unlink()
    os.mkfifo(path / "thing.stl")
    assert "is not a file" in refusal(path)
    (path / "thing.stl").unlink()
    (path / "thing.stl").mkdir()
    assert "cannot read" in refusal(path)
    (path / "thing.stl").rmdir()
    box().export(path / "assets" / "real.stl")
    (path / "thing.stl").symlink_to("assets/real.stl")  # inside is fine
    assert user_object(path).parts == 1


def test_the_number_of_files_is_bounded(tmp_path):
    path = folder(tmp_path)
    for k in range(1001):
        (path / f"{k}.txt").touch()
    assert "more than 1000 files" in refusal(path)
    path = folder(tmp_path / "b")
    box().export(path / "second.stl")
    assert "say in object.toml which is the object: model =" in refusal(path)


def test_the_digest_is_of_what_makes_the_object(tmp_path):
    path = folder(tmp_path)
    before = user_object(path).reference.sha256
    (path / "README.md").write_text("mine")
    assert user_object(path).reference.sha256 == before
    moved = path.rename(tmp_path / "moved")
    (moved / "object.toml").write_text(FACTS + 'name = "thing"')
    other = user_object(moved).reference.sha256
    assert other != before
    box(size=(0.06, 0.08, 0.121)).export(moved / "thing.stl")
    assert user_object(moved).reference.sha256 not in (before, other)


def test_names_and_folders_are_told_apart(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = folder(tmp_path)
    names, folders = find_objects(["all", "thing", "./thing", str(path), "box"], {})
    assert names == (*object_names(), "thing")
    assert folders == {"thing": user_object(path).reference}
    other = folder(tmp_path / "b", box(size=(0.05, 0.05, 0.1)))
    with pytest.raises(SettingsError, match="are both 'thing'; set another name"):
        find_objects([str(path), str(other)], {})
    (path / "object.toml").write_text(FACTS + 'name = "box"')
    with pytest.raises(SettingsError, match="'box' is a built-in object's"):
        find_objects([str(path)], {})
    with pytest.raises(SettingsError, match="got 'duck'; choose one of box,"):
        find_objects(["duck"], {})
    with pytest.raises(SettingsError, match="No such file"):
        find_objects(["no/where"], {})


def test_a_plan_keeps_the_folders(tmp_path):
    reference = user_object(MUG).reference
    plan = RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, {"mug": reference})
    assert RunPlan.from_dict(json.loads(json.dumps(plan.to_dict()))) == plan
    assert plan.job(1).settings.folder is None
    assert plan.job(2).settings == TrialSettings("mug", folder=reference)
    elsewhere = ObjectFolder("/else/where", reference.sha256)
    moved = RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, {"mug": elsewhere})
    assert moved.changes_from(plan) == []
    edited = ObjectFolder(reference.path, "0" * 64)
    changed = RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, {"mug": edited})
    assert "folders" in " ".join(changed.changes_from(plan))
    for wrong in ({"duck": reference}, {"mug": "path"}):
        with pytest.raises(SettingsError, match="no object of the run"):
            RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, wrong)  # type: ignore[arg-type]
    for wrong in (
        None,
        [],
        {"mug": None},
        {"mug": {"path": 1}},
        {"mug": {"path": "", "sha256": 1}},
    ):
        with pytest.raises(SettingsError):
            RunPlan.from_dict({**plan.to_dict(), "folders": wrong})


def test_a_run_with_a_folder_repeats_resumes_and_minds_changes(tmp_path, monkeypatch, capsys):
    mug = tmp_path / "cup"
    shutil.copytree(MUG, mug)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    lift = ["lift", "--workers", "2", "--timestep", "0.004"]
    assert main([*lift, "--object", str(mug), "--trials", "2", "--out", str(whole)]) == 0
    assert main([*lift, "--object", str(mug), "--trials", "1", "--out", str(parts)]) == 0
    resume = ["lift", "--resume", "--trials", "2", "--out", str(parts)]

    facts = (mug / "object.toml").read_text()
    (mug / "object.toml").write_text(facts.replace("0.35 ", "0.36 "))
    for again in (resume, [*resume, "--object", str(mug)], ["show", str(parts), "--trial", "0"]):
        capsys.readouterr()
        assert main(again) == 2
        assert "has changed since the run began; bring its files back" in capsys.readouterr().err
    (mug / "object.toml").write_text(facts)

    moved = mug.rename(tmp_path / "moved")
    assert main(resume) == 2
    assert "No such file" in capsys.readouterr().err
    assert main([*resume, "--object", str(moved)]) == 0
    table = (parts / "trials.parquet").read_bytes()
    assert table == (whole / "trials.parquet").read_bytes()
    assert RunFolder(parts).read_plan().folders["mug"].path == str(moved)
    rows = records.read_rows(parts / "trials.parquet")
    assert {row["object"] for row in rows} == {"mug"}
    assert rows[0]["mass_kg"] == 0.35
    folders = RunFolder(parts).read_plan().folders
    for row in rows:
        grasp = grasp_of(row, "all", HandKinematics(), folders)
        assert grasp is not None
        assert evaluate(grasp)["q_linf"] == pytest.approx(row["q_linf"], rel=1e-4)
    assert main(["compare", str(parts), "--no-report"]) == 0
    assert " mug " in capsys.readouterr().out


def test_workers_that_find_another_object_stop_the_run(tmp_path):
    thing = user_object(folder(tmp_path))
    other = ObjectFolder(thing.reference.path, "0" * 64)
    plan = RunPlan(("thing",), TrialSettings("thing"), 3, 0, {"thing": other})
    with pytest.raises(Exception, match="thing has changed since the run began"):
        run_campaign(plan, tmp_path / "run", 1)
    assert records.read_rows(tmp_path / "run" / "trials.parquet") == []


def test_objects_describes_folders(tmp_path, capsys):
    assert main(["objects", str(MUG)]) == 0
    out = capsys.readouterr().out
    assert "108.9 × 80.0 × 95.0" in out
    assert "mug.obj, 8 collision shapes, hulls 1.000 × its volume" in out
    assert main(["objects", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("sdh-sim: --object: ")
    assert "cannot read 'object.toml': No such file" in err


def test_specs_are_independent():
    reference = user_object(MUG).reference
    first = object_spec("mug", reference)
    first.body("object").mass = 9.0
    second = object_spec("mug", reference).compile()
    assert second.body("object").mass == pytest.approx(0.35)


def test_the_example_is_what_its_script_writes():
    sys.path.insert(0, str(MUG.parent))
    try:
        import make_mug  # type: ignore[import-not-found]
    finally:
        sys.path.pop(0)
    assert make_mug.obj() == (MUG / "mug.obj").read_text()
