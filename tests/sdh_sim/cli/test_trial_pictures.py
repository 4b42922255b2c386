"""What ``compare`` tells its report of the runs: commands that show trials, and their pictures."""

from __future__ import annotations

import io
import shlex
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from sdh_sim.analysis.study import read_study
from sdh_sim.cli import trial_pictures
from sdh_sim.cli.app import main
from sdh_sim.cli.trial_pictures import Photographer, look_at
from sdh_sim.errors import RenderError
from sdh_sim.records import read_rows, write_rows


@pytest.fixture
def cases(run):
    return read_study([run / "trials.parquet"], resamples=20).cases


@pytest.fixture
def graphics(monkeypatch) -> list[int]:
    """Pictures take no time; how many moments each has."""
    drawn: list[int] = []

    def frames(log, indices, size, shadows):
        drawn.append(len(indices))
        return (np.full((size[1], size[0], 3), 90, np.uint8) for _ in indices)

    fake = SimpleNamespace(draw_frames=frames, milestones=lambda log: [0, 1, 2])
    monkeypatch.setitem(sys.modules, "sdh_sim.viewing.render", fake)
    return drawn


def test_the_command_works_from_any_shell(run, cases):
    odd = run.rename(run.parent / "it's a run")
    look = look_at([odd], 0)
    program, *arguments = shlex.split(look.command(cases[1]))
    assert (program, arguments) == ("sdh-sim", ["show", str(odd), "--trial", "1"])
    assert f"{shlex.quote(str(odd))} --pictures" in look.hint
    assert look_at([odd], 3).hint == ""


def test_a_table_alone_has_no_command_and_no_picture(run, cases):
    table = run / "trials.parquet"
    look = look_at([table], 2)
    assert look.command(cases[0]) == ""
    assert "give the folder of its run" in str(Photographer([table])(cases[0]))


def test_a_picture_is_a_jpeg_of_three_moments(run, cases, quick, graphics, capsys):
    jpeg = Photographer([run])(cases[2])
    assert isinstance(jpeg, bytes)
    with Image.open(io.BytesIO(jpeg)) as image:
        assert (image.format, image.size) == ("JPEG", (960, 280))
    assert graphics == [3]
    assert f"drawing trial 2 of {run}" in capsys.readouterr().out


def test_without_graphics_one_trial_is_run_and_no_more(run, cases, monkeypatch):
    runs = []

    def refuse(folder, trial):
        runs.append(trial)
        raise RenderError("no headless OpenGL;\n install EGL")

    monkeypatch.setattr(trial_pictures, "_photograph", refuse)
    photographer = Photographer([run])
    assert [photographer(case) for case in cases[:3]] == ["no headless OpenGL; install EGL"] * 3
    assert runs == [0]


def test_a_trial_that_went_otherwise_is_not_shown(run, cases, quick, graphics):
    rows = read_rows(run / "trials.parquet")
    write_rows(({**row, "q_linf": 7.0} for row in rows), run / "trials.parquet")
    assert "went otherwise" in str(Photographer([run])(cases[0]))
    (run / "run.json").unlink()
    assert "no run.json" in str(Photographer([run])(cases[0]))
    assert not graphics


def test_compare_takes_the_pictures_it_is_asked_for(run, quick, graphics, capsys):
    mistaken = [{**r, "success": False, "failure": "slipped", "q_linf": 2.0 + r["trial"]}
                for r in read_rows(run / "trials.parquet")]  # fmt: skip
    write_rows(mistaken, run / "trials.parquet")
    assert main(["compare", str(run), "--pictures", "2"]) == 0
    assert capsys.readouterr().out.count("drawing trial") == 2
    page = (run / "report" / "index.html").read_text()
    assert "No picture of trial 2, 1: run again it went otherwise" in page
    for wrong in (["--pictures", "-1"], ["--pictures", "1", "--no-report"]):
        assert main(["compare", str(run), *wrong]) == 2
        assert "--pictures" in capsys.readouterr().err
