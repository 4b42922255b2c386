"""The study of settling: a short run, and what cannot be used."""

from __future__ import annotations

import pytest

from experiments import settling
from sdh_sim.cli import main


def test_the_command_prints_its_table_and_sentences(tmp_path, capsys):
    out = tmp_path / "run"
    lift = ["lift", "--object", "box", "--trials", "3", "--seed", "5", "--workers", "1"]
    assert main([*lift, "--load-test", "gravity", "--out", str(out)]) == 0
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
