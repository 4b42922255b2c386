"""Grasps from a table are the grasps that the trial's own metrics saw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from sdh_sim import records
from sdh_sim.metrics import METRICS, evaluate, grasp_of, object_of, read_stored, snapshot_of
from sdh_sim.robot import HandKinematics
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial

CHEAP = {name: METRICS[name] for name in ("q_linf", "q_l1", "q_capability", "q_held")}


@pytest.fixture(scope="module")
def settings() -> TrialSettings:
    # Errors of the tracker and the model: what the metrics saw differs from what was.
    return TrialSettings(
        "box", torque_limit=(2.0, 1.2), position_error=0.002, angle_error=0.02,
        friction_error=0.1, mass_error=0.1,
    )  # fmt: skip


@pytest.fixture(scope="module")
def table(settings, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("stored") / "trials.parquet"
    held = ({**run_trial(settings, k).row, "trial": k} for k in range(3, 40))
    row = next(r for r in held if r["q_linf"] > 0.5)
    early = {"trial": 99, "object": "box", "seed": 1, "success": False}
    records.write_rows([row, {**early, "failure": "unstable_simulation"}], path)
    return path


def test_metrics_of_a_stored_grasp_are_those_of_the_trial(table):
    _, (row, early) = read_stored([table])
    grasp = grasp_of(row, "all", HandKinematics())
    assert grasp is not None
    found = evaluate(grasp, CHEAP)
    for name, value in found.items():
        assert value == pytest.approx(row[name], rel=1e-6), name
    assert grasp.torque_limits.max() == 2.0
    assert grasp.torque_limits.min() == 1.2
    assert snapshot_of(early) is None
    assert grasp_of(early, "all", HandKinematics()) is None


def test_what_the_metrics_saw_counts_not_what_was(table):
    _, (row, _) = read_stored([table])
    snapshot = snapshot_of(row)
    assert snapshot is not None
    assert (snapshot.object_pose_hand == row["perceived_pose_hand"]).all()
    assert (snapshot.object_pose_hand != row["object_pose_hand"]).any()
    obj = object_of(row)
    assert obj.friction == row["perceived_friction"] != row["friction"]
    assert obj.mass_kg == row["perceived_mass_kg"] != row["mass_kg"]


def test_the_threshold_is_that_of_the_trial(table):
    _, (row, _) = read_stored([table])
    assert row["taxel_threshold"] == 0.1

    def taxels(row, **options):
        grasp = grasp_of(row, "all", HandKinematics(), **options)
        assert grasp is not None
        return sum(len(p.contact.patch) for p in grasp.contacts if p.contact.patch is not None)

    lit = sum(int((np.asarray(row[name]) > 0).sum()) for name in row if name.startswith("tactile_"))
    assert taxels(row) == taxels(row, threshold=0.1) < lit
    assert taxels(row, threshold=0.0) == taxels({**row, "taxel_threshold": 0.0}) == lit
    # Before there was one every reading counted.
    assert taxels({name: value for name, value in row.items() if name != "taxel_threshold"}) == lit


def test_distal_pads_are_a_part_of_all(table):
    _, (row, _) = read_stored([table])
    every, distal = (grasp_of(row, pads, HandKinematics()) for pads in ("all", "distal"))
    assert every is not None
    assert distal is not None
    names = [contact.pad for contact in every.contacts]
    assert [c.pad for c in distal.contacts] == [n for n in names if n.endswith("distal")]


def test_an_older_table_lacks_what_came_later(table, tmp_path):
    full = pq.read_table(table)
    older = tmp_path / "older.parquet"
    pq.write_table(full.drop_columns(["perceived_pose_hand", "q_sim", "q_held"]), older)
    joined, found = read_stored([table, older])
    assert len(found) == joined.num_rows == 4
    assert "q_held" not in found[0]
    snapshot = snapshot_of(found[2])
    assert snapshot is not None
    assert (snapshot.object_pose_hand == found[2]["object_pose_hand"]).all()
    pq.write_table(full.drop_columns(["tactile_distal"]), older)
    with pytest.raises(records.RecordError, match="tactile_distal"):
        read_stored([older])


def test_arrays_come_back_as_they_went(table):
    _, (row, early) = read_stored([table])
    (stored, _) = records.read_rows(table)
    assert early["joint_angles_rad"] is None
    for name, value in stored.items():
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(row[name], value)
        else:
            assert row[name] == value, name
