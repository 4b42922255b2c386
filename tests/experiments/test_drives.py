"""The study of drives: its table goes on where it was, and its findings are counted right."""

from __future__ import annotations

import sys
from dataclasses import replace

import pytest

from experiments.drives import __main__ as command
from experiments.drives import grasps
from experiments.drives.findings import bound_fits, bound_table, label_changes, label_table
from experiments.drives.grasps import DRIVES, Job, Seen, observe
from experiments.drives.picture import draw
from experiments.drives.table import TABLE, GraspTable
from sdh_sim.settings import TrialSettings

CONDITIONS = {"seed": 1}


def grasp(seed: int, held: tuple[bool, bool, bool], loads=(1.0, 1.2, 3.0)) -> list[Seen]:
    """A grasp with every drive, q* of 1 by every bound."""
    values = {name: 1.0 for name in ("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand")}
    known = {name.replace("q_", "known_", 1): 1.0 for name in values}
    return [
        Seen("box", seed, drive, "none" if ok else "slipped", 1.0, 1.0, 10.0, 0.0, load, 0,
             **values, **known)
        for drive, ok, load in zip(DRIVES, held, loads, strict=True)
    ]  # fmt: skip


def test_a_table_goes_on_where_it_was_cut(tmp_path):
    table = GraspTable(tmp_path, CONDITIONS)
    table.add(grasp(1, (True, True, True)))
    table.add(grasp(2, (False, True, True)))
    path = tmp_path / TABLE
    path.write_text(path.read_text()[:-40])  # as a kill may leave it
    again = GraspTable(tmp_path, CONDITIONS)
    assert again.done == {("box", 1)}
    again.add(grasp(2, (False, True, True)))
    assert GraspTable(tmp_path, CONDITIONS).seen == again.seen
    assert again.seen[0] == grasp(1, (True, True, True))[0]


def test_a_table_of_another_run_is_refused(tmp_path, capsys):
    GraspTable(tmp_path, CONDITIONS)
    with pytest.raises(SystemExit):
        GraspTable(tmp_path, {"seed": 2})
    assert "is of a run with {'seed': 1}" in capsys.readouterr().err


def test_labels_and_loads_are_counted(tmp_path):
    seen = grasp(1, (True, True, True)) + grasp(2, (False, True, True))
    seen += grasp(3, (True, True, False)) + grasp(4, (False, False, False))
    usual, hold, lock = label_changes(seen)
    assert (usual.gained, usual.lost, usual.load) == (0, 0, 1.0)
    assert (hold.gained, hold.lost, hold.changed.k) == (1, 0, 1)
    assert (lock.gained, lock.lost, lock.changed.n) == (1, 1, 4)
    assert lock.load == pytest.approx(3.0)
    fits = {(fit.drive, fit.bound): fit for fit in bound_fits(seen, True)}
    ratio = fits["lock", "q_linf"].ratio
    assert ratio is not None
    assert ratio.median == pytest.approx(1.0 / 3.0)
    assert fits["yield", "q_held"].below.k == 4
    assert label_table(seen).row_count == 3
    assert bound_table(seen, False).row_count == 15
    assert draw(seen, tmp_path / "drives").exists()


def test_a_grasp_that_diverged_is_left_out_with_every_drive():
    seen = grasp(1, (True, True, True)) + grasp(2, (True, True, True))
    seen[1] = replace(seen[1], failure="unstable_simulation")
    assert [x.changed.n for x in label_changes(seen)] == [1, 1, 1]


def test_one_grasp_is_tried_with_every_drive(monkeypatch):
    monkeypatch.setattr(grasps, "LOAD_SPEED", 10.0)
    found = observe(Job(TrialSettings("spray_bottle"), 1))
    assert [s.drive for s in found] == list(DRIVES)
    loads = [s.q_sim for s in found]
    assert loads[0] < loads[1] < loads[2]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--hand", "nowhere"], "hand: got 'nowhere'; choose one of"),
        (["--gear-friction", "9"], "gear_friction: got 9.0; allowed is 0 to 2"),
        (["--trials", "0"], "--trials must be at least 1, got 0"),
    ],
)
def test_options_that_cannot_be_used_are_one_line(tmp_path, capsys, monkeypatch, options, words):
    monkeypatch.setattr(sys, "argv", ["drives/__main__.py"])
    with pytest.raises(SystemExit) as ended:
        command.main([*options, "--workers", "1", "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
