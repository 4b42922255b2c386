"""What a trial leaves, and running one from settings and seed to that."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from sdh_sim.grasping import GraspPlan
from sdh_sim.records import TrialRow
from sdh_sim.settings import TrialSettings
from sdh_sim.trial.repeats import repeat_trial
from sdh_sim.trial.trial import Trial
from sdh_sim.trial.trial_log import LogWriter, TrialLog

_REPEATS = 3  # random stream of the copies, beside those of the trial


@dataclass(frozen=True)
class TrialResult:
    """What a trial leaves.

    Attributes:
        row: its row of the table, without its number in the run.
        log: its time series, if one was asked for.
        sim_seconds: simulated time [s].
        wall_seconds: real time [s].
        diverged: state after the step in which the simulation diverged, by name; else None.
    """

    row: TrialRow
    log: TrialLog | None
    sim_seconds: float
    wall_seconds: float
    diverged: dict[str, np.ndarray] | None = None


def run_trial(
    settings: TrialSettings, seed: int, log: bool = False, plan: GraspPlan | None = None
) -> TrialResult:
    """Run one trial; settings, seed and a given grasp decide it, a log changes nothing.

    Args:
        settings: object, torque limits and so on.
        seed: of everything random in the trial.
        log: keep poses, tactile arrays and torques at 30 Hz.
        plan: a given grasp; None draws one from the seed.

    Raises:
        SettingsError: no such object.
        NoFeasibleGrasp: none could be drawn.
    """
    begin = time.perf_counter()
    writer = LogWriter() if log else None
    trial = Trial(settings, seed, plan=plan, observers=() if writer is None else (writer,))
    row = trial.run()
    if settings.repeats and trial.infeasible is None:
        share = repeat_trial(trial, np.random.default_rng((seed, _REPEATS)))
        row.repeats, row.success_probability = share.n, share.value
        row.success_low, row.success_high = share.interval or (None, None)
    record = None
    if writer is not None and trial.infeasible is None:
        record = writer.finish(trial.scene, row, trial.prediction, trial.lifted_off)
    seconds = time.perf_counter() - begin
    return TrialResult(row, record, trial.simulation.time, seconds, trial.diverged)
