"""What is read of a folder, and that nothing else is."""

from __future__ import annotations

import os

from sdh_sim.objects import user_object
from tests.support.object_files import FACTS, block, object_folder, refusal


def test_messages_carry_no_control_characters(tmp_path):
    for name in ("a\u202eb", "\u009b2J"):
        refusal(object_folder(tmp_path, f'<mujoco xmlns="{name}"/>', ending="xml"))
    path = object_folder(tmp_path / "b")
    block().export(path / "a\x1b[2J.stl")
    refusal(path)
    (path / "block.stl").unlink()
    assert "is not the name of a file in this folder" in refusal(path)


def test_links_and_pipes_lead_nowhere(tmp_path):
    secret = tmp_path / "secret.stl"
    block().export(secret)
    path = object_folder(tmp_path)
    (path / "block.stl").unlink()
    (path / "block.stl").symlink_to(secret)
    assert "is a link that leads out of this folder" in refusal(path)
    (path / "block.stl").unlink()
    (path / "block.stl").symlink_to("block.stl")
    assert "cannot read 'block.stl'" in refusal(path)
    (path / "block.stl").unlink()
    os.mkfifo(path / "block.stl")
    assert "is not a file" in refusal(path)
    (path / "block.stl").unlink()
    (path / "block.stl").mkdir()
    assert "cannot read" in refusal(path)
    (path / "block.stl").rmdir()
    block().export(path / "assets" / "real.stl")
    (path / "block.stl").symlink_to("assets/real.stl")  # inside is fine
    assert user_object(path).parts == 1


def test_the_number_of_files_is_bounded(tmp_path):
    path = object_folder(tmp_path)
    for k in range(1001):
        (path / f"{k}.txt").touch()
    assert "more than 1000 files" in refusal(path)
    path = object_folder(tmp_path / "b")
    block().export(path / "second.stl")
    assert "say in object.toml which is the object: model =" in refusal(path)


def test_the_digest_is_of_what_makes_the_object(tmp_path):
    path = object_folder(tmp_path)
    before = user_object(path).reference.sha256
    (path / "README.md").write_text("mine")
    assert user_object(path).reference.sha256 == before
    moved = path.rename(tmp_path / "moved")
    (moved / "object.toml").write_text(FACTS + 'name = "block"')
    other = user_object(moved).reference.sha256
    assert other != before
    block(size=(0.06, 0.08, 0.121)).export(moved / "block.stl")
    assert user_object(moved).reference.sha256 not in (before, other)
