"""Old name of ``sdh_sim.metrics.user_metrics``, which earlier pages showed to users."""

import warnings

from sdh_sim.metrics import find_metrics

__all__ = ["find_metrics"]

warnings.warn(
    "sdh_sim.user_metrics is now sdh_sim.metrics; import from there",
    DeprecationWarning,
    stacklevel=2,
)
