"""One grasp-and-lift trial: what happens, what is predicted, and whether the grasp held."""

from sdh_sim.trial.outcome import Motion, classify
from sdh_sim.trial.trial import Trial
from sdh_sim.trial.trial_log import LogWriter, TrialLog
from sdh_sim.trial.trial_result import TrialResult, run_trial

__all__ = ["LogWriter", "Motion", "Trial", "TrialLog", "TrialResult", "classify", "run_trial"]
