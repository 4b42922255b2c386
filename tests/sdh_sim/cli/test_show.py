"""``show``: trials of a run again, their recording or picture, and what differs."""

from __future__ import annotations

import json
import sys
import types
from collections.abc import Iterator
from pathlib import Path

import pytest

from sdh_sim.cli.app import main
from sdh_sim.records import read_rows, write_rows
from tests.support import trial_stand_ins as stand_ins
from tests.support.command_line import fails, use_trial


def test_show_refuses(run, tmp_path, capsys, quick):
    assert "has trials 0 to 2" in fails(capsys, "show", run, "--trial", "3")
    assert "trial -1 is not in the run" in fails(capsys, "show", run, "--trial", "-1")
    assert "'--trial'" in fails(capsys, "show", run)
    assert "is not a folder" in fails(capsys, "show", tmp_path / "none", "--trial", "0")
    assert "no run.json" in fails(capsys, "show", tmp_path, "--trial", "0")
    below = run / "run.json" / "t.rrd"
    assert "choose another --save" in fails(capsys, "show", run, "--trial", "0", "--save", below)
    assert "choose another --png" in fails(capsys, "show", run, "--trial", "0", "--png", run)
    rows = read_rows(run / "trials.parquet")
    write_rows(rows[:1], run / "trials.parquet")
    assert "trial 2 of" in fails(capsys, "show", run, "--trial", "2")


@pytest.fixture
def writers(monkeypatch) -> list[tuple[str, object]]:
    """Stand-ins for recording and rendering, which have tests of their own."""
    calls: list[tuple[str, object]] = []

    def writer(name):
        def write(log, path=None):
            if isinstance(log, Iterator):
                assert len(list(log)) == 1
            calls.append((name, path))
            if path is not None:
                Path(path).write_text(name)

        return write

    for module, names in (
        ("recording", ["write_recordings", "spawn_viewer"]),
        ("render", ["render_trial"]),
    ):
        fake = types.ModuleType(module)
        fake.__dict__.update({name: writer(name) for name in names})
        monkeypatch.setitem(sys.modules, f"sdh_sim.viewing.{module}", fake)
    return calls


def test_show_repeats_the_trial_and_writes(run, tmp_path, capsys, quick, writers):
    rrd, png = tmp_path / "new" / "t.rrd", tmp_path / "t.png"
    arguments = ["show", str(run), "--trial", "1", "--save", str(rrd), "--png", str(png)]
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    row = read_rows(run / "trials.parquet")[1]
    assert out.startswith(f"trial 1: box, seed {row['seed']}: ")
    assert out.splitlines()[1:] == [str(rrd), str(png)]
    assert writers == [("write_recordings", rrd), ("render_trial", png)]


def test_show_opens_the_viewer_otherwise(run, quick, writers):
    assert main(["show", str(run), "--trial", "1"]) == 0
    assert writers == [("spawn_viewer", None)]


def test_show_names_what_differs(run, capsys, monkeypatch, writers):
    def other(settings, seed, log=False):
        row = stand_ins.make_row(settings.object, seed)
        return stand_ins.Result({**row, "mass_kg": 0.6, "contacts": 17})

    use_trial(monkeypatch, other)
    info = json.loads((run / "run.json").read_text())
    info["sessions"][-1]["versions"]["numpy"] = "1.0"
    (run / "run.json").write_text(json.dumps(info))
    assert main(["show", str(run), "--trial", "1"]) == 0
    err = capsys.readouterr().err
    assert err.startswith(
        "warning: the repeated trial differs from the stored one in contacts, mass_kg"
    )
    assert "numpy 1.0 is now" in err
