"""Metrics of users: found, evaluated as built-in ones are, run only where the user names them."""

from __future__ import annotations

import copy
import json
import math
import re
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from sdh_sim.errors import SettingsError
from sdh_sim.metrics import find_metrics, load_metric, predict
from sdh_sim.metrics.user_metrics import evaluate_user_metrics
from sdh_sim.objects import object_info
from sdh_sim.records import METRIC_ERROR
from sdh_sim.robot import HandKinematics
from sdh_sim.runs import RunPlan
from sdh_sim.sensing import PerceivedGrasp, perceive
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import UserMetric, plain
from tests.support import sdh2
from tests.support.metric_files import EXAMPLE, SOURCE, find, metric_file


@pytest.fixture
def file(tmp_path) -> Path:
    return metric_file(tmp_path)


@pytest.fixture
def grasp() -> PerceivedGrasp:
    rng = np.random.default_rng(0)
    snapshot = sdh2.snapshot(
        proximal=np.zeros((3, 14, 6)),
        distal=rng.uniform(size=(3, 13, 6)),
        joint_angles=np.array([0.5, 0.2, 0.3, 0.1, 0.2, 0.3, 0.2]),
        motor_torques=np.zeros(7),
        object_pose_hand=np.array([0, 0, 0.2, 1, 0, 0, 0.0]),
        hand_pose_world=np.array([0, 0, 0, 1, 0, 0, 0.0]),
    )
    return perceive(snapshot, object_info("box"), (1.6, 1.1), "all", HandKinematics())


def test_a_value_is_the_function_of_the_grasp(file, grasp):
    metrics = find(file, "thumb", "made", "infinite")
    assert [m.name for m in metrics] == ["infinite", "made", "thumb"]
    assert [m.threshold for m in metrics] == [None, 0.25, 3.0]
    assert evaluate_user_metrics(grasp, metrics) == {
        "metric_infinite": math.inf,
        "metric_made": 2.0,
        "metric_thumb": pytest.approx(grasp.snapshot.distal[2].sum()),
        METRIC_ERROR: "",
    }
    assert evaluate_user_metrics(grasp, ()) == {}


def test_a_metric_sees_what_the_built_in_ones_see(grasp, monkeypatch):
    snapshot, obj = grasp.snapshot, grasp.obj
    assert grasp.thing is obj  # the name in earlier versions, which users' metrics may have
    prediction = predict(snapshot, obj, (1.6, 1.1), "all", HandKinematics())
    assert len(prediction.contacts) == 3
    normals = np.array([pad.contact.normal for pad in prediction.contacts])
    values = evaluate_user_metrics(prediction.grasp, find_metrics([f"{EXAMPLE}:opposition"]))
    wanted = 1 - np.linalg.norm(normals.sum(axis=0)) / 3
    assert values["metric_opposition"] == pytest.approx(wanted)
    values = evaluate_user_metrics(prediction.grasp, find_metrics([f"{EXAMPLE}:contact_area"]))
    assert values["metric_contact_area"] == pytest.approx(3 * 13 * 6 * 0.34**2)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("raises", "raises: ValueError: no"),
        ("leaves", "leaves: SystemExit: 3"),
        ("text", "text: TypeError: gave '1.0', not a number"),
        ("nothing", "nothing: TypeError: float() argument must be"),
    ],
)
def test_a_fault_is_nan_and_said(file, grasp, name, why):
    row = evaluate_user_metrics(grasp, find(file, name, "thumb"))
    assert math.isnan(row[f"metric_{name}"])
    assert row["metric_thumb"] > 0.0
    assert row[METRIC_ERROR].startswith(why)
    assert "\n" not in row[METRIC_ERROR]


def test_a_metric_cannot_spoil_the_row_or_its_neighbours(file, grasp):
    before = copy.deepcopy(grasp)
    row = evaluate_user_metrics(grasp, find(file, "spoils", "thumb"))
    assert row["metric_thumb"] == pytest.approx(before.snapshot.distal[2].sum())
    assert np.array_equal(grasp.snapshot.distal, before.snapshot.distal)
    assert np.array_equal(grasp.torque_limits, before.torque_limits)


