"""MJCF as other tools write it: scenes, nested bodies, includes, attributes of meshes."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from sdh_sim.objects import user_object
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.objects.facts_file import read_facts
from sdh_sim.objects.mjcf_object import from_mjcf
from sdh_sim.objects.user_objects import OBJECT_KIND
from sdh_sim.poses import rotation_of
from sdh_sim.user_files.folder import Folder
from tests.support.object_files import FACTS, A, B, C, block, info_of, object_folder, refusal

PLAIN = "<geom type='box' size='0.03 0.04 0.06'/>"
BODY = f"<body>{PLAIN}</body>"


def folder(
    tmp_path: Path, text: str, facts: str = FACTS, **meshes: trimesh.parent.Geometry
) -> Path:
    """A folder with an MJCF and STL files by name."""
    path = object_folder(tmp_path, f"<mujoco>{text}</mujoco>", facts, ending="xml")
    for name, mesh in meshes.items():
        mesh.export(path / f"{name}.stl")
    return path


def shape_of(path: Path) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """The shape of a folder, before it is put on the table, and notes."""
    reader = Folder(path, OBJECT_KIND)
    spec, _, notes = from_mjcf(reader, read_facts(reader), "block.xml")
    return spec.compile(), tuple(notes)


def in_order(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) sorted, to compare sets of them."""
    return points[np.lexsort(np.round(points, 6).T)]


IGNORED = {
    "light, option, plane": "<option timestep='1'/><worldbody><light pos='0 0 1'/>"
    f"<geom type='plane' size='1 1 1'/>{BODY}</worldbody>",
    "freejoint, plane": "<default><default class='a'><geom type='plane'/><default class='floor'/>"
    "</default></default><worldbody><geom class='floor' size='1 1 1'/><body><freejoint/>"
    f"{PLAIN}</body></worldbody>",
    "camera, custom, keyframe, size, statistic, visual": "<size njmax='9'/><visual/><statistic/>"
    f"<custom/><keyframe/><worldbody><camera name='c'/>{BODY}</worldbody>",
    "texrepeat, texture": "<asset><texture type='2d' name='t' file='/etc/passwd'/><material "
    f"name='m' texture='t' texrepeat='2 2'/></asset><worldbody>{BODY}</worldbody>",
    "condim, density, friction, margin, solimp, solref": "<worldbody><body><geom condim='4' "
    "density='9' friction='2' margin='0' solimp='1 1 1' solref='1 1' type='box' "
    "size='0.03 0.04 0.06'/></body></worldbody>",
    "freejoint, inertial, site": "<worldbody><body><freejoint/><inertial mass='1' pos='0 0 1'/>"
    f"<site name='s'/>{PLAIN}</body></worldbody>",
    "freejoint": "<worldbody><body><joint type='free' damping='1'/>"
    + PLAIN
    + "</body></worldbody>",
    "boundmass, exactmeshinertia": "<compiler boundmass='1' exactmeshinertia='true'/>"
    f"<worldbody>{BODY}</worldbody>",
    "joint, motor": "<default><joint damping='1'/><motor gear='2'/></default>"
    f"<worldbody>{BODY}</worldbody>",
}


@pytest.mark.parametrize("names", IGNORED)
def test_what_says_nothing_about_the_shape_is_ignored_by_name(tmp_path, names):
    path = folder(tmp_path, IGNORED[names])
    notes = user_object(path).reference.notes
    assert notes == (f"ignored, as it says nothing about the shape: {names}",)
    found = info_of(path)
    assert found.extents_m == pytest.approx((A, B, C))
    assert found.com_m == pytest.approx(np.zeros(3), abs=1e-9)
    assert found.friction == 0.6


FORMS = {
    "geoms in the worldbody": f"<worldbody>{PLAIN}</worldbody>",
    "a body in a body": f"<worldbody><body pos='9 9 9'><body>{BODY}</body></body></worldbody>",
    "a fixed body turned and moved": "<worldbody><body><geom type='box' size='0.04 0.03 0.01' "
    "pos='0 0 -0.05' euler='0 0 90'/><body pos='0 0 0.01' quat='1 0 0 1'><geom type='box' "
    "size='0.04 0.03 0.05'/></body></body></worldbody>",
    "a frame": "<worldbody><body><frame pos='0 0 0.06'><geom type='box' pos='0 0 -0.06' "
    "size='0.03 0.04 0.06'/></frame></body></worldbody>",
    "two fixed bodies": "<worldbody><body pos='0 0 0.03'><geom type='box' size='0.03 0.04 0.03'/>"
    "</body><body pos='0 0 -0.03'><geom type='box' size='0.03 0.04 0.03'/></body></worldbody>",
    "a turned body": "<worldbody><body quat='1 1 0 0'><geom type='box' size='0.03 0.06 0.04'/>"
    "</body></worldbody>",
    "a class of a body": "<default><default class='d'><geom type='box' size='0.03 0.04 0.06'/>"
    "</default></default><worldbody><body><body childclass='d'><geom/></body></body></worldbody>",
}


