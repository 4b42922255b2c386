"""Runs with grasps from a file: numbers and seeds of their trials, and what run.json keeps."""

from __future__ import annotations

import dataclasses
import json

import pytest

from sdh_sim.errors import GraspFileError, RunError, SettingsError
from sdh_sim.grasp_files import find_grasp_set, write_grasps
from sdh_sim.runs import RunPlan, read_given_grasps, trial_seed, with_grasp
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import GraspSet
from tests.support.grasp_entries import entries
from tests.support.trial_stand_ins import plan

COUNTS = {"box": 3, "oval_bottle": 2}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "grasps.csv"
    write_grasps(entries(5), path)  # box and oval_bottle in turn
    return path


def given_plan(file, copies: int = 1) -> RunPlan:
    reference, _ = find_grasp_set(file)
    settings = TrialSettings("box", grasps="file", grasp_set=reference)
    return RunPlan(("box", "oval_bottle"), settings, copies, 7, {}, COUNTS)


def test_every_grasp_is_tried_once_before_any_is_tried_again(file):
    jobs = list(given_plan(file, 2).jobs())
    assert [j.trial for j in jobs] == list(range(10))
    assert [(j.settings.object, j.grasp_number, j.copy) for j in jobs] == [
        *(("box", n, c) for c in (0, 1) for n in (0, 1, 2)),
        *(("oval_bottle", n, c) for c in (0, 1) for n in (0, 1)),
    ]
    assert [j.seed for j in jobs[6:]] == [trial_seed(7, "oval_bottle", k) for k in range(4)]
    assert len({j.seed for j in jobs}) == 10


def test_more_copies_leave_the_seeds_of_those_before(file):
    def seeds(copies: int) -> dict[tuple, int]:
        jobs = given_plan(file, copies).jobs()
        return {(j.settings.object, j.grasp_number, j.copy): j.seed for j in jobs}

    few, many = seeds(2), seeds(5)
    assert few.items() < many.items()


def test_a_job_gets_its_own_grasp(file):
    run = given_plan(file, 2)
    given = read_given_grasps(run)
    names = [with_grasp(job, given).labels["grasp_name"] for job in run.jobs()]
    box = [e.name for e in entries(5) if e.object == "box"]
    oval = [e.name for e in entries(5) if e.object == "oval_bottle"]
    assert names == [*box, *box, *oval, *oval]
    labels = with_grasp(run.job(4), given).labels
    assert labels["trial"] == 4
    assert labels["grasp_copy"] == 1
    assert labels["grasp_confidence"] == entries(5)[2].confidence


def test_random_grasps_have_no_labels_but_their_number():
    job = plan().job(3)
    assert with_grasp(job, read_given_grasps(plan())) == job
    assert job.labels == {"trial": 3}


def test_run_json_keeps_the_file_and_the_counts(file):
    run = given_plan(file)
    kept = RunPlan.from_dict(json.loads(json.dumps(run.to_dict())))
    assert kept == run
    assert kept.total == 5
    assert "grasp_counts" not in plan().to_dict()


def test_a_run_json_of_before_there_were_files_is_read():
    data = plan().to_dict()
    for name in ("grasp_set", "support", "gravity"):
        del data["settings"][name]
    assert RunPlan.from_dict(data) == plan()
    assert RunPlan.from_dict(data).changes_from(plan()) == []


def test_a_file_that_moved_is_no_change_and_another_is(file, tmp_path):
    run = given_plan(file)
    moved = given_plan(file.rename(tmp_path / "moved.csv"))
    assert moved.changes_from(run) == []
    write_grasps(entries(5, seed=1), file)
    (change,) = given_plan(file).changes_from(run)
    assert change.startswith("grasp_set (run: sha256 ")
    assert "grasps (run: any, asked: file)" in run.changes_from(plan(objects=run.objects))


def test_a_changed_or_missing_file_is_refused(file):
    run = given_plan(file)
    file.write_text(file.read_text().replace("e-0", "e-1", 1))
    with pytest.raises(GraspFileError, match="has changed since the run began; bring the file bac"):
        read_given_grasps(run)
    file.unlink()
    with pytest.raises(GraspFileError, match="No such file"):
        read_given_grasps(run)


@pytest.mark.parametrize(
    "counts", [{}, {"box": 3}, {**COUNTS, "mug": 1}, {"box": 0, "oval_bottle": 1},
               {"box": True, "oval_bottle": 1}, {"box": 1.0, "oval_bottle": 1}],
)  # fmt: skip
def test_counts_that_are_not_those_of_the_objects(file, counts):
    with pytest.raises(SettingsError, match="grasp_counts: got"):
        dataclasses.replace(given_plan(file), grasp_counts=counts)


def test_counts_need_a_file_and_trials_have_a_limit(file):
    with pytest.raises(SettingsError, match="grasp_counts: got"):
        dataclasses.replace(plan(), grasp_counts=COUNTS)
    many = {"box": 1_000_000, "oval_bottle": 1}
    with pytest.raises(
        SettingsError, match="got 10 for each of 1000001 grasps; allowed are 100000"
    ):
        dataclasses.replace(given_plan(file), grasp_counts=many, trials=10)
    with pytest.raises(RunError, match="trial 5 is not in the run; it has trials 0 to 4"):
        given_plan(file).job(5)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"grasps": "file"}, "'file' needs one"),
        ({"grasp_set": GraspSet("/a.csv", "0" * 64)}, "nothing else takes one"),
        ({"grasps": "file", "grasp_set": "a.csv"}, "expected a GraspSet"),
        ({"grasps": "all"}, "grasps: got 'all'; choose any or precision, or give the path"),
    ],
)
def test_settings_that_do_not_fit(values, words):
    with pytest.raises(SettingsError, match=words):
        TrialSettings("box", **values)


@pytest.mark.parametrize("data", [None, {"path": 1}, {"path": "a", "sha256": "x"}, {"path": "a"}])
def test_a_damaged_reference(data):
    with pytest.raises(SettingsError, match="grasp_set"):
        TrialSettings.from_dict({"object": "box", "grasps": "file", "grasp_set": data})
