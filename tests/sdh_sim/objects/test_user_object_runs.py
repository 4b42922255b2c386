"""A user's object in scenes, grasps, plans and whole runs."""

from __future__ import annotations

import json
import shutil
import sys

import numpy as np
import pytest

from sdh_sim import records
from sdh_sim.campaign import run_campaign
from sdh_sim.cell import OBJECT_GEOM, build_scene
from sdh_sim.cli.app import main
from sdh_sim.errors import SettingsError
from sdh_sim.grasping import sample_grasp
from sdh_sim.metrics import evaluate, grasp_of
from sdh_sim.objects import user_object
from sdh_sim.robot import HandKinematics
from sdh_sim.runs import RunFolder, RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import ObjectFolder
from tests.support.object_files import FACTS, MUG, block, info_of, object_folder
from tests.support.sdh2 import SDH2


def test_contacts_of_a_user_s_object_are_those_of_a_built_in_one(tmp_path):
    found = user_object(MUG)
    scene = build_scene(TrialSettings(found.name, folder=found.reference))
    of_box = build_scene(TrialSettings("box"))

    def touching(some):
        geoms = np.flatnonzero((some.geom_group == OBJECT_GEOM) & (some.model.geom_contype > 0))
        names = ("contype", "conaffinity", "condim", "group", "margin", "gap", "priority")
        same = {tuple(int(getattr(some.model, f"geom_{n}")[g]) for n in names) for g in geoms}
        return same, {tuple(some.model.geom_solref[g]) for g in geoms}

    assert touching(scene) == touching(of_box)
    friction = scene.model.geom_friction[scene.taxel >= 0, 0]
    assert np.unique(friction) == pytest.approx([0.55])


def test_low_objects_are_taken_from_above_and_the_spread_is_obeyed(tmp_path):
    low = info_of(object_folder(tmp_path, block(size=(0.06, 0.06, 0.05))))
    rng = np.random.default_rng(0)
    plans = [sample_grasp(SDH2, low, rng) for _ in range(50)]
    assert {p.approach for p in plans} == {"top"}
    assert all(0.0 < p.height < 0.05 for p in plans)
    sides = info_of(
        object_folder(tmp_path / "b", facts=FACTS + "[grasp]\nside = 1.0\noffset = 0.0\n")
    )
    plans = [sample_grasp(SDH2, sides, rng) for _ in range(50)]
    assert {p.approach for p in plans} == {"side"}
    assert all((p.offset == 0.0).all() for p in plans)


def test_a_plan_keeps_the_folders(tmp_path):
    reference = user_object(MUG).reference
    plan = RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, {"mug": reference})
    assert RunPlan.from_dict(json.loads(json.dumps(plan.to_dict()))) == plan
    assert plan.job(1).settings.folder is None
    assert plan.job(2).settings == TrialSettings("mug", folder=reference)
    elsewhere = ObjectFolder("/else/where", reference.sha256)
    moved = RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, {"mug": elsewhere})
    assert moved.changes_from(plan) == []
    edited = ObjectFolder(reference.path, "0" * 64)
    changed = RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, {"mug": edited})
    assert "folders" in " ".join(changed.changes_from(plan))
    for wrong in ({"duck": reference}, {"mug": "path"}):
        with pytest.raises(SettingsError, match="no object of the run"):
            RunPlan(("box", "mug"), TrialSettings("box"), 2, 0, wrong)  # type: ignore[arg-type]
    for wrong in (
        None,
        [],
        {"mug": None},
        {"mug": {"path": 1}},
        {"mug": {"path": "", "sha256": 1}},
    ):
        with pytest.raises(SettingsError):
            RunPlan.from_dict({**plan.to_dict(), "folders": wrong})


