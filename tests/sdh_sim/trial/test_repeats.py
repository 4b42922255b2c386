"""The share of perturbed copies that hold: which copies count."""

from __future__ import annotations

import contextlib
from types import SimpleNamespace

import numpy as np

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import repeats


def test_a_copy_that_diverges_or_has_no_motion_is_not_counted(monkeypatch):
    ends = iter(["none", "unstable_simulation", "slipped", "none", "no_contact"])
    motions = iter(["there", "there", None, "there", "there", "there"])

    class Copy:
        def __init__(self, *args, **kwargs):
            self.simulation = SimpleNamespace(friction_scaled=contextlib.nullcontext)

        def grasp_and_lift(self):
            return next(ends), None

    monkeypatch.setattr(repeats, "Trial", Copy)
    monkeypatch.setattr(repeats, "perturbed", lambda *given: next(motions))
    trial = SimpleNamespace(
        settings=TrialSettings("box", repeats=6), seed=0, scene=None, motion=None
    )
    found = repeats.repeat_trial(trial, np.random.default_rng(0))  # type: ignore[arg-type]
    # Of six one finds no motion and one diverges; of the four others two hold.
    assert found == Proportion(2, 4)
