"""Sets of objects in the layouts that others publish."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from experiments import objects_of_others
from experiments.object_sets import Assumed, find_candidates, load
from sdh_sim.errors import SettingsError
from tests.support.object_files import block

ASSUMED = Assumed(mass=0.3, friction=0.5, scale=1.0, up="z", shape="hull")
MJCF = """<mujoco><asset><mesh file="meshes/{}.stl"/><texture type="2d" name="t" file="../t.png"/>
<material name="m" texture="t"/></asset><worldbody><body><body name="object">
<geom type="mesh" mesh="{}" material="m" density="{}" solref="0.001 1"/></body></body></worldbody>
</mujoco>"""


def mjcf_set(place: Path) -> Path:
    """Files of MJCF beside a folder of meshes, as robosuite has them."""
    (place / "meshes").mkdir(parents=True)
    for name in ("box", "ring"):
        shape = block() if name == "box" else trimesh.creation.annulus(0.02, 0.04, 0.1)
        shape.export(place / "meshes" / f"{name}.stl")
        (place / f"{name}.xml").write_text(MJCF.format(name, name, 100))
    (place / "door.xml").write_text(
        "<mujoco><worldbody><body><joint type='hinge'/><geom size='0.05'/></body></worldbody>"
        "</mujoco>"
    )
    return place


def folders_set(place: Path) -> Path:
    """A folder for each object with its meshes below, as YCB and Google Scanned Objects have it."""
    for name, below in (("003_cracker_box", "google_16k"), ("Toy-Cup 2", "meshes")):
        (place / name / below).mkdir(parents=True)
        mesh = block()
        if below == "google_16k":
            (place / name / "poisson").mkdir()
            block(size=(0.2, 0.2, 0.2)).export(place / name / "poisson" / "a.stl")
            mesh.export(place / name / below / "nontextured.stl")
        else:
            mesh.export(place / name / below / "model.obj")
    (place / "README.txt").write_text("not an object")
    return place


def test_objects_are_found_in_every_layout(tmp_path):
    found = find_candidates(mjcf_set(tmp_path / "mjcf"))
    # The name of a built-in object is taken.
    assert [(c.name, c.file.name) for c in found] == [
        ("box_2", "box.xml"),
        ("door", "door.xml"),
        ("ring", "ring.xml"),
    ]
    folders = folders_set(tmp_path / "folders")
    found = find_candidates(folders)
    assert [(c.name, c.file.relative_to(c.root).as_posix()) for c in found] == [
        ("object_003_cracker_box", "google_16k/nontextured.stl"),
        ("Toy-Cup_2", "meshes/model.obj"),
    ]
    block().export(tmp_path / "folders" / "Toy-Cup 2" / "meshes" / "a.stl")
    assert find_candidates(folders)[1].file.name == "model.obj"
    assert [c.name for c in find_candidates(tmp_path / "mjcf" / "meshes")] == ["box_2", "ring"]


def test_what_a_set_does_not_say_is_assumed_and_told(tmp_path):
    source = mjcf_set(tmp_path / "set")
    before = sorted((p, p.read_bytes()) for p in source.rglob("*") if p.is_file())
    box, door, ring = find_candidates(source)
    found = load(box, ASSUMED, tmp_path / "own")
    assert found.mass == pytest.approx(100 * 0.06 * 0.08 * 0.12)
    assert found.notes == ()
    found = load(ring, ASSUMED, tmp_path / "own")
    assert found.notes == ("hull = true",)
    with pytest.raises(SettingsError, match="take the joint out"):
        load(door, ASSUMED, tmp_path / "own")
    with pytest.raises(SettingsError, match="is not convex"):
        load(ring, Assumed(0.3, 0.5, 1.0, "z", "refuse"), tmp_path / "other")
    (source / "box.xml").write_text(MJCF.format("box", "box", 1e-3))
    found = load(box, ASSUMED, tmp_path / "third")
    assert found.mass == 0.01
    assert found.notes == ("the file says 5.8e-07 kg",)
    (source / "box.xml").write_text(MJCF.format("box", "box", 100))
    assert sorted((p, p.read_bytes()) for p in source.rglob("*") if p.is_file()) == before


def test_an_object_that_falls_over_is_taken_in_its_nearest_stable_pose(tmp_path):
    leaning = block((0.0, 0.0, 0.06))
    leaning.vertices[:, 0] += leaning.vertices[:, 2]
    leaning.export(tmp_path / "leaning.stl")
    [candidate] = find_candidates(tmp_path)
    found = load(candidate, ASSUMED, tmp_path / "own")
    assert found.notes == ('pose = "stable:1"',)
    assert found.mass == 0.3


def test_one_line_for_each_object(tmp_path, capsys):
    source = mjcf_set(tmp_path)
    (source / "ring.xml").unlink()
    objects_of_others.main([str(source), "--trials", "2"])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("box_2  loaded, 0.058 kg, 1 collision shape, lifted ")
    assert " of 2 (" in lines[0]
    assert lines[1].startswith("door   not loaded: door.xml has 'hinge' as 'type' of <joint>")
    assert lines[2] == "1 of 2 loaded"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "cannot read nowhere: No such file or directory"),
        ([".", "--trials", "-1"], "--trials must be at least 0, got -1"),
        ([".", "--mass", "9"], "--mass must be 0.01 to 5 kg, got 9"),
        ([".", "--shape", "round"], "invalid choice"),
        (["{empty}"], "holds no MJCF, no mesh and no folder with one"),
    ],
)
def test_what_cannot_be_used_is_one_line(tmp_path, capsys, arguments, message):
    (tmp_path / "empty").mkdir()
    arguments = [a.format(empty=tmp_path / "empty") for a in arguments]
    with pytest.raises(SystemExit) as caught:
        objects_of_others.main(arguments)
    error = capsys.readouterr().err
    assert caught.value.code == 2
    assert message in error
    assert len(error.splitlines()) == 1
