"""Damaged folders of objects (TOML, MJCF, meshes); ``frame`` says how to run this by hand.

Only ObjectError with one line may come out, within bounded time and memory.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh

from sdh_sim.errors import SettingsError
from sdh_sim.objects import user_object
from tests.fuzz.frame import Target, main, mutated

MEMORY = 6 << 30  # [bytes] of address space: a claim of more must be refused, not tried

TOML = """name = "pot"
mass = 0.4
friction = 0.6
com = [0.0, 0.0, 0.01]
inertia = [1e-3, 1e-3, 5e-4, 0.0, 0.0, 0.0]
scale = 1.0
up = "z"
pose = "stable:1"
hull = false
decompose = false
[grasp]
side = 0.5
wide = 0.2
offset = 0.005
yaw = 0.2
"""
MJCF = """<?xml version="1.0"?>
<mujoco model="pot">
  <compiler angle="degree" meshdir="assets" eulerseq="xyz"/>
  <default>
    <default class="solid"><geom contype="1" conaffinity="1" group="3" rgba="1 0 0 1"/></default>
  </default>
  <asset>
    <mesh name="body" file="body.stl" scale="1 1 1"/>
    <texture type="2d" name="label" file="../label.png"/>
    <material name="red" rgba="1 0 0 1" specular="0.2" texture="label" texrepeat="2 2"/>
  </asset>
  <include file="more.xml"/>
  <worldbody>
    <body name="pot" pos="0 0 0.06">
      <freejoint/>
      <geom name="a" class="solid" type="mesh" mesh="body"/>
      <geom name="b" class="solid" type="cylinder" size="0.02 0.03" pos="0 0 0.03" euler="0 0 30"/>
      <geom name="c" type="box" size="0.02 0.02 0.01" quat="1 0 0 0" contype="0" conaffinity="0"/>
      <geom name="d" type="capsule" size="0.01" fromto="0 0 0 0 0 0.05" material="red"/>
      <geom name="e" type="ellipsoid" size="0.02 0.02 0.03"/>
      <geom name="f" type="sphere" size="0.02" solref="0.01 1" density="300"/>
      <body pos="0 0 0.01" quat="1 0 0 0">
        <geom class="solid" type="box" size="0.02 0.02 0.01"/>
      </body>
      <geom name="g" type="mesh" mesh="two" pos="0 0 0.02"/>
      <light pos="0 0 1"/>
    </body>
  </worldbody>
</mujoco>
"""
MORE = """<mujocoinclude>
  <option timestep="0.001"/>
  <default><mesh scale="1 1 1" maxhullvert="32" inertia="exact"/></default>
  <asset>
    <mesh name="two" file="two.stl" refpos="0 0 0.01" refquat="1 0 0 0"/>
    <mesh name="few" vertex="0 0 0  0.05 0 0  0 0.05 0  0 0 0.05"/>
  </asset>
