"""The command line: every way to get it wrong, in one line; and what it prints when all is well."""

from __future__ import annotations

import csv
import functools
import json
import os
import pty
import re
import signal
import subprocess
import sys
import types
from collections.abc import Iterator
from pathlib import Path

import pytest

from sdh_sim import records
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.cli import lift as cli_lift
from sdh_sim.cli.app import main
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import RunPlan
from sdh_sim.runs.shards import ShardWriter
from sdh_sim.settings import TrialSettings
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT


@pytest.fixture
def quick(monkeypatch):
    """Lifts take no time."""
    use(monkeypatch, stand_ins.quick)


def use(monkeypatch, trial) -> None:
    run = functools.partial(run_campaign, trial=trial)
    monkeypatch.setattr(cli_lift, "run_campaign", run)
    module = types.ModuleType("sdh_sim.trial")
    module.__dict__["run_trial"] = trial
    monkeypatch.setitem(sys.modules, "sdh_sim.trial", module)


@pytest.fixture
def run(tmp_path) -> Path:
    """A finished run of three trials on the box."""
    out = tmp_path / "run"
    plan = RunPlan(("box",), TrialSettings("box"), 3, 0)
    run_campaign(plan, out, 1, trial=stand_ins.quick)
    return out


def fails(capsys, *arguments: str | Path, status: int = 2) -> str:
    """The one line of stderr of a command that must fail."""
    assert main([str(a) for a in arguments]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("sdh-sim: ")
    assert err.count("\n") == 1
    return err


LIFT = ["lift", "--object", "box", "--out"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--object", "duck"], "--object: got 'duck'; choose one of box,"),
        (["--trials", "0"], "--trials: got 0; allowed is a whole number 1 to"),
        (["--trials", "-3"], "--trials: got -3"),
        (["--trials", "many"], "'--trials'"),
        (["--trials", "2.5"], "'--trials'"),
        (["--seed", "-1"], "--seed: got -1"),
        (["--workers", "0"], "--workers: got 0; give a whole number of at least 1"),
        (["--workers", "-2"], "--workers: got -2"),
        (["--torque-limit", "0", "1"], "--torque-limit: got (0.0, 1.0)"),
        (["--torque-limit", "1", "-1"], "--torque-limit: got (1.0, -1.0)"),
        (["--torque-limit", "nan", "1"], "--torque-limit: got (nan, 1.0)"),
        (["--torque-limit", "inf", "1"], "--torque-limit: got (inf, 1.0)"),
        (["--torque-limit", "1"], "--torque-limit"),
        (["--sensor", "eye"], "--sensor: got 'eye'; choose one of dsa, ideal"),
        (["--pads", "none"], "--pads: got 'none'; choose one of all, distal"),
        (["--rerun", "some"], "--rerun: got 'some'; choose one of all, failures, none"),
        (["--resume", "--overwrite"], "exclude each other"),
        (["--retry-errors"], "give --resume with it"),
        (["--executor", "cloud"], "--executor: got 'cloud'; choose one of processes, dask"),
        (["--scheduler", "tcp://h:1"], "--scheduler: got 'tcp://h:1'; it needs --executor dask"),
        (["--colour", "red"], "--colour"),
        (["extra"], "extra"),
    ],
)
def test_lift_refuses_in_one_line_and_writes_nothing(tmp_path, capsys, options, words):
    out = tmp_path / "out"
    assert words in fails(capsys, *LIFT, out, *options)
    assert not out.exists()


def test_lift_wants_out_and_an_object(tmp_path, capsys):
    assert "--out" in fails(capsys, "lift", "--object", "box")
    assert "--object: missing; give one of box," in fails(capsys, "lift", "--out", tmp_path / "x")
    assert "empty" in fails(capsys, *LIFT, "")


def test_unknown_commands(capsys):
    assert "'fly'" in fails(capsys, "fly")
    assert "--fly" in fails(capsys, "--fly")