def test_modules_and_entry_points(tmp_path, monkeypatch, grasp):
    (tmp_path / "my_package_x").mkdir()
    (tmp_path / "my_package_x" / "__init__.py").write_text("")
    (tmp_path / "my_package_x" / "inner.py").write_text(SOURCE)
    about = tmp_path / "my_package_x-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: my-package-x\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[sdh_sim.metrics]\npush = my_package_x.inner:thumb\n")
    with pytest.raises(SettingsError, match="no entry point of that name in the group sdh_sim"):
        find_metrics(["push"])
    with pytest.raises(SettingsError, match="No module named 'my_package_x'"):
        find_metrics(["my_package_x.inner:thumb"])
    monkeypatch.syspath_prepend(str(tmp_path))
    (push,) = find_metrics(["push"])
    (thumb,) = find_metrics(["my_package_x.inner:thumb"])
    assert (push.name, push.target, push.sha256) == ("push", "entry-point:push", thumb.sha256)
    assert load_metric(push)(grasp) == load_metric(thumb)(grasp)
    # Installed by the user and known by name alone: going on with it needs no naming.
    assert find_metrics([], [push]) == (push,)
    with pytest.raises(SettingsError, match=r"installed: push"):
        find_metrics(["pull"])


def test_a_module_in_the_working_folder(tmp_path, monkeypatch):
    (tmp_path / "only_here_y.py").write_text(SOURCE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [p for p in __import__("sys").path if p])
    assert find_metrics(["only_here_y:thumb"])[0].target == "only_here_y:thumb"


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("mine.py:", "after the colon goes a function's name"),
        ("mine.py:a b", "after the colon goes a function's name"),
        ("a/b:c", "give module:function, file.py:function, or the name of an entry point"),
        (":thumb", "give module:function"),
        ("nowhere.py:f", "cannot be loaded (FileNotFoundError"),
        ("{file}:missing", "cannot be loaded (AttributeError"),
        ("{file}:number", "is a float; give a function"),
        ("{file}:strange", "has threshold 'high'; give a number"),
        ("{file}:BIG", "got the name 'BIG'"),
        ("{file}:error", "got the name 'error'"),
        ("{broken}:f", "cannot be loaded (SyntaxError"),
        ("{leaving}:f", "cannot be loaded (SystemExit"),
        ("nothing_like_this:f", "cannot be loaded (ModuleNotFoundError"),
        ("", "there is no entry point of that name"),
    ],
)
def test_metrics_are_refused_in_words(tmp_path, file, asked, message):
    (tmp_path / "broken.py").write_text("def f(:")
    (tmp_path / "leaving.py").write_text("raise SystemExit")
    names = {"file": file, "broken": tmp_path / "broken.py", "leaving": tmp_path / "leaving.py"}
    with pytest.raises(SettingsError, match=re.escape(message)) as caught:
        find_metrics([asked.format(**names)])
    assert str(caught.value).startswith("metric: ")
    assert "\n" not in str(caught.value)


def test_one_name_twice_is_refused(tmp_path, file):
    (tmp_path / "second.py").write_text(SOURCE)
    twice = find_metrics([f"{file}:thumb", f"{tmp_path / 'second.py'}:thumb", f"{file}:thumb"])
    assert len(twice) == 2
    with pytest.raises(SettingsError, match="give each name once"):
        TrialSettings("box", metrics=twice)


def test_settings_and_plans_keep_metrics_but_not_the_leave_to_run_them(file, grasp):
    metrics = find(file, "thumb", "raises")
    plan = RunPlan(("box",), TrialSettings("box", metrics=metrics), 1, 0)
    again = RunPlan.from_dict(json.loads(json.dumps(plan.to_dict())))
    assert again == plan
    assert again.job(0).settings.metrics == metrics
    assert load_metric(metrics[0])
    with pytest.raises(SettingsError, match="is known from a file alone; name its code"):
        evaluate_user_metrics(grasp, again.settings.metrics)
    with pytest.raises(SettingsError, match=r"name the code yourself with .*mine\.py:raise"):
        find_metrics([f"{file}:thumb"], again.settings.metrics)
    for wrong in (None, 1, "x", [1], [{"name": "x"}], [plain(metrics[0]) | {"sha256": "x"}]):
        data = plan.to_dict()
        data["settings"]["metrics"] = wrong
        with pytest.raises(SettingsError):
            RunPlan.from_dict(data)
    data["settings"]["metrics"] = [asdict(metrics[0])]  # with the leave written into the file
    with pytest.raises(SettingsError):
        RunPlan.from_dict(data)


def test_a_file_that_has_changed_is_refused(tmp_path, file, grasp):
    (before,) = find(file, "thumb")
    stored = UserMetric(before.name, before.target, "0" * 64, before.threshold)
    with pytest.raises(SettingsError, match="has changed since the run began"):
        find_metrics([f"{file}:thumb"], [stored])
    with pytest.raises(SettingsError, match="has changed since the run began"):
        load_metric(UserMetric(before.name, before.target, "0" * 64, asked=True))
