"""How the fingers close: motor angles along a line from open to closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sdh_sim.errors import SettingsError
from sdh_sim.robot import sdh2_constants as c
from sdh_sim.robot.hand import MOTOR_FINGER, MOTOR_NAMES

CLOSING_RATE = 0.6  # closing ratio of a preshape per second: 49 deg/s, a quarter of the top speed
# The quickest phalanx of a user's own closing moves as fast as that of a preshape [rad/s].
CLOSING_SPEED = CLOSING_RATE * c.PRESHAPES["parallel"].proximal[1]
_FLEXES = np.array([m.kind != "spread" for m in c.MOTORS])
_RANGES = np.array([c.SPREAD_RANGE if m.kind == "spread" else c.PHALANX_RANGE for m in c.MOTORS])


@dataclass(frozen=True, eq=False)
class Closing:
    """Motor angles along a line from open (closing ratio 0) to closed (1).

    Attributes:
        name: of the preshape; empty for a user's own angles.
        open: angles at ratio 0 (7,) [rad].
        travel: what they gain up to ratio 1 (7,) [rad].
        rate: closing ratio per second.
    """

    name: str
    open: np.ndarray
    travel: np.ndarray
    rate: float

    def angles(self, ratio: float | Sequence[float] | np.ndarray) -> np.ndarray:
        """Motor angles (7,) [rad], within the joints' range.

        Args:
            ratio: 0 open to 1 closed; a sequence gives it per finger in the order of FINGERS.
        """
        ratios = np.broadcast_to(ratio, 3)[MOTOR_FINGER]
        return np.clip(self.open + self.travel * ratios, *_RANGES.T)

    @property
    def closed(self) -> np.ndarray:
        """Angles at ratio 1 (7,) [rad]."""
        return self.open + self.travel

    @property
    def squeezes(self) -> np.ndarray:
        """Motors that squeeze in the end: those that flex as the fingers close (7,) bool.

        The distal joints of two preshapes open while the finger closes, which keeps the pad
        upright; they hold while the proximal joint squeezes.
        """
        return _FLEXES & (self.travel > 0.0)


@lru_cache
def preshape_closing(preshape: str) -> Closing:
    """The closing of a preshape, a key of ``sdh2_constants.PRESHAPES``.

    Raises:
        SettingsError: no such preshape.
    """
    if preshape not in c.PRESHAPES:
        raise SettingsError(
            f"preshape: got {preshape!r:.80}; choose one of {', '.join(c.PRESHAPES)}"
        )
    shape = c.PRESHAPES[preshape]
    lines = {"spread": (shape.spread, 0.0), "proximal": shape.proximal, "distal": shape.distal}
    offset, slope = np.array([lines[m.kind] for m in c.MOTORS]).T
    return Closing(preshape, _fixed(offset), _fixed(slope), CLOSING_RATE)


def closing_between(
    open: Sequence[float] | np.ndarray, closed: Sequence[float] | np.ndarray
) -> Closing:
    """The closing between two postures of a user's own.

    Args:
        open: angles of the motors in the order of ``MOTOR_NAMES`` (7,) [rad].
        closed: likewise.

    Raises:
        SettingsError: not seven finite angles each within the joints' range, or no phalanx flexes.
    """
    ends = []
    for what, given in (("open", open), ("closed", closed)):
        try:
            angles = np.array(given, dtype=float)
        except (TypeError, ValueError):
            angles = np.zeros(0)
        if angles.shape != (len(c.MOTORS),) or not np.isfinite(angles).all():
            raise SettingsError(
                f"{what}: got {given!r:.120}; give {len(c.MOTORS)} angles in rad, for "
                f"{', '.join(MOTOR_NAMES)}"
            )
        low, high = _RANGES.T
        beyond = np.flatnonzero((angles < low - 1e-9) | (angles > high + 1e-9))
        if len(beyond):
            k = int(beyond[0])
            raise SettingsError(
                f"{what}: got {angles[k]:.6g} rad for {MOTOR_NAMES[k]}; its range is "
                f"{low[k]:.4g} to {high[k]:.4g} rad"
            )
        ends.append(angles)
    travel = ends[1] - ends[0]
    if not (travel[_FLEXES] > 0.0).any():
        raise SettingsError(
            "closed: no finger joint flexes between open and closed, so the hand would not grip; "
            "give a closed posture whose joints are bent further than the open one's"
        )
    rate = CLOSING_SPEED / float(np.abs(travel).max())
    return Closing("", _fixed(ends[0]), _fixed(travel), rate)


def _fixed(values: np.ndarray) -> np.ndarray:
    """The array itself, not to be written to from now on, since closings are shared."""
    values.setflags(write=False)
    return values
