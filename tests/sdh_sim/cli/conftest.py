"""Lifts that take no time, and a finished run of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from sdh_sim.campaign import run_campaign
from sdh_sim.runs import RunPlan
from sdh_sim.settings import TrialSettings
from tests.support import trial_stand_ins as stand_ins
from tests.support.command_line import use_trial


@pytest.fixture
def quick(monkeypatch):
    """Lifts take no time."""
    use_trial(monkeypatch, stand_ins.quick)


@pytest.fixture
def run(tmp_path) -> Path:
    """A finished run of three trials on the box."""
    out = tmp_path / "run"
    plan = RunPlan(("box",), TrialSettings("box"), 3, 0)
    run_campaign(plan, out, 1, trial=stand_ins.quick)
    return out
