"""The page docs/grasps.md: its commands run and print what it shows, its example is the file's."""

from __future__ import annotations

import re

import pyarrow.parquet as pq
import yaml

from sdh_sim.cli.app import main
from sdh_sim.grasp_files import read_grasps
from sdh_sim.grasp_files.grasp_entry import COLUMNS
from tests.support.doc_blocks import shown_commands
from tests.support.repository import ROOT

PAGE = ROOT / "docs" / "grasps.md"
EXAMPLES = ROOT / "docs" / "examples"


def words(text: str) -> list[str]:
    """Words and whole numbers; no speeds and shares, which differ by machine."""
    return re.findall(r"[A-Za-z_./]{2,}|(?<![\d.])\d+(?![\d.])", text)


def test_the_commands_do_what_the_page_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    commands = shown_commands(PAGE)
    assert [arguments[0] for arguments, _ in commands] == ["lift", "grasps", "lift"]
    for arguments, shown in commands:
        assert main(arguments) == 0
        printed = capsys.readouterr().out
        assert not shown or words(printed) == words(shown), printed
    held = [entry.name for entry in read_grasps("runs/held.csv")]
    assert held == [entry.name for entry in read_grasps(EXAMPLES / "box_grasps.csv", ["box"])[:3]]
    rows = pq.read_table("runs/isaac/trials.parquet", columns=["grasp_name", "grasp_confidence"])
    assert rows.to_pydict() == {
        "grasp_name": ["from above", "from above and far aside"],
        "grasp_confidence": [0.9, 0.4],
    }


def test_the_yaml_of_the_page_is_the_beginning_of_the_example():
    shown = re.search(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert shown is not None
    text = (EXAMPLES / "box_grasps.yaml").read_text(encoding="utf-8")
    assert text.startswith(shown[1])
    assert set(yaml.safe_load(shown[1])["grasps"]) == {"from above"}


def test_the_page_has_every_column():
    text = PAGE.read_text(encoding="utf-8").split("## A table\n")[1].split("\n## ")[0]
    named = set(re.findall(r"`(\w+)`", text))
    ends = {"open_spread", "open_finger1_distal", "closed_spread", "closed_finger1_distal"}
    short = {name for name in COLUMNS if not name.startswith(("open_", "closed_"))} | ends
    assert short <= named
