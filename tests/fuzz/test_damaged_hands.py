"""Damaged folders of hands give clear errors; SDH_SIM_FUZZ_SECONDS for more."""

from __future__ import annotations

from tests.fuzz.frame import run_driver


def test_damaged_folders_give_clear_errors(tmp_path):
    printed = run_driver("damaged_hands", tmp_path, 8.0)
    for kind in ("toml", "mjcf", "mjcf include", "mesh"):
        assert f"\n{kind} refused: " in printed
    for kind in ("toml", "mjcf", "mesh"):
        assert f"\n{kind} read: " in printed
