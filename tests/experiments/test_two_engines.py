"""Comparing two engines: table, agreement and messages, which need no second engine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from experiments.two_engines import __main__ as command
from experiments.two_engines import closed_forms, drake, label_margins, snapshots
from experiments.two_engines.agreement import (
    Labels,
    agree,
    kind_of,
    load_ratios,
    scored,
    weightless,
)
from experiments.two_engines.alignment import ALIGNED, ALIGNMENTS, FULL, NAMES, Alignment
from experiments.two_engines.contact_laws import law_at_rest, law_of, touchable
from experiments.two_engines.start import guessed_references, start_of
from experiments.two_engines.straight import straight_lift
from experiments.two_engines.table import LABELS
from sdh_sim.cell import scene_of
from sdh_sim.cell.scene_builder import taxel_stiffness
from sdh_sim.errors import RecordError, RunError
from sdh_sim.runs import Job
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial

SETTINGS = TrialSettings("box", arm="rigid")
SEED = 7  # held


def row_of(trial: int, success: bool, moved: float, load: float = math.nan, turned: float = 1.0):
    return {
        "trial": trial, "object": "box", "alignment": FULL, "success": success,
        "failure": "none" if success else "slipped", "displacement_mm": moved,
        "rotation_deg": turned, "q_sim": load, "q_sim_capped": False, "seconds": 1.0,
    }  # fmt: skip


def test_rows_come_back_and_what_was_not_written_to_its_end_is_left_out(tmp_path: Path):
    LABELS.append(tmp_path, [row_of(0, True, 1.25), row_of(1, False, 12.5)])
    whole = (tmp_path / LABELS.name).read_text(encoding="utf-8")
    # Torn in the last number, the line would still have all of its columns.
    (tmp_path / LABELS.name).write_text(f"{whole}2{whole.splitlines()[1][1:]}", encoding="utf-8")
    assert [row["trial"] for row in LABELS.read(tmp_path)] == [0, 1]
    LABELS.append(tmp_path, [row_of(1, True, 9.0, load=1.1), row_of(3, True, 2.0)])
    found = {row["trial"]: row for row in LABELS.read(tmp_path)}
    assert sorted(found) == [0, 1, 3]
    assert found[1]["success"] is True
    assert found[1]["q_sim"] == 1.1
    assert math.isnan(found[0]["q_sim"])
    assert LABELS.read(tmp_path / "elsewhere") == []


def test_a_table_with_other_columns_is_refused(tmp_path: Path):
    (tmp_path / LABELS.name).write_text("trial,object\n1,box\n", encoding="utf-8")
    with pytest.raises(RecordError, match="move it away"):
        LABELS.read(tmp_path)


@pytest.mark.parametrize("line", ["1,box,dissipation,perhaps,none,1,1,1,True,1", "1,box", "x" * 9])
def test_a_line_that_no_row_is_is_refused_by_its_number(tmp_path: Path, line: str):
    LABELS.append(tmp_path, [row_of(0, True, 1.25)])
    with (tmp_path / LABELS.name).open("a", encoding="utf-8") as file:
        file.write(f"{line}\n")
    with pytest.raises(RecordError, match="line 3"):
        LABELS.read(tmp_path)


def test_agreement_counts_labels_and_compares_the_motion_of_what_both_hold():
    first = [row_of(0, True, 1.0), row_of(1, True, 2.0), row_of(2, False, 30.0), row_of(3, True, 1)]
    second = [row_of(0, True, 1.5), row_of(1, False, 11.0), row_of(2, False, 20.0), None]
    found = agree(first, second)
    assert (found.labels.k, found.labels.n, found.held) == (2, 3, 1)
    assert (found.lost, found.gained) == (1, 0)
    assert (agree(second, first).lost, agree(second, first).gained) == (0, 1)
    assert found.off[0] == found.bias == 0.5


def test_a_disagreement_is_put_down_to_what_the_numbers_show():
    falls, holds = row_of(0, False, 40.0, 0.5), row_of(0, True, 3.0, 1.5)
    assert kind_of(falls, None, holds) == "other"
    assert kind_of(falls, holds, holds) == "arm"
    assert kind_of(falls, falls, row_of(0, True, 9.5, 1.5)) == "limit"
    assert kind_of(row_of(0, False, 10.4, 0.5), falls, holds) == "limit"
    assert kind_of(row_of(0, False, 40.0, 0.99), falls, holds) == "load"


def test_loads_and_scores_are_compared_where_both_engines_have_them():
    rows = [
        {**row_of(k, success, 1.0, 2.0), "q_linf": q}
        for k, (success, q) in enumerate([(True, 2.0), (False, 0.5), (True, 1.5), (False, 1.2)])
    ]
    others: list = [
        row_of(0, True, 1.0, 2.2),
        row_of(1, True, 1.0),
        row_of(2, True, 1.0, 1.8),
        None,
    ]
    labels = Labels(rows, {FULL: others})
    assert load_ratios(labels) == pytest.approx([1.1, 0.9])
    assert weightless(labels) == (0, 0, 0)
    loads = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, 0.5), (1.0, math.nan)]
    without = Labels(
        [row_of(k, True, 1.0, load) for k, (load, _) in enumerate(loads)],
        {FULL: [row_of(k, True, 1.0, load) for k, (_, load) in enumerate(loads)]},
    )
    assert weightless(without) == (1, 2, 1)
    kinds = scored(labels)["q* L∞"]
    assert (kinds["MuJoCo"].tp, kinds["MuJoCo"].tn) == (2, 1)
    assert (kinds["Drake"].tp, kinds["Drake"].fn) == (2, 1)
    assert kinds["both"].n == 2


def test_differences_are_aligned_one_after_the_other():
    assert list(ALIGNMENTS) == ["none", *NAMES]
    assert ALIGNMENTS["none"] == Alignment()
    counts = [sum(getattr(a, name) for name in NAMES) for a in ALIGNMENTS.values()]
    assert counts == list(range(len(NAMES) + 1))
    assert Alignment(*[True] * len(NAMES)) == ALIGNED


def test_without_the_second_engine_it_says_what_to_install(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(drake, "find_spec", lambda name: None)
    for module in (command, snapshots, label_margins):
        with pytest.raises(SystemExit) as end:
            module.main([str(tmp_path)])
        assert end.value.code == 2
        assert "pip install" in capsys.readouterr().err
    with pytest.raises(SystemExit) as end:
        closed_forms.main([])
    assert end.value.code == 2


def test_contacts_of_taxels_are_as_stiff_as_their_rubber():
    scene = scene_of(SETTINGS)
    taxel = int(np.flatnonzero(scene.taxel >= 0)[0])
    law = law_of(scene, taxel, ALIGNED)
    pitch = scene.hand.pads[0].array.pitch
    assert law.stiffness == pytest.approx(taxel_stiffness(scene.settings, pitch))
    # Critically damped: the time constant is that of a contact of this stiffness.
    k = -scene.model.geom_solref[taxel, 0]
    assert law.relaxation == pytest.approx(2.0 / math.sqrt(k))
    assert law.friction == scene.obj.friction


def test_table_and_hard_parts_have_mujocos_law_where_it_is_aligned_and_the_usual_one_else():
    scene, plain = scene_of(SETTINGS), Alignment()
    own = int(np.flatnonzero(touchable(scene.model, scene.object_body))[0])
    table = law_at_rest(scene.model, scene.table, own)
    assert law_of(scene, scene.table, ALIGNED) == table
    assert table.friction == scene.model.geom_friction[scene.table, 0] < scene.obj.friction
    assert law_of(scene, scene.table, plain).friction == scene.obj.friction
    # Time constant 30 ms, d = 0.9 to 0.95, and the object alone gives way.
    stiffness = 0.9**2 / (0.95 * 0.03) ** 2 / (1.0 - 0.9)
    assert table.stiffness == pytest.approx(
        stiffness / scene.model.body_invweight0[scene.object_body, 0]
    )
    hard = scene.model.geom("hand/palm_boss").id
    assert law_of(scene, hard, ALIGNED).stiffness > law_of(scene, hard, plain).stiffness == 3e4


@pytest.fixture(scope="module")
def acquired() -> Trial:
    trial = Trial(SETTINGS, SEED)
    trial.acquire()
    return trial


def test_a_trial_is_repeated_to_the_snapshot_of_its_row_and_no_other(acquired):
    pose = acquired.simulation.object_in_hand()
    job = Job(trial=0, index=0, seed=SEED, settings=SETTINGS)
    start = start_of(job, {"object_pose_hand": pose})
    assert start.obj == pytest.approx(acquired.simulation.pose(acquired.scene.object_body))
    assert start.references == pytest.approx(acquired.simulation.data.ctrl[acquired.scene.motors])
    limits = acquired.simulation.limits
    saturated = np.abs(start.torques) > 0.999 * limits
    guessed = guessed_references(start)
    gains = start.scene.model.actuator_gainprm[start.scene.motors, 0]
    asked = gains * (guessed - start.angles)
    assert saturated.any()
    assert np.abs(asked[saturated]) == pytest.approx(1.1 * limits[saturated])
    assert asked[~saturated] == pytest.approx(start.torques[~saturated])
    with pytest.raises(RunError, match="off the one of the table"):
        start_of(job, {"object_pose_hand": np.array([pose[0] + 0.001, *pose[1:]])})


def test_a_straight_lift_does_not_press_the_object_aside(acquired):
    pose = acquired.simulation.object_in_hand()
    job = Job(trial=0, index=0, seed=SEED, settings=SETTINGS)
    straight = straight_lift(start_of(job, {"object_pose_hand": pose}))
    lifted = acquired.lift()
    assert not straight.fell
    assert not lifted.fell
    assert 1.0 < straight.displacement_mm < lifted.displacement_mm - 0.5


def turned_by(*changes: tuple[str, str], mujoco: bool = True, other: bool = True):
    """Rows of a grasp of which these changes, by engine, turn the label."""
    usual = {"MuJoCo": mujoco, "Drake": other}
    return [
        {
            "trial": 5, "object": "box", "engine": engine, "change": change,
            "success": usual[engine] != ((engine, change) in changes),
            "displacement_mm": 1.0, "rotation_deg": 1.0,
        }
        for engine in label_margins.ENGINES
        for change in label_margins.CHANGES
    ]  # fmt: skip


def test_changes_that_turn_a_label_are_found_engine_by_engine():
    rows = turned_by(("MuJoCo", "friction +3 %"), ("Drake", "damping / 2"), mujoco=False)
    (grasp,) = label_margins.grasps_of(rows)
    assert not grasp.alike
    everything = label_margins.GROUPS["any of these"]
    assert grasp.turned("MuJoCo", everything) == ["friction +3 %"]
    assert grasp.turned("Drake", everything) == ["damping / 2"]
    assert grasp.turned("MuJoCo", label_margins.GROUPS["damping by 2"]) == []
    assert label_margins.grasps_of(rows[:-1]) == []  # incomplete


def test_shares_of_turned_labels_are_counted_among_those_that_differ_and_agree(capsys):
    grasps = [
        *label_margins.grasps_of(turned_by(("MuJoCo", "friction -3 %"), mujoco=False)),
        *label_margins.grasps_of(turned_by(("Drake", "friction -6 %"))),
        *label_margins.grasps_of(turned_by()),
    ]
    label_margins.report(grasps, Console(width=140))
    lines = capsys.readouterr().out.splitlines()
    by_three = next(line for line in lines if "friction by 3 %" in line)
    assert by_three.count("1 of 1: 100") == 1  # the one that differs
    assert by_three.count("0 of 2: 0") == 3
    by_six = next(line for line in lines if "friction by 6 %" in line)
    assert by_six.count("1 of 2: 50") == 2  # Drake, and either


def test_a_changed_scene_leaves_the_usual_one_as_it_is():
    scene = scene_of(SETTINGS)
    taxel = int(np.flatnonzero(scene.taxel >= 0)[0])
    before = law_of(scene, taxel, ALIGNED)
    other = label_margins.changed(scene, label_margins.Change(friction=0.94, damping=2.0))
    after = law_of(other, taxel, ALIGNED)
    assert after.friction == pytest.approx(0.94 * before.friction)
    assert after.relaxation == pytest.approx(2.0 * before.relaxation)
    assert after.stiffness == before.stiffness
    assert law_of(scene, taxel, ALIGNED) == before


def test_snapshots_are_summed_up_with_their_metrics_and_labels():
    row = dict.fromkeys(snapshots.SNAPSHOTS.columns, 1.0) | {
        "trial": 0, "object": "box", "force_mujoco_n": 40.0, "force_drake_n": 36.0,
        "q_linf_mujoco": 1.2, "q_linf_drake": 0.9, "failure_mujoco": "none",
        "failure_drake": "none",
    }  # fmt: skip
    lost = dict.fromkeys(snapshots.SNAPSHOTS.columns, math.nan) | {
        "trial": 1, "object": "box", "failure_mujoco": "none", "failure_drake": "diverged",
    }  # fmt: skip
    lines = snapshots.summary([row, lost])
    assert lines[0].startswith("2 grasps")
    assert "sum of normal forces, Drake over MuJoCo: 0.9 (0.9 to 0.9)" in lines
    assert any(line.startswith("q_linf, Drake over MuJoCo (1 positive") for line in lines)
    assert any(line.startswith("q_linf on the same side of 1: 0.0 (") for line in lines)
    assert any(
        line.startswith("closed and lifted in Drake, the same label: 50.0 (") for line in lines
    )
    assert lines[-1] == "diverged in Drake: 1"


def test_readings_are_shared_at_the_same_taxels_and_on_the_same_pads():
    here, there = np.zeros((2, 3, 3)), np.zeros((2, 3, 3))
    here[0, 0, 0], there[0, 2, 2] = 4.0, 8.0  # another taxel of the same pad
    assert snapshots.shared({"a": here}, {"a": 2.0 * here}) == (1.0, 1.0)
    assert snapshots.shared({"a": here}, {"a": there}) == (0.0, 1.0)
    there[1, 0, 0] = 8.0
    assert snapshots.shared({"a": here}, {"a": there}) == (0.0, 0.5)
    assert all(math.isnan(x) for x in snapshots.shared({"a": here}, {"a": 0.0 * here}))