def test_an_out_that_cannot_be_written(tmp_path, capsys, quick):
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/nowhere")):
        line = fails(capsys, *LIFT, out)
        assert f"cannot write to {out}" in line
        assert "choose another --out" in line
    assert "it is a file, not a folder" in fails(capsys, *LIFT, tmp_path / "file")
    assert (tmp_path / "file").read_text() == ""
    assert "too long" in fails(capsys, *LIFT, tmp_path / ("x" * 300))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_out(tmp_path, capsys, quick):
    tmp_path.chmod(0o500)
    assert "Permission denied" in fails(capsys, *LIFT, tmp_path / "out")


def test_an_out_that_holds_a_run(run, capsys, quick):
    before = (run / "trials.parquet").read_bytes()
    line = fails(capsys, *LIFT, run)
    assert f"{run} already holds a run" in line
    assert "--resume" in line
    assert "--overwrite" in line
    assert (run / "trials.parquet").read_bytes() == before


@pytest.mark.parametrize("name", ["trials.parquet", "run.json"])
def test_a_damaged_run_is_refused_untouched(run, capsys, quick, name):
    other = next(n for n in ("trials.parquet", "run.json") if n != name)
    (run / name).write_bytes(b"\x00\x01 not this")
    before = (run / other).read_bytes()
    line = fails(capsys, "lift", "--resume", "--out", run)
    assert name in line
    assert "--overwrite" in line
    assert (run / name).read_bytes() == b"\x00\x01 not this"
    assert (run / other).read_bytes() == before
    fails(capsys, "show", run, "--trial", "0")
    if name == "trials.parquet":
        assert "not a readable parquet file" in fails(capsys, "compare", run)
    assert main([*LIFT, str(run), "--overwrite", "--trials", "1"]) == 0
    assert len(records.read_rows(run / "trials.parquet")) == 1


def test_resume_with_another_setting_is_refused_by_name(run, capsys, quick):
    line = fails(capsys, "lift", "--resume", "--out", run, "--torque-limit", "1", "1")
    assert "torque_limit (run: 1.6401 1.0934, asked: 1.0 1.0)" in line
    line = fails(capsys, "lift", "--resume", "--out", run, "--object", "oval_bottle")
    assert "objects (run: box, asked: oval_bottle)" in line
    line = fails(capsys, "lift", "--resume", "--out", run, "--trials", "2")
    assert "--trials 2 would drop some: give 3 or more" in line


def test_lift_prints_progress_and_table(tmp_path, capsys, quick):
    out = tmp_path / "out"
    assert main([*LIFT, str(out), "--object", "oval_bottle", "--trials", "5"]) == 0
    printed, err = capsys.readouterr()
    rows = records.read_rows(out / "trials.parquet")
    good = sum(row["success"] for row in rows)
    assert f"10/10 trials, {good} succeeded" in err
    assert err.count("\n") == 10
    lines = printed.splitlines()
    (box,) = (line for line in lines if line.strip().startswith("box"))
    mine = [row["failure"] for row in rows if row["object"] == "box"]
    assert box.split()[1] == "5"
    assert f"{mine.count('none')} ({20 * mine.count('none')} %)" in box
    for mode in set(mine) - {"none"}:
        assert f"{mode} {mine.count(mode)}" in box
    assert "8.0" in box  # 4 s simulated in 0.5 s each
    (every,) = (line for line in lines if line.strip().startswith("all"))
    assert every.split()[1:3] == ["10", str(good)]
    assert f"table: {out}/trials.parquet" in lines
    command = json.loads((out / "run.json").read_text())["sessions"][0]["command"]
    assert command.split()[0] == "sdh-sim"


def test_options_reach_the_settings(tmp_path, quick):
    out = tmp_path / "out"
    options = ["--trials", "1", "--seed", "9", "--sensor", "ideal", "--pads", "distal"]
    options += ["--torque-limit", "2", "1.5"]
    assert main([*LIFT, str(out), *options]) == 0
    settings = TrialSettings("box", torque_limit=(2.0, 1.5), sensor="ideal", pads="distal")
    assert RunFolder(out).read_plan() == RunPlan(("box",), settings, 1, 9)


