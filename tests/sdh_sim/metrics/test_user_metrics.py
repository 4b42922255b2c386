"""Metrics of users: found, evaluated as the built-in ones are, compared, never run unasked."""

from __future__ import annotations

import copy
import functools
import json
import math
import re
import shlex
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from sdh_sim import records
from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.study import read_study
from sdh_sim.analysis.trial_tables import user_metrics as stated
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.cli import lift as cli_lift
from sdh_sim.cli.app import main
from sdh_sim.errors import RunError, SettingsError
from sdh_sim.metrics.prediction import predict
from sdh_sim.metrics.user_metrics import evaluate, find_metrics, load_metric
from sdh_sim.objects.catalogue import object_info
from sdh_sim.records.trial_row import FAILURES
from sdh_sim.records.user_columns import METRIC_ERROR, added_columns
from sdh_sim.robot.hand import HandKinematics
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import RunPlan
from sdh_sim.sensing.perceived_grasp import PerceivedGrasp, perceive
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import UserMetric, plain
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT

EXAMPLE = ROOT / "docs" / "examples" / "my_metric.py"
PAGE = ROOT / "docs" / "extending.md"

SOURCE = """
import math, sys

def thumb(grasp):
    return float(grasp.snapshot.distal[2].sum())

thumb.threshold = 3

def raises(grasp):
    raise ValueError("no\\nsecond line")

def leaves(grasp):
    sys.exit(3)

def text(grasp):
    return "1.0"

def nothing(grasp):
    return None

def infinite(grasp):
    return math.inf

def spoils(grasp):
    grasp.snapshot.distal[:] = -1.0
    grasp.torque_limits[:] = 0.0
    return 1

class Callable_:
    threshold = 0.25
    def __call__(self, grasp):
        return 2.0

made = Callable_()
number = 3.0
strange = Callable_()
strange.threshold = "high"
error = thumb
BIG = thumb
"""


@pytest.fixture
def file(tmp_path) -> Path:
    path = tmp_path / "mine.py"
    path.write_text(SOURCE)
    return path


@pytest.fixture
def grasp() -> PerceivedGrasp:
    rng = np.random.default_rng(0)
    snapshot = TactileSnapshot(
        proximal=np.zeros((3, 14, 6)),
        distal=rng.uniform(size=(3, 13, 6)),
        joint_angles=np.array([0.5, 0.2, 0.3, 0.1, 0.2, 0.3, 0.2]),
        motor_torques=np.zeros(7),
        object_pose_hand=np.array([0, 0, 0.2, 1, 0, 0, 0.0]),
        hand_pose_world=np.array([0, 0, 0, 1, 0, 0, 0.0]),
    )
    return perceive(snapshot, object_info("box"), (1.6, 1.1), "all", HandKinematics())


def find(file: Path, *names: str) -> tuple[UserMetric, ...]:
    return find_metrics([f"{file}:{name}" for name in names])


def test_a_value_is_the_function_of_the_grasp(file, grasp):
    metrics = find(file, "thumb", "made", "infinite")
    assert [m.name for m in metrics] == ["infinite", "made", "thumb"]
    assert [m.threshold for m in metrics] == [None, 0.25, 3.0]
    assert evaluate(grasp, metrics) == {
        "metric_infinite": math.inf,
        "metric_made": 2.0,
        "metric_thumb": pytest.approx(grasp.snapshot.distal[2].sum()),
        METRIC_ERROR: "",
    }
    assert evaluate(grasp, ()) == {}


def test_a_metric_sees_what_the_built_in_ones_see(grasp, monkeypatch):
    snapshot, thing = grasp.snapshot, grasp.thing
    prediction = predict(snapshot, thing, (1.6, 1.1), "all", HandKinematics())
    assert len(prediction.contacts) == 3
    normals = np.array([pad.contact.normal for pad in prediction.contacts])
    values = evaluate(prediction.grasp, find_metrics([f"{EXAMPLE}:opposition"]))
    wanted = 1 - np.linalg.norm(normals.sum(axis=0)) / 3
    assert values["metric_opposition"] == pytest.approx(wanted)
    values = evaluate(prediction.grasp, find_metrics([f"{EXAMPLE}:contact_area"]))
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
    row = evaluate(grasp, find(file, name, "thumb"))
    assert math.isnan(row[f"metric_{name}"])
    assert row["metric_thumb"] > 0.0
    assert row[METRIC_ERROR].startswith(why)
    assert "\n" not in row[METRIC_ERROR]


def test_a_metric_cannot_spoil_the_row_or_its_neighbours(file, grasp):
    before = copy.deepcopy(grasp)
    row = evaluate(grasp, find(file, "spoils", "thumb"))
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
    ("asked", "words"),
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
def test_metrics_are_refused_in_words(tmp_path, file, asked, words):
    (tmp_path / "broken.py").write_text("def f(:")
    (tmp_path / "leaving.py").write_text("raise SystemExit")
    names = {"file": file, "broken": tmp_path / "broken.py", "leaving": tmp_path / "leaving.py"}
    with pytest.raises(SettingsError, match=re.escape(words)) as caught:
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
        evaluate(grasp, again.settings.metrics)
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


