"""The whole chain on the real simulation, through the command line."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from sdh_sim.records import differing_columns, normalise
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial
from tests.support.run_folders import drop_rows


def _cli(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sdh_sim", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "one"
    done = _cli(
        *("lift", "--object", "all", "--trials", "2", "--seed", "5", "--workers", "1"),
        *("--out", str(out)),
    )
    assert done.returncode == 0, done.stderr
    return out


def test_same_seed_same_bytes_with_one_or_two_workers(run: Path, tmp_path: Path) -> None:
    other = tmp_path / "two"
    shutil.copytree(run, other)
    drop_rows(other, [0, 3, 5, 6])  # two workers lift the other half again
    done = _cli("lift", "--resume", "--workers", "2", "--out", str(other))
    assert done.returncode == 0, done.stderr
    assert (run / "trials.parquet").read_bytes() == (other / "trials.parquet").read_bytes()


def test_table_holds_what_the_trials_measured(run: Path) -> None:
    rows = pq.read_table(run / "trials.parquet").to_pylist()
    assert len(rows) == 8
    for row in rows:
        assert row["failure"] != "unstable_simulation"
        assert row["success"] == (row["failure"] == "none")
        limit, peak = np.array(row["torque_limit_nm"]), np.array(row["peak_torque_nm"])
        assert (peak <= limit * (1 + 1e-12)).all()
        if row["success"]:
            assert row["displacement_mm"] <= 10.0
            assert row["rotation_deg"] <= 10.0
            tactile = (
                np.array(row["tactile_proximal"]).sum() + np.array(row["tactile_distal"]).sum()
            )
            assert tactile > 0.0
        if row["contacts"]:
            assert row["q_l1"] <= row["q_linf"] * (1 + 1e-9) + 1e-12


def test_compare_prints_both_metrics(run: Path) -> None:
    done = _cli("compare", str(run))
    assert done.returncode == 0, done.stderr
    for word in ("box", "spray_bottle", "L∞", "L1"):
        assert word in done.stdout


def test_a_log_changes_nothing() -> None:
    settings = TrialSettings("cylindrical_bottle")
    plain = normalise({**run_trial(settings, 3).row, "trial": 0})
    logged = normalise({**run_trial(settings, 3, log=True).row, "trial": 0})
    assert not differing_columns(plain, logged)