@pytest.mark.parametrize("form", FORMS)
def test_fixed_bodies_are_one_body(tmp_path, form):
    found = info_of(folder(tmp_path, f"<compiler angle='degree'/>{FORMS[form]}"))
    assert found.extents_m == pytest.approx((A, B, C), abs=1e-9)
    wanted = 0.4 / 12 * np.diag([B * B + C * C, A * A + C * C, A * A + B * B])
    assert found.inertia_kgm2 == pytest.approx(wanted, abs=1e-9)
    assert found.height == pytest.approx(C)


def test_includes_come_from_inside_the_folder(tmp_path):
    path = folder(
        tmp_path,
        "<include file='parts/assets.xml'/><worldbody><body><include file='parts/geom.xml'/>"
        "</body></worldbody>",
    )
    (path / "parts").mkdir()
    (path / "object.toml").write_text(FACTS + 'model = "block.xml"')
    block().export(path / "parts" / "b.stl")
    (path / "parts" / "assets.xml").write_text(
        "<mujocoinclude><compiler meshdir='parts'/><asset><mesh file='b.stl'/></asset>"
        "</mujocoinclude>"
    )
    (path / "parts" / "geom.xml").write_text("<mujoco><geom type='mesh' mesh='b'/></mujoco>")
    assert info_of(path).extents_m == pytest.approx((A, B, C), abs=1e-8)
    before = user_object(path).reference.sha256
    (path / "parts" / "geom.xml").write_text("<mujoco><geom mesh='b' type='mesh'/></mujoco>")
    assert user_object(path).reference.sha256 != before
    (path / "parts" / "geom.xml").unlink()
    (path / "parts" / "geom.xml").symlink_to("/etc/passwd")
    assert "is a link that leads out of this folder" in refusal(path)
    (path / "parts" / "geom.xml").unlink()
    (path / "parts" / "geom.xml").write_text("<html/>")
    assert "includes 'parts/geom.xml', whose root is <html>" in refusal(path)


def test_included_files_add_up_to_the_bounds(tmp_path):
    path = folder(tmp_path, "".join(f"<include file='{k}.xml'/>" for k in range(3)))
    for k in range(3):
        (path / f"{k}.xml").write_text(f"<mujoco>{'<option/>' * 900}</mujoco>")
    (path / "object.toml").write_text(FACTS + 'model = "block.xml"')
    assert "has more than 2000" in refusal(path)
    for k in range(70):
        (path / f"{k}.xml").write_text(f"<mujoco><include file='{k + 1}.xml'/></mujoco>")
    assert "takes more than 65 files" in refusal(path)


MESH = "<worldbody><body><geom type='mesh' mesh='b'/></body></worldbody>"
ATTRIBUTES = {
    "scale": "scale='0.5 0.5 1'",
    "mirrored": "scale='-1 1 1'",
    "refpos": "refpos='0.01 0.02 0.03'",
    "refquat": "refquat='1 0 0 1'",
    "all": "refpos='0.01 0.02 0.03' refquat='1 1 0 0' scale='0.5 0.6 0.7'",
    "inertia": "inertia='convex'",
    "few": "maxhullvert='4'",
}


@pytest.mark.parametrize(
    ("name", "where"),
    # MuJoCo has no default of refpos and refquat.
    [(name, "mesh") for name in ATTRIBUTES]
    + [(name, "default") for name, text in ATTRIBUTES.items() if "ref" not in text],
)
def test_attributes_of_a_mesh_mean_what_they_mean_to_mujoco(tmp_path, name, where):
    attributes = ATTRIBUTES[name]
    shape = trimesh.creation.cone(0.05, 0.12, sections=12)
    inside = f"<asset><mesh name='b' file='b.stl' {attributes}/></asset>{MESH}"
    if where == "default":
        inside = f"<default><mesh {attributes}/></default>"
        inside += f"<asset><mesh name='b' file='b.stl'/></asset>{MESH}"
    path = folder(tmp_path, inside, b=shape)
    wanted = mujoco.MjModel.from_xml_path(str(path / "block.xml"))
    found, _ = shape_of(path)
    points = in_order(collision_vertices(found))
    assert points == pytest.approx(in_order(collision_vertices(wanted)), abs=1e-7)
    assert len(points) == (4 if name == "few" else 13)
    assert found.body_ipos[1] == pytest.approx(wanted.body_ipos[1], abs=1e-7)
    assert found.body_inertia[1] == pytest.approx(wanted.body_inertia[1], rel=1e-4)


