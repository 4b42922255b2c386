"""Many trials: where they run, how they stop, and what a run gives."""

from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.campaign.session import RunResult

__all__ = ["RunResult", "run_campaign"]
