"""One run on disk: its plan, its finished trials, and the lock of the process that writes."""

from sdh_sim.runs.columns import columns_of_run
from sdh_sim.runs.environment import machine, versions
from sdh_sim.runs.finished_trials import FinishedTrials
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.given_grasps import read_given_grasps, with_grasp
from sdh_sim.runs.lock import run_lock
from sdh_sim.runs.opened_runs import OpenedRun, notes_on, open_runs
from sdh_sim.runs.plan import MAX_TRIALS, Job, RunPlan, trial_seed

__all__ = [
    "MAX_TRIALS",
    "FinishedTrials",
    "Job",
    "OpenedRun",
    "RunFolder",
    "RunPlan",
    "columns_of_run",
    "machine",
    "notes_on",
    "open_runs",
    "read_given_grasps",
    "run_lock",
    "trial_seed",
    "versions",
    "with_grasp",
]
