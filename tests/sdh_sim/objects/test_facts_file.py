"""``object.toml``: every key is taken, every wrong value is refused."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.objects import DEFAULT_SPREAD, Spread
from tests.support.object_files import FACTS, block, info_of, object_folder, refusal


def test_what_object_toml_gives_is_taken(tmp_path):
    facts = FACTS + (
        'name = "tin"\ncom = [0.001, -0.002, 0.01]\ninertia = [1e-3, 9e-4, 6e-4, 1e-5, 0, -2e-5]\n'
        'scale = 0.001\nup = "y"\n[grasp]\nside = 0.2\nyaw = 0.1\n'
    )
    obj = info_of(object_folder(tmp_path, block(size=(60, 80, 120)), facts))
    assert obj.name == "tin"
    assert obj.com_m == pytest.approx((0.001, -0.002, 0.01))
    wanted = np.array([[1e-3, 1e-5, 0], [1e-5, 9e-4, -2e-5], [0, -2e-5, 6e-4]])
    assert obj.inertia_kgm2 == pytest.approx(wanted, abs=1e-10)
    assert obj.height == pytest.approx(0.08)
    assert obj.spread == Spread(0.2, DEFAULT_SPREAD.wide, DEFAULT_SPREAD.offset, 0.1)


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
    (FACTS + 'pose = "stable:0"', 'give "stable:1" to "stable:50"'),
    (FACTS + "pose = 1", 'give "stable:1" to "stable:50"'),
    (FACTS + 'pose = "stable:9"', "pose is 'stable:9'; it has 6 stable poses"),
    (FACTS + "decompose = 1", "decompose is 1; give true or false"),
    (FACTS + "hull = true\ndecompose = true", "hull and decompose are both true; choose one"),
    (FACTS + 'name = "all"', "the name 'all' cannot be used"),
    (FACTS + 'name = "a/b"', "the name 'a/b' cannot be used"),
    (FACTS + 'name = "a b"', "cannot be used"),
    (FACTS + 'name = "\\u001b[2J"', "cannot be used"),
    (FACTS + 'model = "/etc/passwd"', "its name must end in one of"),
    (FACTS + 'model = "/etc/passwd.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "../block/block.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "assets/../block.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "~/block.stl"', "is not the name of a file in this folder"),
    (FACTS + 'model = "other.stl"', "cannot read 'other.stl': No such file"),
    (FACTS + "scale = 1000", "set scale for its unit, metres (scale = 1, 120 mm)"),
    (FACTS + "scale = 0", "scale is 0; give a number"),
]


@pytest.mark.parametrize(("facts", "message"), BAD_TOML)
def test_object_toml_is_refused_in_words(tmp_path, facts, message):
    path = object_folder(tmp_path)
    (path / "object.toml").write_bytes(facts.encode("utf-8", "surrogateescape"))
    assert message in refusal(path)