def with_metrics(settings: TrialSettings, seed: int, log: bool = False) -> stand_ins.Result:
    """A stand-in whose rows have users' metrics, with gaps."""
    row = stand_ins.make_row(settings.object, seed)
    if row["failure"] != "no_contact":
        for k, metric in enumerate(settings.metrics):
            missing = seed % 5 == k
            row[metric.column] = math.nan if missing else row["q_linf"] + k
            row[METRIC_ERROR] = f"{metric.name}: ValueError: no" if missing else ""
    if seed % 7 == 3:
        raise ZeroDivisionError
    return stand_ins.Result(row)


def plan_with(file: Path, trials: int, objects=("box", "oval_bottle")) -> RunPlan:
    settings = TrialSettings(objects[0], metrics=find(file, "thumb", "raises"))
    return RunPlan(objects, settings, trials, 0)


def test_the_table_is_the_same_however_it_came_about(tmp_path, file):
    first, second = tmp_path / "first", tmp_path / "second"
    run_campaign(plan_with(file, 20), first, 1, trial=with_metrics)
    run_campaign(plan_with(file, 7), second, 2, trial=with_metrics, save_every=0.0)
    run_campaign(plan_with(file, 20), second, 2, trial=with_metrics, resume=True)
    table = first / "trials.parquet"
    assert table.read_bytes() == (second / "trials.parquet").read_bytes()
    schema = pq.read_schema(table)
    assert schema.names == [
        *(c.name for c in records.COLUMNS),
        *("metric_raises", "metric_thumb", METRIC_ERROR),
    ]
    assert schema.field("metric_thumb").metadata[b"threshold"] == b"3.0"
    rows = records.read_rows(table)
    assert {row["failure"] for row in rows} > {"error", "none"}
    for row in rows:
        q = row["q_linf"]
        wanted = None if q is None or row["seed"] % 5 == 1 else q + 1
        assert row["metric_thumb"] == wanted
    with pytest.raises(RunError, match=r"other settings: metrics \(run: raises .*, asked: none\)"):
        run_campaign(
            RunPlan(("box", "oval_bottle"), TrialSettings("box"), 20, 0), first, resume=True
        )


def test_rows_of_other_metrics_are_refused(tmp_path, file):
    row = records.normalise(
        {**stand_ins.make_row("box", 1), "trial": 0, "metric_thumb": 1.0, "metric_new": 2.0}
    )
    with pytest.raises(records.RecordError, match="'metric_new', which this table has not"):
        records.write_rows([row], tmp_path / "t", added_columns(find(file, "thumb")))
    with pytest.raises(records.RecordError, match="unknown column 'metric_Big'"):
        records.normalise({**stand_ins.make_row("box", 1), "trial": 0, "metric_Big": 1.0})
    with pytest.raises(records.RecordError, match="column 'metric_thumb' got 'x'"):
        records.normalise({**stand_ins.make_row("box", 1), "trial": 0, "metric_thumb": "x"})


@pytest.fixture
def run(tmp_path, file) -> Path:
    out = tmp_path / "run"
    run_campaign(plan_with(file, 30), out, 1, trial=with_metrics)
    return out


def test_compare_shows_metrics_beside_q(run, capsys):
    study = read_study([run / "trials.parquet"], compare.METRICS, 50)
    assert study.metrics == ("q_linf", "q_l1", "metric_raises", "metric_thumb")
    rows = [r for r in records.read_rows(run / "trials.parquet") if r["failure"] in FAILURES[:5]]
    have = [r for r in rows if r["metric_thumb"] is not None]
    thumb = study.findings["overall", "metric_thumb"].comparison
    assert thumb.threshold == 3.0
    assert thumb.has_boundary
    assert (thumb.n, thumb.missing) == (len(have), len(rows) - len(have))
    assert thumb.missing > 0
    assert thumb.tp == sum(r["metric_thumb"] > 3.0 and r["success"] for r in have)
    assert thumb.fn == sum(r["metric_thumb"] <= 3.0 and r["success"] for r in have)
    scores = np.array([r["metric_thumb"] for r in have])
    success = np.array([r["success"] for r in have])
    assert thumb.auc == compare.auc(scores, success)
    assert not study.findings["overall", "metric_raises"].comparison.has_boundary

    assert main(["compare", str(run)]) == 0
    out = capsys.readouterr().out
    assert re.search(r"thumb +\d+ \(", out)
    assert re.search(r"raises +- +- +- +0\.\d\d \(", out)
    assert "thumb: success is predicted above 3." in out
    assert "raises states no threshold" in out
    assert f"{thumb.missing} trials without thumb are left out" in out
    assert "thumb" in (run / "report" / "index.html").read_text()
    assert "metric_thumb" in (run / "report" / "summary.csv").read_text()


