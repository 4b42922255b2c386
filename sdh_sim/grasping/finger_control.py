"""Finger control: close from open to closed until stalled, then squeeze at the torque limit."""

from __future__ import annotations

import numpy as np

from sdh_sim.robot import Closing
from sdh_sim.robot import sdh2_constants as c
from sdh_sim.robot.hand import MOTOR_FINGER

STALL_SHARE = 0.2  # of its torque limit at which a motor counts as stopped by the object
# No motor counts as stopped below three times the torque of moving freely (to start moving takes
# twice that), or most of its limit where that is less: weak motors must reach the object.
OVER_FREE, NEAR_LIMIT = 3.0, 0.9
SQUEEZE_TIME = 0.6  # [s] over which the grip is built up
# Torque that the squeezing reference asks of a motor that the object holds still, over its limit:
# just enough to saturate it. With far more, the two fingers, together stronger than the thumb,
# would push it back a long way before the forces balance.
SQUEEZE_DEMAND = 1.25


class FingerControl:
    """References of the 7 position servos through closing and squeezing.

    Attributes:
        ratio: closing ratio of each finger (3,).
        stalled: fingers that the object has stopped (3,) bool.
        reference: servo references (7,) [rad].
    """

    def __init__(
        self, closing: Closing, ratio: float, torque_limits: np.ndarray, stiffness: np.ndarray,
        damping: np.ndarray,
    ) -> None:  # fmt: skip
        """Start at a closing ratio.

        Args:
            closing: the postures from open to closed.
            ratio: closing ratio of all fingers.
            torque_limits: of the motors (7,) [N m].
            stiffness: gains of their position servos (7,) [N m/rad].
            damping: of their joints (7,) [N m s/rad].
        """
        self.closing = closing
        self.ratio = np.full(3, float(ratio))
        self.stalled = np.zeros(3, dtype=bool)
        self.reference = closing.angles(self.ratio)
        flexion = np.array([m.kind != "spread" for m in c.MOTORS])
        moves = np.abs(closing.angles(1.0) - closing.angles(0.0))
        least = np.minimum(OVER_FREE * damping * moves * closing.rate, NEAR_LIMIT * torque_limits)
        self._stall = np.where(flexion, np.maximum(STALL_SHARE * torque_limits, least), np.inf)
        self._load = np.zeros(len(c.MOTORS))  # torques over the stall torques, at the last tick
        self._advance = np.zeros(3)  # of the closing ratios in the last tick
        self._push = closing.squeezes * SQUEEZE_DEMAND * torque_limits / stiffness
        self._grip: np.ndarray | None = None
        self._squeezed = 0.0

    @property
    def closed(self) -> bool:
        """Every finger is stopped by the object or closed fully."""
        return bool((self.stalled | (self.ratio >= 1.0)).all())

    @property
    def settled(self) -> bool:
        """The squeeze has reached its full reference."""
        return self._squeezed >= 1.0

    def close(self, torques: np.ndarray, dt: float) -> np.ndarray:
        """One tick of closing: advance the fingers that nothing stops.

        A finger goes back to where it was as its torque crossed the stall torque, at some time
        within the last tick: a grasp must not depend on when the ticks are.

        Args:
            torques: motor torques now (7,) [N m].
            dt: length of the tick [s].

        Returns:
            servo references (7,) [rad].
        """
        load = np.abs(torques) / self._stall
        for f in np.flatnonzero(~self.stalled):
            over = (f == MOTOR_FINGER) & (load > 1.0)
            if over.any():
                self.stalled[f] = True
                # No motor was over before, or the finger would have been stopped then.
                since = (load[over] - 1.0) / (load[over] - self._load[over])
                self.ratio[f] -= since.max() * self._advance[f]
        self._load = load
        before = self.ratio.copy()
        self.ratio[~self.stalled] = np.minimum(
            self.ratio[~self.stalled] + self.closing.rate * dt, 1.0
        )
        self._advance = self.ratio - before
        self.reference = self.closing.angles(self.ratio)
        return self.reference

    def squeeze(self, angles: np.ndarray, dt: float) -> np.ndarray:
        """One tick of squeezing: move the references beyond where the object holds the fingers.

        Args:
            angles: motor angles now (7,) [rad]; the squeeze starts at those of the first call.
            dt: length of the tick [s].

        Returns:
            servo references (7,) [rad].
        """
        if self._grip is None:
            self._grip = np.where(self._push > 0.0, angles, self.reference)
        self._squeezed = min(1.0, self._squeezed + dt / SQUEEZE_TIME)
        self.reference = self._grip + self._squeezed * self._push
        return self.reference