</mujocoinclude>
"""
MTL = """newmtl red
Kd 1 0.2 0.2
map_Kd label.png
newmtl blue
Kd 0.1 0.2 1
"""
_WORDS = (
    *("nan", "inf", "-inf", "1e308", "-1", "0", "1e-300", "99999999999999999999", "0x1p3", "1 2 3"),
    *(
        "",
        "..",
        "../../etc/passwd",
        "/etc/passwd",
        "object.toml",
        "assets",
        "a" * 3000,
        "\0",
        "\x1b",
    ),
    *("plane", "hfield", "sdf", "mesh", "box", "true", "[]", "{}", "[[1]]", '"x"', "é", "\u202e"),
    *(
        "<include file='/etc/passwd'/>",
        "<plugin plugin='x'/>",
        "<extension/>",
        "<body/>",
        "<geom/>",
    ),
    *(
        "<joint/>",
        "<keyframe/>",
        "<!DOCTYPE a [<!ENTITY b 'c'>]>",
        "&b;",
        "<![CDATA[",
        "<!--",
        "-->",
    ),
    *("<flex/>", "<skin/>", "<replicate count='9999999'><geom/></replicate>", "<composite/>"),
    *("user", "solref", "margin", "density", "mass", "fitscale", "content_type", "<numeric/>"),
    *("more.xml", "pot.xml", "stable:2", "convex", "shell", "two.stl", "m.mtl", "usemtl red"),
    *("<include file='more.xml'/>", "<include file='pot.xml'/>", "<frame pos='0 0 1'>", "</frame>"),
)


def words_changed(text: bytes, rng: np.random.Generator) -> bytes:
    """The text with a few of its words replaced, doubled or dropped."""
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(len(text) + 1))
        end = min(len(text), at + int(rng.integers(0, 12)))
        if rng.integers(2):  # the value between two quotation marks
            start = text.find(b'"', at) + 1
            stop = text.find(b'"', start)
            if 0 < start < stop:
                at, end = start, stop
        word = _WORDS[int(rng.integers(len(_WORDS)))].encode("utf-8", "surrogatepass")
        if rng.integers(2):  # plausible numbers go on where words are refused
            count = max(1, text[at:end].count(b" ") + 1)
            values = rng.choice([0.0, 1.0, -1.0, 0.01, 1e-9, 90.0], count) * rng.normal(1, 0.3)
            word = " ".join(f"{v:.6g}" for v in values).encode()
        text = text[:at] + word + text[end:]
    return text


def meshes() -> dict[str, bytes]:
    """One small mesh in every format."""
    box = trimesh.creation.box((0.06, 0.07, 0.12))
    other = trimesh.creation.icosphere(1, 0.03)
    other.apply_translation((0.0, 0.0, 0.09))
    both = trimesh.Scene([box, other])
    found: dict[str, bytes] = {}
    for ending in ("stl", "obj", "ply", "off", "glb"):
        found[ending] = _bytes(box.export(file_type=ending))
    found["stl ascii"] = _bytes(box.export(file_type="stl_ascii"))
    found["ply ascii"] = _bytes(box.export(file_type="ply", encoding="ascii"))
    found["glb two"] = _bytes(both.export(file_type="glb"))
    lines = found["obj"].replace(b"\nf ", b"\nusemtl red\nf ", 1).split(b"\nf ")
    half = len(lines) // 2
    faces = b"\nf ".join(lines[:half]) + b"\nusemtl blue\nf " + b"\nf ".join(lines[half:])
    found["obj colours"] = b"mtllib m.mtl\n" + faces
    soup = np.concatenate([box.triangles, np.add(box.triangles, (0.06, 0.07, 0.0))])
    found["stl touching"] = _bytes(_soup(soup).export(file_type="stl"))
    shaken = soup[:12] + np.random.default_rng(0).uniform(-1e-8, 1e-8, (12, 3, 3))
    found["stl shaken"] = _bytes(_soup(shaken).export(file_type="stl"))
    counts = np.array([len(box.vertices), 0, 0, len(box.faces)], "<i4").tobytes()
    found["msh"] = counts + box.vertices.astype("<f4").tobytes() + box.faces.astype("<i4").tobytes()
    found["obj two"] = b"o a\n" + found["obj"] + b"o b\n" + found["obj"].replace(b"f ", b"g x\nf ")
    size = struct.unpack_from("<I", found["glb"], 12)[0]
    document = json.loads(found["glb"][20 : 20 + size])
    body = base64.b64encode(found["glb"][28 + size :]).decode()
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + body
    found["gltf"] = json.dumps(document).encode()
    return found


def _soup(corners: np.ndarray) -> trimesh.Trimesh:
    """Triangles from their corners (m, 3, 3), none shared."""
    return trimesh.Trimesh(
        corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=False
    )


def _bytes(data: object) -> bytes:
    if isinstance(data, str):
        return data.encode()
    assert isinstance(data, bytes | bytearray | memoryview)
    return bytes(data)


class DamagedObject(Target):
    """A folder of an object and the ways to damage and read it."""

    refusals = (SettingsError,)

    def __init__(self, path: Path) -> None:
        self.path = path / "pot"
        self.meshes = meshes()
        (self.path / "assets").mkdir(parents=True)

    def damage(self, rng: np.random.Generator) -> str:
        """Write a folder with one damaged file; says which."""
        for old in (*self.path.glob("*.*"), *self.path.glob("assets/*")):
            old.unlink()
        facts, kind = TOML.encode(), str(rng.choice(sorted(self.meshes)))
        change = words_changed if rng.integers(2) else mutated
        match int(rng.integers(10)):
            case 0 | 1:
                facts, what = change(facts, rng), "toml"
                (self.path / "m.stl").write_bytes(self.meshes["stl"])
            case 2 | 3:
                what = "mjcf"
                self.write_mjcf(main=change(MJCF.encode(), rng))
            case 4:
                what = "mjcf include"
                self.write_mjcf(more=change(MORE.encode(), rng))
            case 5:
                what = "mjcf mesh"
                name = str(rng.choice(["body", "two"]))
                self.write_mjcf(**{name: mutated(self.meshes["stl touching"], rng)})
            case 6:
                what = "mtl"
                (self.path / "m.obj").write_bytes(self.meshes["obj colours"])
                (self.path / "m.mtl").write_bytes(change(MTL.encode(), rng))
            case _:
                what = kind
                data = self.meshes[kind]
                binary = kind.split()[0] in ("stl", "ply", "glb", "msh") and "ascii" not in kind
                data = mutated(data, rng) if binary or rng.integers(2) else words_changed(data, rng)
                (self.path / f"m.{kind.split()[0]}").write_bytes(data)
                (self.path / "m.mtl").write_text(MTL)
        if what not in ("toml",) and rng.integers(4):
            # Nothing but the shape decides.
            facts = b'mass = 0.4\nfriction = 0.6\nname = "pot"\n'
            if rng.integers(4):
                facts += b"hull = true\n"
        if (self.path / "pot.xml").exists():
            facts = b'model = "pot.xml"\n' + facts
        (self.path / "object.toml").write_bytes(facts)
        return what

    def write_mjcf(
        self,
        main: bytes = MJCF.encode(),
        more: bytes = MORE.encode(),
        body: bytes | None = None,
        two: bytes | None = None,
    ) -> None:
        """An MJCF with the file that it includes and its meshes."""
        (self.path / "pot.xml").write_bytes(main)
        (self.path / "more.xml").write_bytes(more)
        meshes = {"body": body or self.meshes["stl"], "two": two or self.meshes["stl touching"]}
        for name, data in meshes.items():
            (self.path / "assets" / f"{name}.stl").write_bytes(data)

    def readers(self) -> list[Callable[[], object]]:
        """The one reader of objects, and MuJoCo's compiler after it."""

        def read() -> None:
            model = user_object(self.path).spec.compile()
            assert np.isfinite(model.body_mass).all()
            assert model.nplugin == model.nkey == model.nu == model.njnt == 0

        return [read]

    def check_message(self, text: str) -> None:
        """It says that the object is at fault, and can be printed."""
        assert text.startswith("object: ")
        assert text.isprintable()
        assert len(text) < 1500


if __name__ == "__main__":
    main(DamagedObject, MEMORY)
