"""Metrics ranked on real snapshots: on the command line, in a program and in the experiment."""

from __future__ import annotations

import csv
import pickle
from pathlib import Path

import numpy as np
import pytest

import sdh_sim
from experiments.leaderboard.__main__ import main as leaderboard
from experiments.leaderboard.learned import features_of, learned_entrants, tree_scores
from experiments.success_prediction import baselines
from sdh_sim.analysis.leaderboard import Outcomes
from sdh_sim.cli.app import main
from sdh_sim.metrics import find_metrics
from sdh_sim.metrics.field import KNOWN
from sdh_sim.metrics.field_scores import ScoreJob, hand_of_job, score_job
from sdh_sim.records import normalise, write_rows
from sdh_sim.robot import find_hand
from sdh_sim.runs import RunFolder, RunPlan, columns_of_run
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial
from tests.support.hand_folders import write_hand

TRIALS = 8
SETTINGS = TrialSettings("oval_bottle", grasps="precision", lift_off=True, settle="verdict")
OWN = """
def pressure(grasp):
    return float(sum(array.sum() for array in grasp.snapshot.tactile.values()))

def broken(grasp):
    raise ValueError("no idea")

def flat(grasp):
    return 1
"""


@pytest.fixture(scope="module")
def real() -> dict:
    """A grasp that holds, with a snapshot at lift-off."""
    for seed in range(100):
        row = run_trial(SETTINGS, seed).row
        if row["success"] and row["contacts"] and row["liftoff_object_pose_hand"] is not None:
            return {**row, "trial": 0}
    raise AssertionError("no such grasp")


@pytest.fixture(scope="module")
def run(real, tmp_path_factory) -> Path:
    """Trials made of one snapshot: those that held press harder, in the readings."""
    folder = RunFolder(tmp_path_factory.mktemp("board") / "run")
    folder.make()
    plan = RunPlan(("oval_bottle",), SETTINGS, TRIALS, 0)
    rows = []
    for k in range(TRIALS):
        held = k % 2 == 0
        change = {"trial": k, "seed": plan.job(k).seed, "success": held, "q_sim": 1.0 + held + k}
        change["failure"] = "none" if held else "slipped"
        for name in ("tactile_distal", "tactile_proximal"):
            change[name] = (2.0 if held else 1.0) * np.asarray(real[name])
        rows.append({**real, **change, "q_sim_capped": False})
    write_rows(rows, folder.table, columns_of_run(SETTINGS))
    folder.write_info(plan, [])
    return folder.path


@pytest.fixture
def own(tmp_path) -> Path:
    path = tmp_path / "own.py"
    path.write_text(OWN)
    return path


def test_every_metric_has_a_value_and_a_cost(real):
    job = ScoreJob(normalise(real), "distal", None, None, {}, tuple(KNOWN), ())
    found = score_job(job)
    assert found is not None
    assert found.sensed
    assert not found.faults
    assert (found.seconds > 0).sum() > len(KNOWN) - 3  # the clock is coarse
    for name, value in zip(KNOWN, found.values, strict=True):
        assert not np.isnan(value), name


def test_metrics_of_a_stored_grasp_are_those_of_its_trial(real):
    names = ("q_linf", "q_l1", "q_capability", "epsilon_l1", "volume_linf")
    found = score_job(ScoreJob(normalise(real), "all", None, None, {}, names, ()))
    assert found is not None
    stored = [real[name] for name in names]
    assert found.values == pytest.approx(stored, rel=1e-5)  # readings are single in the table


def test_a_metric_that_raises_costs_itself(real, own):
    metrics = find_metrics([f"{own}:broken", f"{own}:pressure"])
    found = score_job(ScoreJob(normalise(real), "all", None, None, {}, ("q_linf",), metrics))
    assert found is not None
    assert found.faults == {"broken": "ValueError: no idea"}
    assert np.isnan(found.values).tolist() == [False, True, False]


def test_a_job_of_a_users_hand_goes_to_another_process(tmp_path):
    folder = write_hand(tmp_path / "hand")
    hand, kept = find_hand(str(folder))
    job = ScoreJob({}, "all", hand, kept, {}, ("q_linf",), ())
    there = pickle.loads(pickle.dumps(job))
    assert there == job
    found = hand_of_job(there)
    assert found is not None
    assert found.hand.name == "gripper"