@pytest.mark.parametrize("name", ["scale", "mirrored", "refpos", "refquat", "all"])
def test_a_mesh_of_several_parts_is_divided_where_it_stands(tmp_path, name):
    """Two blocks in one mesh file are two geoms, where MuJoCo would have their common hull."""
    both = trimesh.util.concatenate(
        [block((0, 0, 0), (0.06, 0.06, 0.06)), block((0.03, 0.03, 0.06), (0.06, 0.06, 0.06))]
    )
    mesh = f"<asset><mesh name='b' file='b.stl' {ATTRIBUTES[name]}/></asset>{MESH}"
    path = folder(tmp_path, mesh, b=both)
    found, notes = shape_of(path)
    assert found.ngeom == 2
    assert notes == ("b: divided into 2 convex parts",)
    volume = 2 * 0.06**3 * (0.5 * 0.6 * 0.7 if name == "all" else 0.25 if name == "scale" else 1)
    assert found.body_mass[1] == pytest.approx(1000 * volume, rel=1e-5)
    one = mujoco.MjModel.from_xml_path(str(path / "block.xml"))
    rotation = rotation_of(one.geom_quat[0])
    corners = one.mesh_vert @ rotation.T + one.geom_pos[0]
    points = collision_vertices(found)
    assert points.min(axis=0) == pytest.approx(corners.min(axis=0), abs=1e-7)
    assert points.max(axis=0) == pytest.approx(corners.max(axis=0), abs=1e-7)


def test_drawn_geoms_of_a_divided_mesh_stay_one(tmp_path):
    both = trimesh.util.concatenate([block(), block((A, B, 0))])
    text = (
        "<default><default class='v'><geom group='2' type='mesh' contype='0' conaffinity='0'/>"
        "</default><default class='c'><geom group='3' type='mesh'/></default></default>"
        "<asset><mesh file='b.stl'/></asset><worldbody><body>"
        "<geom mesh='b' class='v'/><geom mesh='b' class='c'/></body></worldbody>"
    )
    found = user_object(folder(tmp_path, text, b=both))
    model = found.spec.compile()
    assert (found.parts, model.ngeom) == (2, 3)
    assert np.count_nonzero(model.geom_contype) == 2


def test_an_open_mesh_is_taken_as_its_hull_when_asked_for(tmp_path):
    mesh = block()
    mesh.update_faces(np.arange(11))
    text = f"<asset><mesh file='b.stl'/></asset>{MESH}"
    assert "hull = true" in refusal(folder(tmp_path, text, b=mesh))
    path = folder(tmp_path / "b", text, FACTS + "hull = true", b=mesh)
    assert "b: not closed: mass distribution from the hull" in user_object(path).reference.notes
    wanted = 0.4 / 12 * np.diag([B * B + C * C, A * A + C * C, A * A + B * B])
    assert info_of(path).inertia_kgm2 == pytest.approx(wanted, abs=1e-8)


def test_vertices_in_the_file_itself(tmp_path):
    corners = " ".join(f"{v:g}" for v in np.array(block().vertices).reshape(-1))
    text = f"<asset><mesh name='b' vertex='{corners}'/></asset>{MESH}"
    assert info_of(folder(tmp_path, text)).extents_m == pytest.approx((A, B, C), abs=1e-8)
    faces = " ".join(str(v) for v in np.array(block().faces).reshape(-1))
    text = f"<asset><mesh name='b' vertex='{corners}' face='{faces}'/></asset>{MESH}"
    assert info_of(folder(tmp_path / "b", text)).extents_m == pytest.approx((A, B, C), abs=1e-8)


def test_strippath_leaves_the_folders_of_a_file_out(tmp_path):
    text = f"<compiler strippath='true'/><asset><mesh file='/home/me/b.stl'/></asset>{MESH}"
    assert info_of(folder(tmp_path, text, b=block())).height == pytest.approx(C)


@pytest.mark.parametrize(
    ("attributes", "mass"),
    [("", None), ("density='250'", 250 * A * B * C), ("mass='0.3'", 0.3), ("density='1000'", None)],
)
def test_the_mass_that_a_file_states_is_known(tmp_path, attributes, mass):
    geoms = f"<geom {attributes} type='box' size='0.03 0.04 0.06'/>"
    geoms += "<geom density='7' type='box' size='0.01 0.01 0.01' contype='0' conaffinity='0'/>"
    path = folder(tmp_path, f"<worldbody><body>{geoms}</body></worldbody>")
    assert user_object(path).stated_mass == (None if mass is None else pytest.approx(mass))
    assert info_of(path).mass_kg == 0.4
