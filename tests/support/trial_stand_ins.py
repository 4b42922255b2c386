"""Trials that take no time, for tests of what surrounds a trial: order, resume, stops, deaths.

Tests of real trials are elsewhere; these rows only have a trial's form.
"""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from sdh_sim.campaign.job_result import JobResult
from sdh_sim.records import FAILURES, normalise
from sdh_sim.runs import Job, RunPlan
from sdh_sim.settings import TrialSettings

OBJECTS = ("box", "oval_bottle")


def plan(trials: int = 6, objects: tuple[str, ...] = OBJECTS, seed: int = 0, **settings) -> RunPlan:
    """A run of stand-ins."""
    return RunPlan(objects, TrialSettings(objects[0], **settings), trials, seed)


@dataclass(frozen=True)
class Result:
    """What ``run_trial`` returns, as far as a campaign looks."""

    row: dict[str, Any]
    log: Any = None
    sim_seconds: float = 4.0
    wall_seconds: float = 0.5
    diverged: dict[str, np.ndarray] | None = None


def make_row(name: str, seed: int) -> dict[str, Any]:
    """A row that the seed alone decides, with the gaps that real rows have."""
    rng = np.random.default_rng(seed)
    failure = FAILURES[int(rng.integers(6))]  # neither "error" nor "infeasible"
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


def given(settings: TrialSettings, seed: int, log: bool = False, *, plan: Any) -> Result:
    """At once, for grasps of a file: the row says where the palm was to go."""
    from sdh_sim.objects import object_info  # MuJoCo: the other stand-ins' processes start sooner

    row = make_row(settings.object, seed)
    row["plan_palm_pose_object"] = plan.palm_in_object(object_info(settings.object))
    row["preshape"] = plan.closing.name or None
    row |= {"plan_open_rad": plan.closing.open, "plan_closed_rad": plan.closing.closed}
    return Result(row)


def given_or_error(settings: TrialSettings, seed: int, log: bool = False, *, plan: Any) -> Result:
    """As ``given``; fails at every third seed."""
    if seed % 3 == 0:
        raise ZeroDivisionError
    return given(settings, seed, plan=plan)


def either(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Holds the object, or drops it at odd seeds."""
    failure = "dropped" if seed % 2 else "none"
    row = make_row(settings.object, seed)
    return Result({**row, "success": failure == "none", "failure": failure})


def holds(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Always holds the object."""
    return Result({**make_row(settings.object, seed), "success": True, "failure": "none"})


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


def hangs(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Never ends, in two ways.

    At every sixth seed it sleeps and refuses SIGTERM; at others of six its first try stops its
    process, as a debugger does.
    """
    again = _tried(seed) > 1
    if seed % 6 == 0:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(3600)
    if seed % 6 == 2 and not again:
        os.kill(os.getpid(), signal.SIGSTOP)
    return Result(make_row(settings.object, seed))


def _tried(seed: int) -> int:
    """Notes the try in the folder STAND_IN_TRIES, if there is one; how many of it there were."""
    folder = os.environ.get("STAND_IN_TRIES")
    if folder is None:
        return 0
    with open(os.path.join(folder, str(seed)), "ab") as file:
        file.write(b".")
        return file.tell()


def dies(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Kills its process, as the system does when memory is short, at every sixth seed."""
    _tried(seed)
    if seed % 6 == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return Result(make_row(settings.object, seed))


def dies_slowly(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """As ``dies``, a twentieth of a second later."""
    time.sleep(0.05)
    return dies(settings, seed)


def raises(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Fails at every sixth seed."""
    _tried(seed)
    if seed % 6 == 0:
        raise ZeroDivisionError("no\nsecond line")
    return Result(make_row(settings.object, seed))


def flaky(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Its first try raises at even seeds and kills its process at multiples of three."""
    if _tried(seed) == 1:
        if seed % 2 == 0:
            raise MemoryError
        if seed % 3 == 0:
            os.kill(os.getpid(), signal.SIGSEGV)
    return Result(make_row(settings.object, seed))


def growing(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Rows of little content on the first object, of much on the others."""
    row = make_row(settings.object, seed)
    size = 1 if settings.object == "box" else 50_000
    noise = np.random.default_rng(seed).integers(33, 127, size, dtype=np.uint8)
    return Result({**row, "q_reason": noise.tobytes().decode()})


def always_fails(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Nothing works."""
    raise ImportError("no module named physics")


def noted(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """A twentieth of a second; notes that it began."""
    _tried(seed)
    return slow(settings, seed)


def diverges(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Every third trial's simulation diverges."""
    row = make_row(settings.object, seed)
    if seed % 3:
        return Result({**row, "success": row["failure"] == "none"})
    state = {"qpos": np.array([1.0, np.nan]), "time": np.array(0.25)}
    unstable = {"success": False, "failure": "unstable_simulation"}
    return Result({**row, **unstable}, diverged=state)


def wrong_column(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Gives a column that the table does not have."""
    return Result({**make_row(settings.object, seed), "colour": "red"})


def threads(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Tells how many numerical threads its process was given."""
    row = {**make_row(settings.object, seed), "contacts": int(os.environ["OPENBLAS_NUM_THREADS"])}
    return Result(row)


def as_result(job: Job) -> JobResult:
    """A job's row at once, for executors alone."""
    return JobResult(normalise({**make_row(job.settings.object, job.seed), **job.labels}))


def as_slow_result(job: Job) -> JobResult:
    """As ``as_result``, never."""
    time.sleep(3600)
    return as_result(job)


def with_mujoco(settings: TrialSettings, seed: int, log: bool = False) -> Result:
    """Holds the object, in a process in which MuJoCo can be imported."""
    import mujoco  # noqa: F401

    return holds(settings, seed)
