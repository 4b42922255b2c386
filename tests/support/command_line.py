"""The command line in this process: trials that take no time, and the one line of a refusal."""

from __future__ import annotations

import functools
from pathlib import Path

import sdh_sim.trial
from sdh_sim.campaign import run_campaign
from sdh_sim.cli import lift as cli_lift
from sdh_sim.cli.app import main

LIFT = ["lift", "--object", "box", "--out"]


def use_trial(monkeypatch, trial) -> None:
    """Let the commands run this function for every trial."""
    run = functools.partial(run_campaign, trial=trial)
    monkeypatch.setattr(cli_lift, "run_campaign", run)
    monkeypatch.setattr(sdh_sim.trial, "run_trial", trial)


def fails(capsys, *arguments: str | Path, status: int = 2) -> str:
    """The one line of stderr of a command that must fail."""
    assert main([str(a) for a in arguments]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("sdh-sim: ")
    assert err.count("\n") == 1
    return err
