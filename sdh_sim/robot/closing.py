"""How the fingers close: motor positions along a line from open to closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sdh_sim.errors import SettingsError


@dataclass(frozen=True, eq=False)
class Closing:
    """Motor positions along a line from open (closing ratio 0) to closed (1).

    Attributes:
        name: of the preshape; empty for a user's own postures.
        open: positions at ratio 0 (n,) [rad or m].
        travel: what they gain up to ratio 1 (n,) [rad or m].
        rate: closing ratio per second.
        squeezes: motors that squeeze in the end (n,) bool.
        fingers: index of the finger whose ratio each motor follows (n,).
        ranges: least and greatest position of each motor (n, 2) [rad or m].
    """

    name: str
    open: np.ndarray
    travel: np.ndarray
    rate: float
    squeezes: np.ndarray
    fingers: np.ndarray
    ranges: np.ndarray

    def angles(self, ratio: float | Sequence[float] | np.ndarray) -> np.ndarray:
        """Motor positions (n,) [rad or m], within their range.

        Args:
            ratio: 0 open to 1 closed; a sequence gives it per finger.
        """
        ratios = np.asarray(ratio, dtype=float)
        if ratios.ndim:
            ratios = ratios[self.fingers]
        return np.clip(self.open + self.travel * ratios, *self.ranges.T)

    @property
    def closed(self) -> np.ndarray:
        """Positions at ratio 1 (n,) [rad or m]."""
        return self.open + self.travel


def check_posture(what: str, given: object, names: Sequence[str], ranges: np.ndarray) -> np.ndarray:
    """The motor positions (n,) of a posture.

    Args:
        what: the posture, for messages.
        given: by a user.
        names: of the motors.
        ranges: of their positions (n, 2).

    Raises:
        SettingsError: not a finite number for each motor, within its range.
    """
    try:
        positions = np.array(given, dtype=float)
    except (TypeError, ValueError):
        positions = np.zeros(0)
    if positions.shape != (len(names),) or not np.isfinite(positions).all():
        raise SettingsError(
            f"{what}: got {given!r:.120}; give {len(names)} numbers, for {', '.join(names)}"
        )
    low, high = ranges.T
    beyond = np.flatnonzero((positions < low - 1e-9) | (positions > high + 1e-9))
    if len(beyond):
        k = int(beyond[0])
        raise SettingsError(
            f"{what}: got {positions[k]:.6g} for {names[k]}; its range is {low[k]:.4g} to "
            f"{high[k]:.4g}"
        )
    return positions
