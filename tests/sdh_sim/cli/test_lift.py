"""What ``lift`` makes of its options, and what it prints."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

from sdh_sim.campaign import paper_preset
from sdh_sim.cli.app import main
from sdh_sim.records import read_rows
from sdh_sim.runs import RunFolder, RunPlan
from sdh_sim.settings import TrialSettings
from tests.support import trial_stand_ins as stand_ins
from tests.support.command_line import LIFT, use_trial
from tests.support.repository import ROOT


def test_lift_prints_progress_and_table(tmp_path, capsys, quick):
    out = tmp_path / "out"
    assert main([*LIFT, str(out), "--object", "oval_bottle", "--trials", "5"]) == 0
    printed, err = capsys.readouterr()
    rows = read_rows(out / "trials.parquet")
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
    use_trial(monkeypatch, stand_ins.raises)
    out = tmp_path / "out"
    assert main([*LIFT, str(out), "--trials", "12"]) == 0
    printed, err = capsys.readouterr()
    bad = sum(row["failure"] == "error" for row in read_rows(out / "trials.parquet"))
    assert bad > 0
    assert f"error {bad}" in printed
    assert err.splitlines()[-1] == (
        f"note: {bad} trials ended as error, see {out}/errors; run them again with: "
        f"sdh-sim lift --resume --out {out} --retry-errors"
    )
    use_trial(monkeypatch, stand_ins.quick)
    assert main(["lift", "--resume", "--out", str(out), "--retry-errors"]) == 0
    assert "error" not in capsys.readouterr().err
    assert not any(r["failure"] == "error" for r in read_rows(out / "trials.parquet"))


def test_all_trials_failing_is_one_line_and_its_traceback_on_request(tmp_path, capsys, monkeypatch):
    use_trial(monkeypatch, stand_ins.always_fails)
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
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.cli import lift, main
from tests.support import trial_stand_ins
lift.run_campaign = functools.partial(run_campaign, trial=trial_stand_ins.slow)
sys.exit(main())
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
    kept = len(read_rows(out / "trials.parquet"))
    assert 0 < kept < 200
    assert "Traceback" not in shown
    message = " ".join(shown[shown.index("sdh-sim: interrupted") :].split())
    assert message.endswith(
        f"interrupted: {kept} of 200 trials are kept in {out}/trials.parquet; "
        f"continue with: sdh-sim lift --resume --out '{out}'"
    )


def test_a_preset_stands_below_what_is_given(tmp_path, quick):
    fast, mixed = tmp_path / "fast", tmp_path / "mixed"
    assert main([*LIFT, str(fast), "--trials", "1", "--preset", "fast"]) == 0
    assert RunFolder(fast).read_plan().settings == TrialSettings("box", timestep=0.004)
    given = ["--preset", "fast", "--timestep", "0.001", "--arm", "rigid"]
    assert main([*LIFT, str(mixed), "--trials", "1", *given]) == 0
    wanted = TrialSettings("box", timestep=0.001, arm="rigid")
    assert RunFolder(mixed).read_plan().settings == wanted


def test_the_papers_preset_runs_rounds_until_its_shares_are_full(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(paper_preset, "PAPER_SHARES", {"box": 2, "oval_bottle": 3})
    monkeypatch.setattr(paper_preset, "FIRST", 4)
    monkeypatch.setattr(paper_preset, "MOST", 60)
    use_trial(monkeypatch, stand_ins.either)
    out = tmp_path / "out"
    lift = ["lift", "--preset", "paper", "--out", str(out)]
    assert main([*lift, "--sensor", "ideal"]) == 0
    printed, err = capsys.readouterr()
    plan = RunFolder(out).read_plan()
    assert plan.objects == ("box", "oval_bottle")
    assert plan.trials > 4
    assert plan.settings == TrialSettings("box", grasps="precision", pads="distal", sensor="ideal")
    assert f"on to {plan.trials} trials of each" in err
    assert "shares: box " in printed.splitlines()[-1]
    rows = [row for row in read_rows(out / "trials.parquet") if not row["surplus"]]
    for name, share in paper_preset.PAPER_SHARES.items():
        held = [row["success"] for row in rows if row["object"] == name]
        assert (held.count(True), held.count(False)) == (share, share)
    assert main([*lift, "--sensor", "ideal", "--resume"]) == 0  # nothing left to do
    assert RunFolder(out).read_plan() == plan

    use_trial(monkeypatch, stand_ins.holds)
    capsys.readouterr()
    assert main([*lift, "--overwrite"]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert "--preset: box, oval_bottle cannot fill the paper's share in 60 trials" in line
    assert RunFolder(out).read_plan().trials == 60
