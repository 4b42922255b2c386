"""Pictures, films and the viewer from the command line, on a stored trial."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from sdh_sim.cli import app as cli
from sdh_sim.grasp_files import GraspEntry, write_grasps
from sdh_sim.grasping import plan_of
from sdh_sim.objects import object_info
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial

av = pytest.importorskip("av", reason="films need PyAV")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("render") / "run"
    lift = ["lift", "--object", "cylindrical_bottle", "--trials", "1", "--seed", "1"]
    assert cli.main([*lift, "--workers", "1", "--out", str(folder)]) == 0
    return folder


def render(run: Path, out: Path, *more: str) -> int:
    return cli.main(["render", str(run), "--trial", "0", "--out", str(out), *more])


def test_a_picture_has_three_moments_of_the_size_asked_for(run, tmp_path):
    out = tmp_path / "trial.png"
    assert render(run, out, "--width", "200", "--height", "160") == 0
    with Image.open(out) as image:
        assert image.size == (600, 160)
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    moments = pixels.reshape(160, 3, 200, 3).transpose(1, 0, 2, 3)
    assert all(moment.std() > 10.0 for moment in moments)
    assert all(np.abs(a - b).mean() > 1.0 for a, b in ((moments[0], moments[1]),
                                                      (moments[1], moments[2])))  # fmt: skip


def test_a_film_shows_all_of_it_in_real_time(run, tmp_path, capsys):
    out = tmp_path / "trial.mp4"
    assert render(run, out, "--width", "128", "--height", "96", "--azimuth", "60") == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(out)
    with av.open(str(out)) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
        assert film.streams.video[0].average_rate == 30
    assert frames[0].shape == (96, 128, 3)
    assert 4.0 < len(frames) / 30 < 10.0  # seconds of a trial
    assert np.abs(frames[0].astype(float) - frames[-1]).mean() > 1.0
    assert [path.name for path in tmp_path.iterdir()] == ["trial.mp4"]


@pytest.mark.parametrize(
    ("name", "more", "message"),
    [
        ("trial.gif", (), "ends in .png or .mp4"),
        ("trial.mp4", ("--width", "321"), "even number"),
        ("trial.png", ("--height", "10"), "--height: got 10"),
        ("trial.png", ("--azimuth", "nan"), "--azimuth"),
        ("missing/\0.png", (), "--out"),
    ],
)
def test_bad_requests_are_one_line(run, tmp_path, capsys, name, more, message):
    assert render(run, tmp_path / name, *more) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_a_film_without_its_library_names_it(run, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    assert render(run, tmp_path / "trial.mp4") == 2
    assert 'pip install "sdh-sim[video]"' in capsys.readouterr().err


def test_several_trials_make_no_picture(run, tmp_path, capsys):
    twice = ["show", str(run), "--trial", "0", "--trial", "1", "--png", str(tmp_path / "a.png")]
    assert cli.main(twice) == 2
    assert capsys.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have a screen")
def test_the_viewer_needs_a_screen_and_one_object(capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for arguments, message in (
        (["box"], "no screen"),
        (["all"], "one object"),
        (["teapot"], "choose one of"),
        (["box", "--seed", "-1"], "--seed"),
    ):
        assert cli.main(["view", *arguments]) == 2
        assert message in capsys.readouterr().err


def test_the_viewer_takes_a_grasp_of_a_file(tmp_path, capsys, monkeypatch):
    turn = [1.0, 0.0, 0.0, 0.0]
    above = [0.01, 0.28, -0.008, 0.5**0.5, 0.5**0.5, 0.0, 0.0]
    good = GraspEntry("box", "good", np.array(above), "parallel", object_yaw=0.5)
    far = GraspEntry("box", "far", np.array([3.0, 0.0, 0.0, *turn]), "parallel")
    file = tmp_path / "grasps.csv"
    write_grasps([good, far], file)
    shown = []
    monkeypatch.setenv("DISPLAY", ":0")
    viewer = SimpleNamespace(launch=lambda model, data: shown.append(data.qpos.copy()))
    monkeypatch.setitem(sys.modules, "mujoco.viewer", viewer)
    monkeypatch.setattr("mujoco.viewer", viewer, raising=False)
    assert cli.main(["view", "box", "--grasps", str(file)]) == 0
    trial = Trial(TrialSettings("box"), plan=plan_of(good, object_info("box")))
    trial.place()
    assert np.array_equal(shown[0], trial.simulation.data.qpos)
    for arguments, message in (
        (["--grasps", str(file), "--grasp", "far"], "far cannot be tried: the arm cannot"),
        (["--grasps", str(file), "--grasp", "near"], "has no 'near' for box"),
        (["--grasp", "far"], "give the file that it is in"),
    ):
        assert cli.main(["view", "box", *arguments]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1


def test_the_viewer_starts_before_the_grasp():
    trial = Trial(TrialSettings("box"), 3)
    trial.place()
    assert trial.simulation.time == 0.0
    assert not trial.touched
    for _ in range(20):
        trial.simulation.tick()
    assert trial.simulation.on_table()
    assert not trial.touched  # the open hand stays before the object
