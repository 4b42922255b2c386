"""What the pages on the source say: the picture is drawn from it, its names and rooms exist."""

from __future__ import annotations

import importlib
import re
import tomllib
import xml.etree.ElementTree as ET

import pytest

from experiments import data_flow_picture as flow
from tests.support.repository import ROOT

ROOMS = sorted(p.parent.name for p in (ROOT / "sdh_sim").glob("*/__init__.py"))
MADE = [made for room in (*flow.TRIAL, *flow.RUN, *flow.BELOW) for made in room.made if ":" in made]


def test_the_picture_is_what_the_command_draws(tmp_path):
    flow.main(["--out", str(tmp_path / "new.svg")])
    new = (tmp_path / "new.svg").read_text(encoding="utf-8")
    assert new == flow.PICTURE.read_text(encoding="utf-8"), f"run python -m {flow.__name__}"
    ET.fromstring(new)


@pytest.mark.parametrize("made", MADE)
def test_what_a_room_makes_exists(made):
    module, _, name = made.partition(":")
    assert hasattr(importlib.import_module(module), name)


def test_the_picture_has_every_room_that_data_pass():
    drawn = {room.name for room in (*flow.TRIAL, *flow.RUN, *flow.BELOW)}
    # What reads files of users has done so before a trial begins; few runs ask for settling.
    assert drawn == {*ROOMS, "graspq"} - {"cli", "modelgen", "user_files", "settling"}


def test_the_table_of_rooms_is_complete():
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    table = text.split("## Rooms of sdh_sim\n")[1].split("\n\n`sensing` lies")[0]
    listed = re.findall(r"^\| [0-9]* ?\| `(\w+)` \|", table, re.MULTILINE)
    assert sorted(listed) == ROOMS


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/architecture.md"])
def test_the_files_that_a_page_names_exist(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w./]+/[\w./]*\w|[\w]+\.py)`", text))
    named -= {name for name in named if "NAME" in name}
    places = (ROOT, ROOT / "sdh_sim")
    missing = sorted(n for n in named if not any((place / n).exists() for place in places))
    assert not missing


def test_what_the_tests_run_on_is_what_the_package_names():
    with open(ROOT / "pyproject.toml", "rb") as file:
        classifiers = tomllib.load(file)["project"]["classifiers"]
    named = re.findall(r"Python :: (3\.\d+)", "\n".join(classifiers))
    workflow = ROOT / ".github/workflows/ci.yml"
    if not workflow.is_file():
        pytest.skip("an sdist has no dot-files")
    assert re.findall(r'"(3\.\d+)"', workflow.read_text(encoding="utf-8")) == named
