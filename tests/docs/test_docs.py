"""What the documentation says: code runs, the dataset card is complete, commands exist."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main
import yaml

from sdh_sim import __version__
from sdh_sim.campaign import run_campaign
from sdh_sim.cli.app import app
from sdh_sim.records import COLUMNS, TrialRow, normalise, read_rows
from sdh_sim.runs import RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial
from tests.support.doc_blocks import blocks, words
from tests.support.repository import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
WITH_CODE = [page for page in PAGES if blocks(page)]
OF_EXPERIMENTS = {"--short", "--out", "--reasons", "--only"}
TYPES = {"double": "float64", "float": "float32"}  # arrow's names to NumPy's


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A working folder with the run that pages read."""
    path = tmp_path_factory.mktemp("docs")
    plan = RunPlan(("cylindrical_bottle",), TrialSettings("cylindrical_bottle"), trials=5, seed=0)
    run_campaign(plan, path / "runs" / "cyl", workers=1)
    return path


@pytest.mark.parametrize("page", WITH_CODE, ids=name)
def test_the_code_of_a_page_runs_and_prints_what_it_shows(page, folder):
    # A process of its own, as a reader's would be: MuJoCo reads once how to draw, at its import.
    result = subprocess.run(
        [sys.executable, "-m", "tests.support.doc_blocks", str(page)],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr[-3000:]
    for block, printed in zip(blocks(page), json.loads(result.stdout), strict=True):
        if block.shown is not None:
            assert words(printed) == words(block.shown), f"{name(page)}:{block.line}\n{printed}"


def test_pages_with_code_are_found():
    assert {"README.md", "docs/library.md", "docs/trials.md"} <= {name(p) for p in WITH_CODE}
    shown = [b for b in blocks(ROOT / "docs/library.md") if b.shown]
    assert len(shown) >= 5


def card() -> list[list[str]]:
    """The rows of the card's tables of columns."""
    text = (ROOT / "docs/trials.md").read_text(encoding="utf-8")
    section = text.split("## Columns\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `(.*) \|$", section, re.MULTILINE)
    return [[cell.strip() for cell in ("`" + row).split(" |")] for row in rows]


def test_the_card_describes_every_column_of_the_table_and_no_other():
    described = [row[0].strip("`") for row in card()]
    assert sorted(described) == sorted(column.name for column in COLUMNS)


@pytest.mark.parametrize("column", COLUMNS, ids=lambda column: column.name)
def test_the_card_agrees_with_the_schema(column):
    (row,) = (row for row in card() if row[0] == f"`{column.name}`")
    _, kind, shape, unit, meaning, filled = row
    assert kind == TYPES.get(str(column.type), str(column.type))
    assert shape == "×".join(str(n) for n in column.shape)
    assert unit == column.unit
    assert len(meaning) > 8
    assert filled == "always" if column.required else filled


FREE = {"volume_linf", "volume_l1"}  # null above three contacts


def filled(row: TrialRow) -> set[str]:
    return {column for column, value in row.items() if value is not None} - FREE


def said(*words_of: str) -> set[str]:
    """Columns that the card says are filled by one of these."""
    found = {r[0].strip("`") for r in card() if any(w in r[5] for w in words_of)}
    return found - FREE


def test_the_card_knows_what_fills_each_column(folder):
    lifted = said("always", "snapshot", "lift")
    rows = read_rows(folder / "runs/cyl/trials.parquet")
    assert {row["success"] for row in rows} == {True, False}, "take more trials"
    assert all(filled(row) == lifted for row in rows)
    missing = TrialSettings("cylindrical_bottle", grasps="precision")
    row = normalise({**run_trial(missing, 53).row, "trial": 0})
    assert row["failure"] == "no_contact", "take another seed"
    assert filled(row) == said("always", "snapshot") < lifted


def test_the_card_knows_what_options_fill():
    settings = TrialSettings(
        "cylindrical_bottle", load_test="directions", disturbance="shake", repeats=1
    )
    row = normalise({**run_trial(settings, 1).row, "trial": 0})
    assert row["failure"] == "none", "take another seed"
    elsewhere = said("--preset paper", "--support none", "`infeasible`", "--grasps FILE")
    assert filled(row) == {column.name for column in COLUMNS} - FREE - elsewhere


def test_the_card_knows_what_a_scene_without_a_table_fills():
    settings = TrialSettings(
        "cylindrical_bottle", arm="none", support="none", gravity="six", load_test="gravity"
    )
    row = normalise({**run_trial(settings, 1).row, "trial": 0})
    assert row["failure"] != "no_contact", "take another seed"
    loaded = {"q_sim", "q_sim_capped"}
    assert filled(row) == said("always", "snapshot", "lift", "--support none") | loaded


def commands(page: Path) -> list[str]:
    """Commands on lines of their own and in backquotes."""
    text = page.read_text(encoding="utf-8")
    lines = re.findall(
        r"^ *(?:\S+/)?(sdh-sim [a-z].*?|python -m experiments\..*?)(?:#.*)?$", text, re.MULTILINE
    )
    return [*lines, *re.findall(r"`(sdh-sim [a-z][^`\n]*|python -m experiments\.[^`\n]*)`", text)]


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_the_commands_of_a_page_exist(page):
    known = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    for line in commands(page):
        words_of = shlex.split(line)
        if words_of[0] == "python":
            place = ROOT / words_of[2].replace(".", "/")
            files = (place.with_suffix(".py"), place / "__main__.py")
            assert place.name == "NAME" or any(file.is_file() for file in files), line
            continue
        assert words_of[1] in known, line
        options = {o for p in known[words_of[1]].params for o in (*p.opts, *p.secondary_opts)}
        used = {w.split("=")[0] for w in words_of[2:] if w.startswith("--")}
        assert used <= options | {"--help"}, line


def test_the_options_named_in_the_text_exist():
    known = typer.main.get_command(app).commands.values()  # type: ignore[attr-defined]
    options = {o for command in known for p in command.params for o in p.opts}
    for page in (
        ROOT / "docs/quickstart.md",
        ROOT / "docs/protocol.md",
        ROOT / "docs/trials.md",
        ROOT / "docs/report.md",
        ROOT / "docs/model.md",
        ROOT / "docs/limits.md",
    ):
        text = page.read_text(encoding="utf-8")
        for option in re.findall(r"`(--[a-z-]+)[^`]*`", text):
            assert option in options | OF_EXPERIMENTS, (name(page), option)


def test_citation_file():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == __version__
    assert cited["license"] == "MIT"
    (paper,) = cited["references"]
    assert [a["family-names"] for a in paper["authors"]] == ["Krug", "Bekiroglu", "Roa"]