def test_tables_that_disagree_on_a_threshold_state_none(tmp_path, file):
    (thumb,) = find(file, "thumb")
    row = {**stand_ins.make_row("box", 1), "trial": 0, "metric_thumb": 1.0}
    paths = [tmp_path / f"{k}.parquet" for k in range(3)]
    for path, threshold in zip(paths, (3.0, 4.0, None), strict=True):
        other = UserMetric(thumb.name, thumb.target, thumb.sha256, threshold)
        records.write_rows([row], path, added_columns([other]))
    assert stated(paths[:1]) == {"metric_thumb": 3.0}
    assert stated(paths[:2]) == {"metric_thumb": None}
    assert stated(paths) == {"metric_thumb": None}
    plain_path = tmp_path / "plain.parquet"
    records.write_rows([{**stand_ins.make_row("box", 1), "trial": 0}], plain_path)
    assert stated([paths[0], plain_path]) == {}


def test_code_that_a_folder_names_is_not_run(tmp_path, run, capsys):
    marker = tmp_path / "ran"
    evil = tmp_path / "evil.py"
    evil.write_text(f"open({str(marker)!r}, 'w').close()\ndef thumb(grasp): return 1.0\n")
    info = json.loads((run / "run.json").read_text())
    for metric in info["settings"]["metrics"]:
        metric["target"] = f"{evil}:{metric['name']}"
    (run / "run.json").write_text(json.dumps(info))
    plan = RunFolder(run).read_plan()
    number = next(r["trial"] for r in records.read_rows(run / "trials.parquet"))
    assert main(["show", str(run), "--trial", str(number), "--save", str(tmp_path / "t.rrd")]) == 0
    assert main(["compare", str(run), "--no-report"]) == 0
    capsys.readouterr()
    assert main(["lift", "--resume", "--trials", "31", "--out", str(run)]) == 2
    assert "name the code yourself with --metric" in capsys.readouterr().err
    with pytest.raises(Exception, match="is known from a file alone"):
        run_campaign(RunPlan(plan.objects, plan.settings, 31, plan.seed), run, resume=True)
    assert not marker.exists()


def test_lift_warns_and_goes_on(tmp_path, file, monkeypatch, capsys):
    monkeypatch.setattr(
        cli_lift, "run_campaign", functools.partial(run_campaign, trial=with_metrics)
    )
    out = tmp_path / "out"
    given = ["--metric", f"{file}:thumb", "--metric", f"{file}:raises"]
    lift = ["lift", "--object", "box", "--workers", "1", "--out", str(out)]
    assert main([*lift, "--trials", "10", *given]) == 0
    notes = [r[METRIC_ERROR] or "" for r in records.read_rows(out / "trials.parquet")]
    failed = sum("thumb" in note for note in notes)
    assert failed > 0
    warning = f"warning: metric thumb failed in {failed} of 10 trials, the first time with Value"
    assert warning in capsys.readouterr().err
    assert main(["lift", "--resume", "--trials", "12", "--out", str(out), *given]) == 0
    assert main([*lift[:-1], str(tmp_path / "x"), "--metric", "duck"]) == 2
    assert "--metric: got 'duck'; there is no entry point" in capsys.readouterr().err


def page_commands() -> list[tuple[list[str], str]]:
    """The page's commands, each with the output below it, if any."""
    text = PAGE.read_text()
    found = re.findall(r"^    (sdh-sim [a-z].*)\n(\n```text\n(?:.*\n)*?```)?", text, re.MULTILINE)
    return [
        (shlex.split(command)[1:], output.strip().removeprefix("```text").removesuffix("```"))
        for command, output in found
    ]


def words(text: str) -> set[str]:
    """Words and file names; no numbers, and not how trials failed, which differ by machine."""
    return set(re.findall(r"[A-Za-z_∞*.]{3,}", text)) - set(FAILURES)


def test_the_page_does_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    source = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert source is not None
    assert EXAMPLE.read_text().endswith(source[1])
    facts = re.search(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert facts is not None
    assert facts[1] == (ROOT / "docs/examples/mug/object.toml").read_text()
    commands = page_commands()
    assert [arguments[0] for arguments, _ in commands] == ["objects", "lift", "lift", "compare"]
    for arguments, shown in commands:
        if "box" in arguments:
            continue  # takes long, and is the next one without metrics
        arguments = ["8" if a == "20" else a for a in arguments]
        assert main(arguments) == 0
        out = capsys.readouterr().out
        if arguments[0] == "objects":
            assert out.split() == shown.split()
        else:
            # Eight trials are too few for a best threshold.
            lines = [line for line in shown.splitlines() if not line.startswith("Best threshold:")]
            assert words("\n".join(lines)) <= words(out), out
    table: Any = pq.read_table(tmp_path / "runs/mug/trials.parquet")
    area = np.array(table.column("metric_contact_area").to_pylist(), float)
    assert np.nanmax(area) < 456 * 0.34**2
    assert (area[~np.isnan(area)] >= 0.0).all()