def test_compare_ranks_metrics_and_shows_them_in_the_report(run, own, capsys):
    asked = f"q_linf,dfc_residual,{own}:pressure,{own}:broken,{own}:flat"
    assert main(["compare", str(run), "--metrics", asked, "--workers", "1"]) == 0
    printed = capsys.readouterr().out
    lines = [line.split() for line in printed.splitlines()]
    ranked = [words[0] for words in lines if "own" in words and "%" not in words]
    assert ranked[0] == "pressure"
    assert f"broken: failed (ValueError: no idea); no value for {TRIALS}." in printed
    assert "flat: constant." in printed
    page = (run / "report" / "index.html").read_text()
    assert "Metrics side by side" in page
    assert f"no value for {TRIALS}" in page
    assert (run / "report" / "leaderboard.svg").exists()


def test_a_program_ranks_functions(run):
    def pressure(grasp):
        return float(sum(array.sum() for array in grasp.snapshot.tactile.values()))

    board = sdh_sim.leaderboard(run, ["q_linf", pressure])
    best, other = board.standings["oval_bottle"]
    assert (best.entrant.name, best.auc) == ("pressure", 1.0)
    assert (other.entrant.name, other.n) == ("q_linf", TRIALS)
    with pytest.raises(sdh_sim.SettingsError, match="two of the name pressure"):
        sdh_sim.leaderboard(run, [pressure, pressure])


def test_the_experiment_writes_every_moment(run, tmp_path, capsys):
    out = tmp_path / "out"
    asked = ["--metrics", "q_linf,dfc_residual", "--workers", "1", "--out", str(out)]
    leaderboard([str(run), *asked])
    printed = capsys.readouterr().out
    with (out / "leaderboard.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    found = {(row["moment"], row["metric"]): row for row in rows}
    assert {moment for moment, _ in found} == {"before the lift", "at lift-off", "where it settles"}
    assert ("before the lift", "q_settled") in found  # stored with the trials
    assert all(row["n"] == str(TRIALS) for row in rows)
    assert "DFC" in printed
    assert (out / "leaderboard.png").exists()


def test_the_experiment_refuses(run, tmp_path, capsys):
    for asked, word in (
        ((str(run), str(tmp_path)), "give --out"),
        ((str(tmp_path / "none"), "--out", str(tmp_path)), "does not exist"),
        ((str(run), "--metrics", "nonsense"), "nonsense"),
    ):
        with pytest.raises(SystemExit) as stopped:
            leaderboard(list(asked))
        assert stopped.value.code == 2
        assert word in capsys.readouterr().err


def test_learned_predictors_have_not_seen_their_trial(real, monkeypatch):
    monkeypatch.setattr(baselines, "PENALTIES", (1.0,))  # choosing takes its time
    draw = np.random.default_rng(0)
    count = 4 * baselines.FEWEST
    success = draw.random(count) < 0.5
    rows = [
        {**real, "motor_torque_nm": np.asarray(real["motor_torque_nm"]) * (1.0 + s)}
        for s in success
    ]
    objects = np.arange(count) % 3
    known = Outcomes(success, np.arange(count) % 4, None, np.zeros(count), np.ones(count, bool))
    found = {e.name: e for e in learned_entrants(rows, known, objects)}
    if not found:
        pytest.skip("scikit-learn, the extra 'learn', is not installed")
    assert set(found) == {"logistic", "trees", "logistic_unseen", "trees_unseen"}
    assert ((found["trees_unseen"].values > 0.5) == success).all()
    blind = tree_scores(features_of([real] * count), success, objects)
    assert abs(blind - success.mean()).max() < 0.2  # nothing to learn


def test_features_of_a_trial_without_a_snapshot_are_zero(real):
    none = {name: None for name in real} | {"mass_kg": 0.5, "friction": 0.4}
    with_one, without = features_of([real, none])
    assert with_one.shape == without.shape
    assert (without != 0).sum() == 2