def test_run_json_says_what_was_done_with_the_files(tmp_path):
    """Notes go along, change nothing, and may be missing, as in runs of earlier versions."""
    mesh = block()
    mesh.update_faces(np.arange(11))
    reference = user_object(object_folder(tmp_path, mesh, FACTS + "hull = true")).reference
    assert reference.notes == ("not closed: mass distribution from the hull",)
    plan = RunPlan(("block",), TrialSettings("block"), 2, 0, {"block": reference})
    kept = json.loads(json.dumps(plan.to_dict()))
    assert kept["folders"]["block"]["notes"] == list(reference.notes)
    assert RunPlan.from_dict(kept).folders["block"].notes == reference.notes
    del kept["folders"]["block"]["notes"]
    assert RunPlan.from_dict(kept) == plan
    assert plan.changes_from(RunPlan.from_dict(kept)) == []
    for wrong in ("text", [1], [""], ["\n"], ["x"] * 501, [["x"]], None):
        kept["folders"]["block"]["notes"] = wrong
        with pytest.raises(SettingsError):
            RunPlan.from_dict(kept)


def test_a_run_with_a_folder_repeats_resumes_and_minds_changes(tmp_path, monkeypatch, capsys):
    mug = tmp_path / "cup"
    shutil.copytree(MUG, mug)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    lift = ["lift", "--workers", "2", "--timestep", "0.004"]
    assert main([*lift, "--object", str(mug), "--trials", "2", "--out", str(whole)]) == 0
    assert main([*lift, "--object", str(mug), "--trials", "1", "--out", str(parts)]) == 0
    resume = ["lift", "--resume", "--trials", "2", "--out", str(parts)]

    facts = (mug / "object.toml").read_text()
    (mug / "object.toml").write_text(facts.replace("0.35 ", "0.36 "))
    for again in (resume, [*resume, "--object", str(mug)], ["show", str(parts), "--trial", "0"]):
        capsys.readouterr()
        assert main(again) == 2
        assert "has changed since the run began; bring its files back" in capsys.readouterr().err
    (mug / "object.toml").write_text(facts)

    moved = mug.rename(tmp_path / "moved")
    assert main(resume) == 2
    assert "No such file" in capsys.readouterr().err
    assert main([*resume, "--object", str(moved)]) == 0
    table = (parts / "trials.parquet").read_bytes()
    assert table == (whole / "trials.parquet").read_bytes()
    assert RunFolder(parts).read_plan().folders["mug"].path == str(moved)
    rows = records.read_rows(parts / "trials.parquet")
    assert {row["object"] for row in rows} == {"mug"}
    assert rows[0]["mass_kg"] == 0.35
    folders = RunFolder(parts).read_plan().folders
    for row in rows:
        grasp = grasp_of(row, "all", HandKinematics(), folders)
        assert grasp is not None
        assert evaluate(grasp)["q_linf"] == pytest.approx(row["q_linf"], rel=1e-4)
    assert main(["compare", str(parts), "--no-report"]) == 0
    assert " mug " in capsys.readouterr().out


def test_workers_that_find_another_object_stop_the_run(tmp_path):
    found = user_object(object_folder(tmp_path))
    other = ObjectFolder(found.reference.path, "0" * 64)
    plan = RunPlan(("block",), TrialSettings("block"), 3, 0, {"block": other})
    with pytest.raises(Exception, match="block has changed since the run began"):
        run_campaign(plan, tmp_path / "run", 1)
    assert records.read_rows(tmp_path / "run" / "trials.parquet") == []


def test_objects_describes_folders(tmp_path, capsys):
    assert main(["objects", str(MUG)]) == 0
    out = capsys.readouterr().out
    assert "108.9 × 80.0 × 95.0" in out
    assert "mug.obj, 8 collision shapes, hulls 1.000 × its volume" in out
    path = object_folder(tmp_path / "turned", facts=FACTS + 'pose = "stable:2"')
    assert main(["objects", str(path)]) == 0
    assert "\n  stable pose 2, tilted by 90° from z up\n" in capsys.readouterr().out
    assert main(["objects", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("sdh-sim: --object: ")
    assert "cannot read 'object.toml': No such file" in err


def test_the_example_is_what_its_script_writes():
    sys.path.insert(0, str(MUG.parent))
    try:
        import make_mug  # type: ignore[import-not-found]
    finally:
        sys.path.pop(0)
    assert make_mug.obj() == (MUG / "mug.obj").read_text()
