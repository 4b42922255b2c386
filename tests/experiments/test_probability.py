"""Scores of probabilities in closed form, and the study on a table made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import probability
from experiments.probability_scores import (
    Shares,
    bins_of,
    brier,
    brier_interval,
    calibrated,
    copies_auc,
    fit_logistic,
    least_brier,
)
from sdh_sim.analysis.comparison import auc
from sdh_sim.records import write_rows
from sdh_sim.runs import RunFolder, RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from tests.support import trial_stand_ins as stand_ins
from tests.support.run_folders import write_finished_run


def test_the_brier_score_is_that_of_the_copies():
    shares = Shares(np.array([3, 0, 4]), np.array([4, 4, 8]))
    predicted = np.array([0.8, 0.1, 0.5])
    each = np.repeat(predicted, shares.copies)
    outcomes = np.concatenate([[1] * h + [0] * (n - h) for h, n in zip(*shares, strict=True)])
    assert brier(predicted, shares).score == pytest.approx(np.mean((each - outcomes) ** 2))


def test_its_parts_add_up():
    rng = np.random.default_rng(0)
    shares = Shares(rng.integers(0, 9, 40), np.full(40, 8))
    b = brier(rng.uniform(size=40), shares)
    assert b.score == pytest.approx(b.reliability - b.resolution + b.uncertainty + b.within)
    # Predictions alike within every bin leave nothing within.
    b = brier(rng.integers(0, 5, 40) / 5 + 0.1, shares)
    assert b.within == pytest.approx(0.0, abs=1e-12)


def test_perfect_and_constant_predictions():
    shares = Shares(np.array([0, 2, 8, 6]), np.full(4, 8))
    best = brier(shares.value, shares)
    assert best.score == pytest.approx(least_brier(shares))
    assert best.reliability == pytest.approx(0.0)
    base = brier(np.full(4, 0.5), shares)
    assert base.score == pytest.approx(base.uncertainty) == pytest.approx(0.25)
    assert base.resolution == pytest.approx(0.0)


def test_one_belongs_to_the_last_bin():
    found = bins_of(np.array([1.0, 0.95, 0.0]), Shares(np.array([1, 2, 0]), np.array([1, 3, 2])))
    assert [b.copies for b in found] == [2, 4]
    assert found[1].observed == pytest.approx(3 / 4)
    assert found[1].predicted == pytest.approx((1.0 + 3 * 0.95) / 4)


def test_the_area_of_copies_is_that_of_all_of_them():
    rng = np.random.default_rng(1)
    shares = Shares(rng.integers(0, 5, 30), np.full(30, 4))
    scores = rng.integers(0, 10, 30).astype(float)
    every = np.repeat(scores, 4)
    outcomes = np.concatenate([[True] * h + [False] * (4 - h) for h in shares.held])
    assert copies_auc(scores, shares)[0] == pytest.approx(auc(every, outcomes))
    # A trial that is drawn twice counts twice.
    twice = Shares(np.append(shares.held, shares.held[0]), np.append(shares.copies, 4))
    weights = np.ones((1, 30), dtype=int)
    weights[0, 0] = 2
    drawn = copies_auc(scores, shares, weights)[0]
    assert drawn == pytest.approx(copies_auc(np.append(scores, scores[0]), twice)[0])
    assert np.isnan(copies_auc(scores, Shares(np.full(30, 4), np.full(30, 4)))[0])


def test_a_logistic_curve_is_found_again():
    feature = np.linspace(-2, 2, 400)
    truth = 1 / (1 + np.exp(-(0.5 + 1.7 * feature)))
    count = np.full(400, 1000)
    intercept, slope = fit_logistic(feature, Shares(np.round(1000 * truth).astype(int), count))
    assert (intercept, slope) == pytest.approx((0.5, 1.7), abs=0.03)
    # Trials that a threshold divides have a finite curve, and it ends.
    divided = Shares(np.where(feature > 0, 8, 0), np.full(400, 8))
    assert np.isfinite(fit_logistic(feature, divided)).all()
    assert fit_logistic(np.zeros(400), divided)[1] == 0.0


def test_calibration_learns_from_the_other_folds():
    rng = np.random.default_rng(2)
    q = rng.gamma(2.0, 1.0, 300)
    p = 1 / (1 + np.exp(-3 * (np.log1p(q) - 1)))
    shares = Shares(rng.binomial(8, p), np.full(300, 8))
    q[5] = np.inf
    found = calibrated(q, shares, np.arange(300) % 10)
    assert ((found > 0) & (found < 1)).all()
    assert brier(found, shares).score < brier(np.full(300, p.mean()), shares).score - 0.02
    low, high = brier_interval(found, shares, np.random.default_rng(0), 200)
    assert low < brier(found, shares).score < high


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """One snapshot, whose row stands for 12 trials with other q* and shares."""
    out = tmp_path_factory.mktemp("probability") / "run"
    out.mkdir()
    settings = TrialSettings("box", timestep=4e-3, repeats=4, position_error=2e-3)
    trial = Trial(settings, 5)
    trial.acquire()
    trial.snapshot()
    assert trial.prediction is not None
    row = {name: value for name, value in trial.row.items() if value is not None}
    row["torque_limit_nm"] = trial.prediction.grasp.torque_limits
    RunFolder(out).write_info(RunPlan(("box",), settings, 12, 5), [{"state": "finished"}])
    rng = np.random.default_rng(0)
    rows = []
    for k, q in enumerate(rng.uniform(0.2, 2.0, 12)):
        held = int(rng.binomial(4, min(1.0, q / 2)))
        change = {"repeats": 4, "success_probability": held / 4, "success": held > 2}
        failure = "none" if held > 2 else "dropped"
        rows.append(row | change | {"trial": k, "seed": k, "q_linf": q, "failure": failure})
    write_rows(rows, out / "trials.parquet")
    return out


def test_the_study_prints_and_draws(run, capsys):
    probability.main([str(run), "--samples", "2"])
    printed = capsys.readouterr().out
    for words in ("12 grasps, 48 copies", "P_fc", "robust ε, calibrated", "own share"):
        assert words in printed
    assert (run / "probability" / "reliability.png").stat().st_size > 5000


def one_line(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        probability.main([str(a) for a in arguments])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert len(said.strip().splitlines()) == 1
    return said


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"position_error": 1e-3}, "no repeats; lift with --repeats"),
        ({"repeats": 4}, "declares no error of perception"),
        (
            {"repeats": 4, "position_error": 1e-3, "angle_error": 0.01, "touch": True},
            "corrected by touch",
        ),
        ({"repeats": 4, "position_error": 1e-3}, "0 trials with a snapshot and repeats"),
    ],
)
def test_runs_that_cannot_be_used_are_one_line(tmp_path, capsys, settings, words):
    out = tmp_path / "run"
    out.mkdir()
    write_finished_run(stand_ins.plan(trials=2, **settings), out)
    assert words in one_line(capsys, out)


def test_bad_command_lines_are_one_line(run, tmp_path, capsys):
    assert "nothing" in one_line(capsys, tmp_path / "nothing")
    assert "--samples must be at least 1" in one_line(capsys, run, "--samples", "0")
