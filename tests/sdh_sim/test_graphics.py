"""A back end of MUJOCO_GL that cannot be used stops what draws, in one line, and nothing else."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys

import pytest

from sdh_sim import graphics
from sdh_sim.campaign import run_campaign
from sdh_sim.records import read_rows
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT
from tests.support.trial_stand_ins import plan

LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux's back ends")


@pytest.fixture
def environment(monkeypatch):
    """Sets MUJOCO_GL, with libraries of some back ends, as a new process would find it."""

    def choose(asked: str | None, *there: str, pyopengl: str | None = None) -> tuple[str, str]:
        found = {name: None for name in (graphics.NAME, graphics.ASKED, "PYOPENGL_PLATFORM")}
        for name, value in (found | {graphics.NAME: asked, "PYOPENGL_PLATFORM": pyopengl}).items():
            if value is None:
                monkeypatch.delenv(name, raising=False)
            else:
                monkeypatch.setenv(name, value)
        monkeypatch.delitem(sys.modules, "mujoco", raising=False)
        monkeypatch.setattr(
            graphics, "_loads", lambda library: any(name in library.lower() for name in there)
        )
        graphics.choose()
        return os.environ.get(graphics.NAME, ""), graphics.why_nothing_can_be_drawn() or ""

    return choose


@LINUX
@pytest.mark.parametrize(
    ("asked", "there", "wanted"),
    [
        (None, ("egl", "osmesa"), "egl"),
        (None, ("osmesa",), "osmesa"),
        (None, (), ""),
        ("", (), ""),
        ("EGL ", ("egl",), "EGL "),
        ("osmesa", ("egl", "osmesa"), "osmesa"),
        ("glfw", (), "glfw"),
    ],
)
def test_what_can_be_used_is_used(environment, asked, there, wanted):
    assert environment(asked, *there) == (wanted, "")


@LINUX
@pytest.mark.parametrize(
    ("asked", "there", "way_out"),
    [
        ("nonsense", ("egl",), "unset it or set it to egl"),
        ("osmesa", ("egl",), "unset it or set it to egl"),
        ("egl", (), "unset it"),
        ("wgl", ("egl", "osmesa"), "unset it or set it to egl or set it to osmesa"),
    ],
)
def test_what_cannot_be_used_turns_drawing_off_and_is_told(environment, asked, there, way_out):
    value, reason = environment(asked, *there)
    assert value == "disable"
    assert reason == f"MUJOCO_GL is {asked!r}, which cannot be used here; {way_out}"


@LINUX
def test_a_library_that_pyopengl_is_told_not_to_take(environment):
    value, reason = environment("egl", "egl", pyopengl="osmesa")
    assert value == "disable"
    assert reason == "MUJOCO_GL is 'egl', which cannot be used here; unset it"


@LINUX
def test_drawing_that_the_user_turned_off_is_told_as_that(environment):
    value, reason = environment("OFF", "egl")
    assert value == "OFF"
    assert reason == "MUJOCO_GL is 'OFF', which turns drawing off; unset it or set it to egl"


def python(code: str, back_end: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "MUJOCO_GL": back_end, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


COMMANDS = """
import sys
from sdh_sim.cli.app import main
for arguments in (["--help"], ["objects"], ["hand", "parallel_jaw"]):
    assert main(arguments) == 0
sys.stdout.flush()
sys.exit(main(["render", "no_run", "--trial", "0", "--out", "t.png"]))
"""


@LINUX
def test_commands_that_draw_nothing_run_and_one_that_draws_says_why_not():
    assert python("import mujoco", "nonsense").returncode != 0
    done = python(COMMANDS, "nonsense")
    assert done.returncode == 2
    assert "cylindrical_bottle" in done.stdout
    assert done.stderr.startswith("sdh-sim: nothing can be drawn: MUJOCO_GL is ")
    assert done.stderr.count("\n") == 1


LIBRARY = """
import experiments.creep, sdh_sim
sdh_sim.Trial(sdh_sim.TrialSettings("box"), 0)
"""


@LINUX
def test_the_library_and_the_experiments_run():
    done = python(LIBRARY, "osmesa")  # on most machines not installed
    assert done.returncode == 0, done.stderr


DASK = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None, reason="needs the extra 'distributed'"
)


@LINUX
@pytest.mark.parametrize("executor", ["processes", pytest.param("dask", marks=DASK)])
def test_worker_processes_run(tmp_path, monkeypatch, executor):
    monkeypatch.setenv("MUJOCO_GL", "nonsense")
    run_campaign(plan(1), tmp_path, 1, trial=stand_ins.with_mujoco, executor=executor)
    assert [row["failure"] for row in read_rows(tmp_path / "trials.parquet")] == ["none", "none"]
