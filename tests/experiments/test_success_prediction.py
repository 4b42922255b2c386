"""The study of all metrics: variants are what they name, and no score has seen its grasp."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from experiments.success_prediction import baselines
from experiments.success_prediction.__main__ import main, unseen_contacts, with_pads
from experiments.success_prediction.metric_grid import (
    Variant,
    evaluate,
    evaluate_all,
    evaluate_row,
    grid,
)
from experiments.success_prediction.metric_scores import Candidate, assess, folds_and_outcomes
from experiments.success_prediction.published import REFERENCE
from sdh_sim.analysis.study import study_of
from sdh_sim.metrics import METRICS, grasp_of, read_stored
from sdh_sim.metrics.built_in import MAX_VOLUME_CONTACTS
from sdh_sim.records import normalise, write_rows
from sdh_sim.robot import HandKinematics
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial

TRIALS = 8  # too few of either outcome to learn from: the baseline that learns is tested by itself


@pytest.fixture(scope="module")
def real() -> dict:
    """A grasp that the fingertips alone could hold, with a proximal contact beside them."""
    fingertips = [Variant("q", "linf", 12, "hf")]
    for seed in range(3, 200):
        row = run_trial(TrialSettings("oval_bottle"), seed).row
        if np.any(row.get("tactile_proximal")) and row["contacts"] <= 4:
            row = {**row, "trial": 0, "q_sim": 2.0, "q_sim_capped": False}
            if evaluate_row((normalise(row), fingertips, {}))[0] > 0.1:
                return row
    raise AssertionError("no such grasp")


@pytest.fixture(scope="module")
def run(real, tmp_path_factory) -> Path:
    """Trials made of one snapshot, pressed with different force, half of them held."""
    folder = tmp_path_factory.mktemp("study") / "run"
    folder.mkdir()
    rows = []
    for k in range(TRIALS):
        failure = "none" if k % 2 else "slipped"
        change = {"trial": k, "seed": k, "success": failure == "none", "failure": failure}
        change["object"] = ("box", "oval_bottle")[k // (TRIALS // 2)]
        change["q_sim"] = real["q_sim"] * (1 + 0.01 * k) if k % 2 else 0.0
        change["tactile_distal"] = (1 + k % 2) * np.asarray(real["tactile_distal"])
        # Pads with no contact at all in every eighth grasp.
        if k % 8 == 0:
            change["tactile_distal"] = np.zeros((3, 13, 6))
            change["tactile_proximal"] = np.zeros((3, 14, 6))
        rows.append({**real, **change})
    write_rows(rows, folder / "trials.parquet")
    return folder


def in_turn(function, jobs):
    return [function(job) for job in jobs]


def test_the_grid_names_every_variant_once():
    for full in (False, True):
        keys = [variant.key for variant in grid(full)]
        assert len(set(keys)) == len(keys)
        labels = [(v.group, v.assumes, v.pads) for v in grid(full)]
        assert len(set(labels)) == len(labels)
    crossed = {v for v in grid(True) if v.kind == "q"}
    assert len(crossed) == 2 * 2 * 4 * 2 * 2  # pads, bounds, augmentations, edges, unloading
    assert set(grid()) <= set(grid(True))


@pytest.mark.parametrize(
    ("variant", "column"),
    [
        (Variant("q", "linf", 12, "hf", True, "all"), "q_linf"),
        (Variant("q", "l1", 12, "hf", True, "all"), "q_l1"),
        (Variant("capability", pads="all"), "q_capability"),
        (Variant("held", pads="all"), "q_held"),
        (Variant("whole", pads="all"), "q_whole_hand"),
        (Variant("epsilon", "linf", 12, "hf", True, "all"), "epsilon_linf"),
        (Variant("epsilon", "l1", 12, "hf", True, "all"), "epsilon_l1"),
        (Variant("volume", "l1", 12, "none", True, "all"), "volume_l1"),
    ],
)
def test_the_papers_variants_are_the_columns_of_the_trial(real, variant, column):
    row = normalise(real)
    grasp = grasp_of(row, "all", HandKinematics())
    assert grasp is not None
    in_trial = METRICS[column](grasp)
    if np.isnan(in_trial):  # a trial leaves the volume of many contacts out
        assert column.startswith("volume")
        assert len(grasp.contacts) > MAX_VOLUME_CONTACTS
        return
    assert evaluate(variant, grasp) == pytest.approx(in_trial, rel=1e-9)
    (value,) = evaluate_row((row, [variant], {}))
    if row[column] is not None:
        assert value == pytest.approx(row[column], rel=1e-4)


def test_assumptions_move_q_the_way_they_must(real):
    row = normalise(real)

    def q(**change) -> float:
        variant = replace(Variant("q", "linf", 12, "hf"), **change)
        return evaluate_row((row, [variant], {}))[0]

    def at_most(*values: float) -> bool:
        """Each is at most the next, within round-off."""
        return all(a <= b * (1 + 1e-12) for a, b in itertools.pairwise(values))

    assert q(bound="l1") < q()
    assert at_most(q(augment="none"), q(augment="fl"), q(), q(augment="sf"))
    assert at_most(q(), q(edges=None), 1.1 * q())
    assert at_most(q(unloading=False), q())
    assert at_most(q(), q(pads="all"))


def test_no_contact_and_no_snapshot(real):
    row = normalise(real)
    untouched = {"tactile_distal": np.zeros((3, 13, 6)), "tactile_proximal": np.zeros((3, 14, 6))}
    empty = {**row, **untouched}
    assert set(evaluate_row((empty, grid(), {}))) == {0.0}
    assert np.isnan(evaluate_row(({**row, "joint_angles_rad": None}, grid(), {}))).all()


def table_of(success, objects=None) -> pa.Table:
    names = objects or ["box"] * len(success)
    return pa.table(
        {
            "object": names,
            "success": pa.array(success),
            "failure": ["none" if s else "dropped" for s in success],
        }
    )


def test_candidates_are_scored_as_defined():
    success = np.arange(60) % 2 == 0
    separated = np.where(success, 3.0, 0.2) + np.arange(60) * 1e-3
    missing = np.where(np.arange(60) < 10, np.nan, separated)
    results = assess(
        table_of(success),
        [
            Candidate("a", "", "all", separated, boundary=1.0),
            Candidate("b", "", "all", missing, boundary=1.0),
            Candidate("c", "", "all", missing, drop_missing=True),
            Candidate("d", "", "all", -separated),
        ],
    )
    first, zeroed, dropped, mirrored = results
    assert first.comparison.auc == first.comparison.accuracy.value == 1.0
    assert first.best is not None
    assert first.best.accuracy.value == 1.0
    assert zeroed.comparison.n == 60
    assert zeroed.comparison.fn == 5
    assert (dropped.comparison.n, dropped.comparison.auc) == (50, 1.0)
    assert dropped.record()["accuracy"] is None
    assert mirrored.comparison.auc == 0.0


def test_unstable_trials_have_no_fold():
    table = table_of([True, False] * 10)
    failure = ["unstable_simulation", *table.column("failure").to_pylist()[1:]]
    table = table.set_column(2, "failure", pa.array(failure))
    _, usable, fold = folds_and_outcomes(table)
    assert usable.sum() == 19
    assert fold[0] == -1
    assert (fold[1:] >= 0).all()


def test_plain_baselines_by_hand():
    distal, proximal = np.zeros((3, 13, 6)), np.zeros((3, 14, 6))
    distal[0, 2, 1], distal[0, 4, 1], proximal[2, 3, 5] = 1.0, 3.0, 5.0
    row = {"tactile_distal": distal, "tactile_proximal": proximal}
    assert baselines.sum_of_readings(row) == 9
    assert baselines.sum_of_readings(row, ["tactile_distal"]) == 4
    assert baselines.pads_in_contact(row) == 2
    assert baselines.active_taxels(row) == 3
    features, none = baselines.tactile_features([row, {}])
    assert features.shape == (24,)
    assert features[:4] == pytest.approx([np.log(5), 2, 3.5, 1])
    assert features[-4:] == pytest.approx([np.log(6), 1, 3, 5])
    assert (none == 0.0).all()
    assert unseen_contacts([row], "distal") == [True]
    assert unseen_contacts([row], "all") == [False]
    assert unseen_contacts([{**row, "unsensed_contact": True}], "all") == [True]


def test_baselines_know_the_object_as_the_metrics_do():
    true = {"object_pose_hand": np.arange(7.0), "mass_kg": 0.5, "friction": 0.6}
    seen = {**true, "perceived_pose_hand": 2.0 * np.arange(7.0)}
    seen |= {"perceived_mass_kg": 0.4, "perceived_friction": 0.7}
    known, perceived = baselines.object_features([true, seen])
    assert known[:7].tolist() == list(range(7))
    assert known[-2:].tolist() == [0.5, 0.6]
    assert perceived[:7].tolist() == [2.0 * k for k in range(7)]
    assert perceived[-2:].tolist() == [0.4, 0.7]


def test_logistic_regression_learns_from_the_other_folds_alone():
    pytest.importorskip("sklearn", reason="the extra 'learn' is not installed")
    rng = np.random.default_rng(0)
    success = np.arange(90) % 2 == 0
    fold = np.arange(90) // 2 % 5
    told = np.column_stack((np.where(success, 1.0, -1.0), rng.normal(size=90)))
    scores = baselines.logistic_scores(told, success, fold)
    assert (scores[success] > 0.5).all()
    assert (scores[~success] < 0.5).all()
    # Many features of noise: a model that had seen its grasps would separate them.
    noise = baselines.logistic_scores(rng.normal(size=(90, 45)), success, fold)
    assert abs(np.mean((noise > 0.5) == success) - 0.5) < 0.2


def test_figures_show_the_chosen_pads(run):
    table, rows = read_stored([run / "trials.parquet"])
    shown = [v for v in grid() if v.has_boundary and v.edges and v.augment in ("", "hf")]
    values = evaluate_all(rows, shown, in_turn)
    scores = {
        pads: study_of(with_pads(table, values, pads), resamples=50)
        .findings["overall", "q_linf"]
        .scored.scores
        for pads in ("distal", "all")
    }
    expected = values[Variant("q", "linf", 12, "hf", True, "distal")]
    np.testing.assert_array_equal(scores["distal"], expected)
    assert (scores["all"] != scores["distal"]).any()


def test_published_rates_fit_together():
    # With as many stable as unstable grasps, the accuracy is the mean of both rates.
    for metric in ("q_linf", "q_l1"):
        numbers = REFERENCE["overall", metric]
        assert numbers["accuracy"] == pytest.approx((numbers["tpr"] + numbers["tnr"]) / 2)


def test_the_study_end_to_end(run, capsys):
    main([str(run), "--workers", "1"])
    printed = capsys.readouterr().out
    out = run / "success_prediction"
    assert f"report: {out / 'index.html'}" in printed
    page = (out / "index.html").read_text()
    for heading in ("Beside the paper", "All metrics on the same grasps", "Why the bounds miss"):
        assert f"<h2>{heading}</h2>" in page
    assert "74.5 %" in page
    table = pq.read_table(out / "metrics.parquet").to_pylist()
    wrench = [r for r in table if r["metric"] not in ("no wrenches", "logistic regression")]
    assert len(wrench) == len(grid())
    assert sum(r["metric"] == "no wrenches" for r in table) == 6
    # The rows are made so that the force alone separates held grasps from the others.
    (readings,) = (r for r in table if (r["assumes"], r["pads"]) == ("sum of readings", "distal"))
    assert readings["auc"] == 1.0
    scores = pq.read_table(out / "scores.parquet")
    assert scores.num_rows == TRIALS
    assert set(scores.column_names) >= {variant.key for variant in grid()}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["{run}", "{run}"], "give --out"),
        (["{run}", "{run}", "--out", "x"], "given twice"),
        (["nowhere"], "is not a run folder"),
        (["nowhere", "--out", "x"], "nowhere does not exist"),
        (["{run}", "--pads", "none"], "--pads"),
    ],
)
def test_the_study_refuses_in_one_line(run, capsys, arguments, words):
    with pytest.raises(SystemExit) as caught:
        main([a.format(run=run) for a in arguments])
    assert caught.value.code == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
