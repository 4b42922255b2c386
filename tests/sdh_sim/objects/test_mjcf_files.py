"""MJCF files: shapes against closed forms, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.object_files import A, B, C, info_of, object_folder, refusal

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
    obj = info_of(object_folder(tmp_path, MJCF.format(f"<geom {geom}/>"), ending="xml"))
    assert obj.extents_m == pytest.approx(extents, abs=1e-9)
    assert obj.inertia_kgm2 == pytest.approx(0.4 * np.diag(moments), abs=1e-9)
    assert obj.height == pytest.approx(extents[2])


def test_a_tilted_cylinder_stands_on_its_edge_and_not_on_its_box(tmp_path):
    # Tilted by 30 degrees, its top edge is at r sin 30 + h cos 30; a foot keeps it upright.
    geoms = (
        '<geom type="cylinder" size="0.03 0.04" pos="0 0 0.1" euler="30 0 0"/>'
        '<geom type="box" size="0.05 0.05 0.02" pos="0 0 0.02"/>'
    )
    obj = info_of(object_folder(tmp_path, MJCF.format(geoms), ending="xml"))
    assert obj.height == pytest.approx(0.1 + 0.03 * 0.5 + 0.04 * np.sqrt(0.75), abs=2e-5)


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
    ("<asset><mesh file='../block.stl'/></asset>", "not the name of a file in this folder"),
    ("<asset><mesh file='block.msh'/></asset>", "must be STL, OBJ, PLY, OFF or GLB"),
    ("<asset><mesh file='a.stl' content_type='x'/></asset>", "'content_type' of <mesh>"),
    ("<compiler meshdir='/etc'/><asset><mesh file='a.stl'/></asset>", "in this folder"),
    ("<compiler meshdir='..'/><asset><mesh file='block/a.stl'/></asset>", "in this folder"),
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
    inside, *messages = case
    if "<asset>" in inside:
        inside += "<worldbody><body><geom size='0.04'/></body></worldbody>"
    text = refusal(object_folder(tmp_path, f"<mujoco>{inside}</mujoco>", ending="xml"))
    for message in messages:
        assert message in text


def test_entities_are_not_expanded(tmp_path):
    levels = "".join(
        f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' if k else '<!ENTITY a0 "x">' for k in range(12)
    )
    bomb = f'<!DOCTYPE mujoco [{levels}]><mujoco model="&a11;"/>'
    assert "declares a document type" in refusal(object_folder(tmp_path, bomb, ending="xml"))
    outside = '<!DOCTYPE mujoco [<!ENTITY a SYSTEM "file:///etc/passwd">]><mujoco>&a;</mujoco>'
    assert "declares a document type" in refusal(object_folder(tmp_path, outside, ending="xml"))