def test_all_objects_and_defaults(tmp_path, quick):
    out = tmp_path / "out"
    assert main(["lift", "--object", "all", "--out", str(out), "--workers", "1"]) == 0
    plan = RunFolder(out).read_plan()
    assert plan.objects == ("box", "oval_bottle", "spray_bottle", "cylindrical_bottle")
    assert (plan.trials, plan.seed) == (20, 0)
    assert plan.settings == TrialSettings("box")


def test_resume_takes_the_runs_own_settings(tmp_path, quick):
    out, whole = tmp_path / "out", tmp_path / "whole"
    own = ["--seed", "4", "--torque-limit", "2", "1", "--sensor", "ideal"]
    assert main([*LIFT, str(out), "--trials", "2", *own]) == 0
    assert main(["lift", "--resume", "--out", str(out), "--trials", "5"]) == 0
    assert main([*LIFT, str(whole), "--trials", "5", *own]) == 0
    assert (out / "trials.parquet").read_bytes() == (whole / "trials.parquet").read_bytes()
    assert main(["lift", "--resume", "--out", str(out)]) == 0  # nothing left to do


def test_growing_a_run_of_several_objects_says_that_numbers_move(tmp_path, capsys, quick):
    out = str(tmp_path / "out")
    assert main([*LIFT, out, "--object", "oval_bottle", "--trials", "1"]) == 0
    assert "trial numbers move" not in capsys.readouterr().err
    assert main(["lift", "--resume", "--out", out, "--trials", "2"]) == 0
    assert "trial numbers move" in capsys.readouterr().err


def test_errors_are_counted_and_the_way_to_run_them_again_is_told(tmp_path, capsys, monkeypatch):
    use(monkeypatch, stand_ins.raises)
    out = tmp_path / "out"
    assert main([*LIFT, str(out), "--trials", "12"]) == 0
    printed, err = capsys.readouterr()
    bad = sum(row["failure"] == "error" for row in records.read_rows(out / "trials.parquet"))
    assert bad > 0
    assert f"error {bad}" in printed
    assert err.splitlines()[-1] == (
        f"note: {bad} trials ended as error, see {out}/errors; run them again with: "
        f"sdh-sim lift --resume --out {out} --retry-errors"
    )
    use(monkeypatch, stand_ins.quick)
    assert main(["lift", "--resume", "--out", str(out), "--retry-errors"]) == 0
    assert "error" not in capsys.readouterr().err
    assert not any(r["failure"] == "error" for r in records.read_rows(out / "trials.parquet"))


def test_all_trials_failing_is_one_line_and_its_traceback_on_request(tmp_path, capsys, monkeypatch):
    use(monkeypatch, stand_ins.hopeless)
    out = tmp_path / "out"
    assert main([*LIFT, str(out), "--trials", "3"]) == 1
    err = capsys.readouterr().err
    assert "Traceback" not in err
    assert "ImportError: no module named physics; 0 of 3" in err.splitlines()[-1]
    monkeypatch.setenv("SDH_SIM_TRACEBACK", "1")
    assert main([*LIFT, str(out), "--overwrite", "--trials", "3"]) == 1
    assert "Traceback" in capsys.readouterr().err


_DRIVER = """
import functools, sys
sys.path.insert(0, "tests")
import trial_stand_ins
from sdh_sim import campaign, cli, cli_lift
cli_lift.run_campaign = functools.partial(campaign.run_campaign, trial=trial_stand_ins.slow)
sys.exit(cli.main())
"""


def drive(*arguments: str | Path, **options) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", _DRIVER, *map(str, arguments)],
        cwd=ROOT,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        **options,
    )


