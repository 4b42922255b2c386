"""Old name of ``sdh_sim.metrics.user_metrics``, which earlier pages showed to users."""

import warnings

from sdh_sim.metrics import evaluate, find_metrics, load_metric

__all__ = ["evaluate", "find_metrics", "load_metric"]

warnings.warn(
    "sdh_sim.user_metrics is now sdh_sim.metrics; import from there",
    DeprecationWarning,
    stacklevel=2,
)
