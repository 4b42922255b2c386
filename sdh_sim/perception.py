"""Old name of ``sdh_sim.sensing``, which earlier pages showed to users; import from there."""

import warnings

from sdh_sim.sensing import PadContact, PerceivedGrasp, perceive

__all__ = ["PadContact", "PerceivedGrasp", "perceive"]

warnings.warn(
    "sdh_sim.perception is now sdh_sim.sensing; import from there", DeprecationWarning, stacklevel=2
)
