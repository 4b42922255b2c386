"""Folders with a user's object, and how one is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from sdh_sim.errors import ObjectError
from sdh_sim.objects import ObjectInfo, object_info, user_object
from tests.support.repository import ROOT

MUG = ROOT / "docs" / "examples" / "mug"
FACTS = "mass = 0.4\nfriction = 0.6\n"
A, B, C = 0.06, 0.08, 0.12  # sides of the block [m]
BLOCK_INERTIA = 0.4 / 12 * np.diag([B * B + C * C, A * A + C * C, A * A + B * B])  # [kg m^2]


def block(centre=(0.0, 0.0, 0.0), size=(A, B, C)) -> trimesh.Trimesh:
    """A block of a size [m] about a centre [m]."""
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(centre)
    return mesh


def object_folder(tmp_path: Path, shape=None, facts: str = FACTS, ending: str = "stl") -> Path:
    """A folder ``block`` with an object.

    Args:
        tmp_path: where to make it.
        shape: a mesh, a trimesh scene, or the text of a file; None: the block.
        facts: the content of ``object.toml``.
        ending: of the file's name.
    """
    path = tmp_path / "block"
    (path / "assets").mkdir(parents=True, exist_ok=True)
    (path / "object.toml").write_text(facts)
    shape = block() if shape is None else shape
    if isinstance(shape, str):
        (path / f"block.{ending}").write_text(shape)
    else:
        shape.export(path / f"block.{ending}")
    return path


def info_of(path: Path) -> ObjectInfo:
    """What is known of the object of a folder."""
    found = user_object(path)
    return object_info(found.name, found.reference)


def refusal(path: Path) -> str:
    """The message with which a folder is refused: one printable line that names it."""
    with pytest.raises(ObjectError) as caught:
        user_object(path)
    text = str(caught.value)
    assert text.startswith(f"object: {path}: ")
    assert text.isprintable()
    return text
