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
    ("<worldbody/>", "no geom in its worldbody"),
    ("<include file='/etc/passwd'/>", "not the name of a file in this folder"),
    ("<include file='../a.xml'/>", "not the name of a file in this folder"),
    ("<include file='block.xml'/>", "includes 'block.xml' twice"),
    ("<include file='object.toml'/>", "includes 'object.toml', which is not XML"),
    ("<include/>", "is not the name of a file"),
    ("<extension><plugin plugin='a.b'/></extension>", "<extension>", "run other code"),
    ("<actuator/>", "<actuator>"),
    ("<equality/>", "<equality>", "it would tie the object to something"),
    ("<tendon/>", "<tendon>"),
    ("<deformable/>", "objects are rigid"),
    ("<asset><model file='a.xml'/></asset>", "it would read another model"),
    ("<asset><hfield name='h' file='x.png'/></asset>", "<hfield>"),
    ("<asset><mesh file='/etc/passwd.stl'/></asset>", "not the name of a file in this folder"),
    ("<asset><mesh file='../block.stl'/></asset>", "not the name of a file in this folder"),
    ("<asset><mesh file='block.dae'/></asset>", "its name must end in one of .stl, .obj"),
    ("<asset><mesh name='m' builtin='sphere'/></asset>", "write the mesh to a file"),
    ("<asset><mesh name='m' vertex='0 0 0 1'/></asset>", "vertex or face is not in threes"),
    ("<asset><mesh name='m' vertex='0 0 0' face='0 1 2'/></asset>", "a vertex that it lacks"),
    ("<asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0'/></asset>", "flat"),
    ("<asset><mesh vertex='0 0 0'/></asset>", "neither name nor file"),
    ("<compiler meshdir='/etc'/><asset><mesh file='a.stl'/></asset>", "in this folder"),
    ("<compiler meshdir='..'/><asset><mesh file='block/a.stl'/></asset>", "in this folder"),
    ("<worldbody>" + 2 * "<body><freejoint/><geom/></body>" + "</worldbody>", "2 bodies that move"),
    ("<worldbody><body><freejoint/><geom/></body><geom/></worldbody>", "beside what is fixed"),
    ("<worldbody><body><joint type='hinge'/><geom/></body></worldbody>", "take the joint out"),
    ("<worldbody><body><joint/><geom/></body></worldbody>", "take the joint out"),
    ("<worldbody><body><geom/><body><freejoint/></body></body></worldbody>", "inside another"),
    ("<worldbody><body mocap='true'><geom/></body></worldbody>", "the scene moves the object"),
    ("<worldbody><body gravcomp='1'><geom/></body></worldbody>", "take gravcomp out"),
    ("<worldbody><body><plugin/><geom/></body></worldbody>", "run other code"),
    ("<worldbody><replicate count='2'><geom/></replicate></worldbody>", "write the copies out"),
    ("<worldbody><body><geom type='plane' size='1 1 1'/></body></worldbody>", "'plane'"),
    ("<default><geom type='plane'/></default><worldbody><body><geom/></body></worldbody>",
     "has a plane in a body"),
    ("<worldbody><body><geom type='box' size='20 20 20'/></body></worldbody>",
     "its numbers look like millimetres (40 mm) or centimetres (400 mm)"),
    ("<worldbody><body><geom type='sdf'/></body></worldbody>", "'sdf'"),
    ("<worldbody><body><geom size='nan'/></body></worldbody>", "finite numbers"),
    ("<worldbody><body><geom size='1 2 3 4'/></body></worldbody>", "finite numbers"),
    ("<worldbody><body><geom mass='a'/></body></worldbody>", "'mass' of <geom>"),
    ("<worldbody><body><geom colour='1 1'/></body></worldbody>", "'colour' of <geom>"),
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
