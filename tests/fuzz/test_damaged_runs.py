"""Damaged trials.parquet, shards and run.json give clear errors; SDH_SIM_FUZZ_SECONDS for more."""

from __future__ import annotations

import pytest

from sdh_sim.errors import RunError, SettingsError
from sdh_sim.runs import RunFolder
from tests.fuzz.frame import run_driver
from tests.support.trial_stand_ins import plan


def test_damaged_files_give_clear_errors(tmp_path):
    printed = run_driver("damaged_runs", tmp_path, 4.0)
    for kind in ("table bytes", "table content", "run.json bytes", "run.json content"):
        assert f"{kind} refused: " in printed


def test_a_run_json_cannot_ask_for_any_amount_of_memory(tmp_path):
    many = [f"object {i}" for i in range(1000)]
    with pytest.raises(SettingsError, match="allowed are 10000000 in all"):
        plan(1_000_000, tuple(many))
    with pytest.raises(SettingsError, match="got 1001; allowed are 1000"):
        plan(1, (*many, "box"))
    (tmp_path / "run.json").write_text("[" * 5_000_000)
    with pytest.raises(RunError, match="damaged"):
        RunFolder(tmp_path).read_plan()
