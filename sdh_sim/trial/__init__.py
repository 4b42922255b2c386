"""One grasp-and-lift trial: what happens, what is predicted, and whether the grasp held."""

from sdh_sim.trial.outcome import Motion, classify
from sdh_sim.trial.run_trial import TrialResult, run_trial
from sdh_sim.trial.trial import Trial
from sdh_sim.trial.trial_log import LogWriter, TrialLog

__all__ = ["LogWriter", "Motion", "Trial", "TrialLog", "TrialResult", "classify", "run_trial"]
