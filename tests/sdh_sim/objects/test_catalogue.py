"""Objects by name and by folder."""

from __future__ import annotations

import re
import shutil

import pytest

from sdh_sim.errors import SettingsError
from sdh_sim.model_files import models_dir
from sdh_sim.objects import (
    ObjectInfo,
    find_objects,
    object_info,
    object_names,
    object_spec,
    user_object,
)
from tests.support.object_files import FACTS, MUG, block, info_of, object_folder


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
    mine = info_of(path)
    for field in ObjectInfo.__dataclass_fields__:
        if field not in ("name", "spread", "folder"):
            assert getattr(mine, field) == pytest.approx(getattr(known, field), abs=1e-8), field


def test_names_and_folders_are_told_apart(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = object_folder(tmp_path)
    names, folders = find_objects(["all", "block", "./block", str(path), "box"], {})
    assert names == (*object_names(), "block")
    assert folders == {"block": user_object(path).reference}
    other = object_folder(tmp_path / "b", block(size=(0.05, 0.05, 0.1)))
    with pytest.raises(SettingsError, match="are both 'block'; set another name"):
        find_objects([str(path), str(other)], {})
    (path / "object.toml").write_text(FACTS + 'name = "box"')
    with pytest.raises(SettingsError, match="'box' is a built-in object's"):
        find_objects([str(path)], {})
    with pytest.raises(SettingsError, match="got 'duck'; choose one of box,"):
        find_objects(["duck"], {})
    with pytest.raises(SettingsError, match="No such file"):
        find_objects(["no/where"], {})


def test_specs_are_independent():
    reference = user_object(MUG).reference
    first = object_spec("mug", reference)
    first.body("object").mass = 9.0
    second = object_spec("mug", reference).compile()
    assert second.body("object").mass == pytest.approx(0.35)
