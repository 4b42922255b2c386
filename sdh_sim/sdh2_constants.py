"""Old name of ``sdh_sim.robot.sdh2_constants``, which earlier pages showed to users."""

import warnings

from sdh_sim.robot.sdh2_constants import *  # noqa: F403

warnings.warn(
    "sdh_sim.sdh2_constants is now sdh_sim.robot.sdh2_constants; import from there",
    DeprecationWarning,
    stacklevel=2,
)
