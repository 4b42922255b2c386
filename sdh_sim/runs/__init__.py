"""One run on disk: what was asked for, what has finished, and who is writing."""

from sdh_sim.runs.environment import machine, versions
from sdh_sim.runs.finished_trials import FinishedTrials
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.lock import run_lock
from sdh_sim.runs.plan import MAX_TRIALS, Job, RunPlan, trial_seed

__all__ = [
    "MAX_TRIALS",
    "FinishedTrials",
    "Job",
    "RunFolder",
    "RunPlan",
    "machine",
    "run_lock",
    "trial_seed",
    "versions",
]
