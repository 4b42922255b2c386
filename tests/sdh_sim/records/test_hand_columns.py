"""Tables of other hands: the same columns in other shapes, and those of their arrays."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.records import (
    COLUMNS,
    HandShape,
    RecordError,
    all_columns,
    hand_columns,
    normalise,
    read_rows,
    read_table,
    stack,
    write_rows,
)
from sdh_sim.runs import columns_of_run
from sdh_sim.settings import TrialSettings
from tests.support.trial_stand_ins import make_row

JAW = HandShape(1, {"pad": (2, 14, 6)})
OF_MOTORS = {
    *("torque_limit_nm", "joint_angles_rad", "motor_torque_nm", "peak_torque_nm"),
    *("plan_open_rad", "plan_closed_rad"),
}


def jaw_row(trial: int) -> dict:
    """A row of the jaw: one motor, two pads."""
    row = {**make_row("box", 1), "trial": trial, "hand": "parallel_jaw"}
    row |= {name: np.array([1.5 * trial]) for name in OF_MOTORS}
    row["tactile_pad"] = np.full((2, 14, 6), float(trial))
    return row | {"tactile_proximal": None, "tactile_distal": None}


def test_columns_of_motors_change_their_length_and_nothing_else():
    every = {c.name: c for c in all_columns(hand_columns(JAW))}
    assert [name for name in every if name in {c.name for c in COLUMNS}] == [
        c.name for c in COLUMNS
    ]
    for own in COLUMNS:
        assert every[own.name].shape == ((1,) if own.name in OF_MOTORS else own.shape)
    assert set(every) - {c.name for c in COLUMNS} == {"hand", "tactile_pad"}
    assert every["tactile_pad"].shape == (2, 14, 6)


def test_a_table_of_another_hand_comes_back(tmp_path):
    file = tmp_path / "trials.parquet"
    write_rows([jaw_row(0), jaw_row(1)], file, hand_columns(JAW))
    first, second = read_rows(file)
    assert (first["hand"], second["joint_angles_rad"].tolist()) == ("parallel_jaw", [1.5])
    assert second["tactile_pad"].shape == (2, 14, 6)
    assert (second["tactile_pad"] == 1.0).all()
    assert first["tactile_distal"] is None
    assert stack(read_table(file), "peak_torque_nm").shape == (2, 1)
    assert stack(read_table(file, ["tactile_pad"]), "tactile_pad").shape == (2, 2, 14, 6)


def test_positions_of_passive_joints_come_back(tmp_path):
    file = tmp_path / "trials.parquet"
    sprung = JAW._replace(joints=3)
    write_rows([jaw_row(0) | {"joint_positions": [0.1, 0.2, 0.3]}], file, hand_columns(sprung))
    assert read_rows(file)[0]["joint_positions"].tolist() == [0.1, 0.2, 0.3]
    with pytest.raises(RecordError, match=r"has column 'joint_positions'"):
        write_rows([jaw_row(0) | {"joint_positions": [0.1]}], file, hand_columns(JAW))


def test_a_row_of_another_hand_does_not_fit_into_the_table_of_this_one(tmp_path):
    with pytest.raises(RecordError, match=r"has column 'hand'|has shape \(1,\)"):
        write_rows([jaw_row(0)], tmp_path / "t.parquet")
    wrong = {**jaw_row(0), "joint_angles_rad": np.zeros(2)}
    with pytest.raises(RecordError, match=r"has shape \(2,\); expected \(1,\)"):
        write_rows([wrong], tmp_path / "t.parquet", hand_columns(JAW))
    with pytest.raises(RecordError, match=r"'tactile_pad' has shape \(14, 6\)"):
        normalise({**jaw_row(0), "tactile_pad": np.zeros((14, 6))})


def test_a_run_has_the_columns_of_its_hand():
    assert columns_of_run(TrialSettings("box")) == ()
    jaw = columns_of_run(TrialSettings("box", hand="parallel_jaw"))
    assert {c.name: c.shape for c in jaw} == {c.name: c.shape for c in hand_columns(JAW)}
