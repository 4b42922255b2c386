"""What a run is asked to do: the numbers and seeds of its trials, and what is refused."""

from __future__ import annotations

import dataclasses
import zlib

import numpy as np
import pytest

from sdh_sim.errors import SettingsError
from sdh_sim.runs import trial_seed
from tests.support.trial_stand_ins import plan


def test_seed_rule_and_numbering():
    entropy = [7, zlib.crc32(b"oval_bottle"), 2]
    state = np.random.SeedSequence(entropy).generate_state(1, np.uint64)[0]
    wanted = int(state) // 2
    assert trial_seed(7, "oval_bottle", 2) == wanted
    job = plan(trials=5, seed=7).job(7)
    assert (job.trial, job.index, job.seed) == (7, 2, wanted)
    assert job.settings.object == "oval_bottle"
    assert trial_seed(7, "box", 2) != wanted != trial_seed(8, "oval_bottle", 2)
    assert all(0 <= job.seed < 2**63 for job in plan(200).jobs())


@pytest.mark.parametrize("bad", [0, -1, 1.5, True, "2", 10**9])
def test_bad_numbers_of_trials(bad):
    with pytest.raises(SettingsError, match="trials: got"):
        dataclasses.replace(plan(), trials=bad)


@pytest.mark.parametrize("bad", [-1, 0.5, 2**63])
def test_bad_seeds(bad):
    with pytest.raises(SettingsError, match="seed: got"):
        dataclasses.replace(plan(), seed=bad)


def test_objects_twice_or_none():
    for objects in ((), ("box", "box")):
        with pytest.raises(SettingsError, match="give each object once"):
            dataclasses.replace(plan(), objects=objects)
