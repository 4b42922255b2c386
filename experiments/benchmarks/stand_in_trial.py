"""A trial that takes no time, in a file of its own: worker processes import it by its name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sdh_sim.records import FAILURES
from sdh_sim.settings import TrialSettings


@dataclass(frozen=True)
class StandIn:
    """What ``run_trial`` returns, as far as a campaign looks."""

    row: dict[str, Any]
    log: Any = None
    sim_seconds: float = 4.0
    wall_seconds: float = 0.0


def stand_in(settings: TrialSettings, seed: int, log: bool = False) -> StandIn:
    """A row that the seed decides, with the arrays of a real one, without a trial."""
    rng = np.random.default_rng(seed)
    failure = FAILURES[int(rng.integers(6))]  # those that count in a comparison
    q = rng.gamma(2.0, 0.5)
    return StandIn(
        {
            "object": settings.object,
            "seed": seed,
            "success": failure == "none",
            "failure": failure,
            "displacement_mm": float(rng.gamma(2.0, 4.0)),
            "rotation_deg": float(rng.gamma(2.0, 4.0)),
            "q_linf": q,
            "q_l1": 0.6 * q,
            "q_reason": "",
            "contacts": int(rng.integers(1, 7)),
            "mass_kg": 0.5,
            "torque_limit_nm": rng.uniform(size=7),
            "joint_angles_rad": rng.uniform(size=7),
            # Readings have twelve bits, and most taxels feel nothing.
            "tactile_proximal": _readings(rng, (3, 14, 6)),
            "tactile_distal": _readings(rng, (3, 13, 6)),
            "sim_seconds": 4.0,
        }
    )


def _readings(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return np.where(rng.uniform(size=shape) < 0.15, rng.integers(1, 4096, shape) * 60.0, 0.0)