def test_ctrl_c_on_a_terminal_shows_the_bar_and_keeps_the_trials(tmp_path):
    out = tmp_path / "my run"
    ours, theirs = pty.openpty()
    process = drive(*LIFT, out, "--trials", "200", "--workers", "2", stdout=theirs, stderr=theirs)
    os.close(theirs)
    shown = ""
    while not re.search(r"[1-9]\d*/200", shown) or "succeeded" not in shown:
        shown += os.read(ours, 4096).decode()
    os.killpg(process.pid, signal.SIGINT)
    try:
        while chunk := os.read(ours, 4096):
            shown += chunk.decode()
    except OSError:  # how a terminal says that the other end is closed
        pass
    assert process.wait(timeout=20) == 130
    kept = len(records.read_rows(out / "trials.parquet"))
    assert 0 < kept < 200
    assert "Traceback" not in shown
    message = " ".join(shown[shown.index("sdh-sim: interrupted") :].split())
    assert message.endswith(
        f"interrupted: {kept} of 200 trials are kept in {out}/trials.parquet; "
        f"continue with: sdh-sim lift --resume --out '{out}'"
    )


@pytest.fixture
def mixed(tmp_path) -> Path:
    """A table whose comparison was worked out by hand."""
    values = [
        ("box", "none", 2.0, 1.2),
        ("box", "none", 0.9, 0.4),
        ("box", "slipped", 1.2, 0.3),
        ("box", "dropped", 0.5, 0.2),
        ("box", "no_contact", None, None),
        ("box", "unstable_simulation", 7.0, 7.0),
        ("oval_bottle", "none", 1.5, 0.7),
    ]
    rows = [
        {"trial": i, "object": o, "seed": i, "success": f == "none", "failure": f}
        | {"q_linf": a, "q_l1": b}
        for i, (o, f, a, b) in enumerate(values)
    ]
    records.write_rows(rows, tmp_path / "mixed.parquet")
    return tmp_path / "mixed.parquet"


def test_compare_prints_and_writes_the_numbers(mixed, tmp_path, capsys):
    target = tmp_path / "new" / "numbers.csv"
    assert main(["compare", str(mixed), "--csv", str(target)]) == 0
    printed = capsys.readouterr().out
    (box,) = (line for line in printed.splitlines() if line.strip().startswith("box"))
    # 5 trials: accuracy 3/5, TPR 1/2, FPR 1/3, AUC 5/6
    assert re.split(r"\s{2,}", box.strip())[:4] == ["box", "5", "40 %", "q* L∞"]
    assert re.findall(r"([\d.]+) \(", box) == ["60", "50", "33", "0.83"]
    (bottle,) = (line for line in printed.splitlines() if line.strip().startswith("oval"))
    assert bottle.split()[-2:] == ["-", "-"]
    assert "1 trials without q* count as q* = 0" in printed
    assert "1 trials left out" in printed
    assert "-: undefined" in printed
    with open(target, newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["object"] for row in table] == [
        name for name in ("box", "oval_bottle", "overall") for _ in range(2)
    ]
    assert float(table[0]["auc"]) == pytest.approx(5 / 6)
    assert table[2]["auc"] == table[2]["false_positive_rate"] == ""
    assert (table[4]["n"], table[4]["unstable_excluded"]) == ("6", "1")


def test_compare_joins_runs_and_says_what_is_unfinished(run, mixed, tmp_path, capsys):
    rows = records.read_rows(run / "trials.parquet")
    records.write_rows(rows[:2], run / "trials.parquet")
    assert main(["compare", str(run), str(mixed)]) == 0
    printed = capsys.readouterr().out
    assert f"{run} is unfinished: 2 of 3 trials (sdh-sim lift --resume --out {run})." in printed
    (overall,) = (line for line in printed.splitlines() if line.strip().startswith("overall"))
    stable = sum(row["failure"] != "unstable_simulation" for row in rows[:2])
    assert overall.split()[1] == str(6 + stable)


