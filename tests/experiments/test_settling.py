"""The study of settling: a short run, and what cannot be used."""

from __future__ import annotations

import pytest

from experiments import settling
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial
from tests.support.run_folders import write_run_of


def test_the_command_prints_its_table_and_sentences(tmp_path, capsys):
    settings = TrialSettings("box", load_test="gravity")
    row = run_trial(settings, 3).row
    assert row["success"], "take another seed"
    fell = {**row, "success": False, "failure": "dropped"}  # an area under the curve needs both
    out = write_run_of([row, fell], settings, tmp_path / "run")
    settling.main([str(out), "--variants", "--sensitivity"])
    printed = capsys.readouterr().out
    for words in (
        "q* whole hand, settled",
        "settling, kept contacts",
        "mass off by 10 %",
        "CPU time of a grasp",
    ):
        assert words in printed
    with pytest.raises(SystemExit):
        settling.main([str(tmp_path / "nothing")])
