"""Trials that take no time, for tests of what surrounds a trial: order, resume, stops, deaths.

The tests of the real thing end to end are elsewhere; these rows only have a trial's form.
"""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from sdh_sim.records import FAILURES
from sdh_sim.settings import TrialSettings


@dataclass(frozen=True)
class Result:
    """What ``run_trial`` returns, as far as a campaign looks."""

    row: dict[str, Any]
    log: Any = None
    sim_seconds: float = 4.0
    wall_seconds: float = 0.5


def make_row(name: str, seed: int) -> dict[str, Any]:
    """A row that the seed alone decides, with the gaps that real rows have."""
    rng = np.random.default_rng(seed)
    failure = FAILURES[int(rng.integers(6))]  # any but "error"
    touched = failure != "no_contact"
    return {
        "object": name,
        "seed": seed,
        "success": failure == "none",
        "failure": failure,
        "displacement_mm": float(rng.normal()) if touched else float("nan"),
        "q_linf": float(rng.uniform(0, 3)) if touched else None,
        "q_l1": float(rng.uniform(0, 2)) if touched else None,
        "q_reason": "" if touched else "no contacts",
        "contacts": int(rng.integers(6)),
        "mass_kg": 0.5,
        "torque_limit_nm": rng.uniform(size=7),
        "joint_angles_rad": rng.uniform(size=7) if touched else None,
        "tactile_proximal": rng.uniform(size=(3, 14, 6)) if touched else None,
        "tactile_distal": rng.uniform(size=(3, 13, 6)),
        "sim_seconds": 4.0,
    }


def quick(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """At once."""
    return Result(make_row(settings.object, seed))


def uneven(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Times that differ, so that trials end out of order."""
    time.sleep((seed % 7) * 0.005)
    return Result(make_row(settings.object, seed))


def slow(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """A twentieth of a second, so that a test can stop a run in the middle."""
    time.sleep(0.05)
    return Result(make_row(settings.object, seed))


def endless(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Every third trial never ends."""
    if seed % 3 == 0:
        time.sleep(3600)
    return Result(make_row(settings.object, seed))


def dies(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Kills its process, as the system does when memory is short, at every sixth seed."""
    if seed % 6 == 0:
        time.sleep(0.1)
        os.kill(os.getpid(), signal.SIGKILL)
    return Result(make_row(settings.object, seed))


def raises(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Fails at every sixth seed."""
    if seed % 6 == 0:
        raise ZeroDivisionError("no\nsecond line")
    return Result(make_row(settings.object, seed))


def wrong_column(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Gives a column that the table does not have."""
    return Result({**make_row(settings.object, seed), "colour": "red"})


def threads(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Tells how many numerical threads its process was given."""
    row = {**make_row(settings.object, seed), "contacts": int(os.environ["OPENBLAS_NUM_THREADS"])}
    return Result(row)