def test_compare_counts_what_a_killed_run_left_in_shards(run, capsys):
    rows = records.read_rows(run / "trials.parquet")
    records.write_rows(rows[:1], run / "trials.parquet")
    ShardWriter(run / "shards").append(rows[1:])
    before = (run / "trials.parquet").read_bytes()
    assert main(["compare", str(run), "--no-report"]) == 0
    assert "3 trials left out" in capsys.readouterr().out  # the stand-ins' are all unstable
    assert (run / "trials.parquet").read_bytes() == before  # a run that goes on is left alone
    (shard,) = (run / "shards").iterdir()
    shard.write_bytes(shard.read_bytes()[:-8])
    assert "damaged" in fails(capsys, "compare", run)


def test_compare_refuses(run, tmp_path, capsys):
    assert "does not exist" in fails(capsys, "compare", tmp_path / "none")
    (tmp_path / "empty").mkdir()
    assert "holds no run: it has no trials.parquet" in fails(capsys, "compare", tmp_path / "empty")
    assert "is given twice" in fails(capsys, "compare", run, tmp_path / "run" / ".")
    assert "--csv" in fails(capsys, "compare", run, "--csv", run / "run.json" / "x.csv")
    assert "--csv" in fails(capsys, "compare", run, "--csv", run)
    assert "runs" in fails(capsys, "compare").lower()
    records.write_rows([], run / "trials.parquet")
    assert "no finished trial" in fails(capsys, "compare", run)


def test_show_refuses(run, tmp_path, capsys, quick):
    assert "has trials 0 to 2" in fails(capsys, "show", run, "--trial", "3")
    assert "trial -1 is not in the run" in fails(capsys, "show", run, "--trial", "-1")
    assert "'--trial'" in fails(capsys, "show", run)
    assert "is not a folder" in fails(capsys, "show", tmp_path / "none", "--trial", "0")
    assert "no run.json" in fails(capsys, "show", tmp_path, "--trial", "0")
    below = run / "run.json" / "t.rrd"
    assert "choose another --save" in fails(capsys, "show", run, "--trial", "0", "--save", below)
    assert "choose another --png" in fails(capsys, "show", run, "--trial", "0", "--png", run)
    rows = records.read_rows(run / "trials.parquet")
    records.write_rows(rows[:1], run / "trials.parquet")
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
        monkeypatch.setitem(sys.modules, f"sdh_sim.{module}", fake)
    return calls


def test_show_repeats_the_trial_and_writes(run, tmp_path, capsys, quick, writers):
    rrd, png = tmp_path / "new" / "t.rrd", tmp_path / "t.png"
    arguments = ["show", str(run), "--trial", "1", "--save", str(rrd), "--png", str(png)]
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    row = records.read_rows(run / "trials.parquet")[1]
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

    use(monkeypatch, other)
    info = json.loads((run / "run.json").read_text())
    info["sessions"][-1]["versions"]["numpy"] = "1.0"
    (run / "run.json").write_text(json.dumps(info))
    assert main(["show", str(run), "--trial", "1"]) == 0
    err = capsys.readouterr().err
    assert err.startswith(
        "warning: the repeated trial differs from the stored one in contacts, mass_kg"
    )
    assert "numpy 1.0 is now" in err


def test_lists(capsys):
    assert main(["objects"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"cylindrical_bottle\s+0\.556\s+0\.60\s", printed)
    assert main(["hand"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"14\s+6\s+84\s", printed)
    assert "N m" in printed


def test_help_loads_nothing_heavy():
    code = (
        "import sys, sdh_sim.cli as c; c.main(['lift', '--help']); "
        "print(sorted({'mujoco', 'numpy', 'rerun', 'pyarrow', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "--torque-limit" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip()


def test_a_closed_pipe_is_quiet(run):
    done = subprocess.run(
        f"{sys.executable} -m sdh_sim.cli compare {run} | true",
        shell=True,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
