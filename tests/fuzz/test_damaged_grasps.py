"""Damaged files of grasps give clear errors; SDH_SIM_FUZZ_SECONDS for more."""

from __future__ import annotations

from tests.fuzz.frame import run_driver


def test_damaged_files_of_grasps_give_clear_errors(tmp_path):
    printed = run_driver("damaged_grasps", tmp_path, 6.0)
    for kind in ("parquet", "csv", "json", "yaml"):
        for how in ("bytes", "content"):
            assert f"{kind} {how} refused: " in printed
    for kind in ("csv", "json", "yaml"):
        assert f"{kind} content read: " in printed
