"""Finger control: close from open to closed until stalled, then squeeze at the torque limit."""

from __future__ import annotations

import numpy as np

from sdh_sim.robot import Closing, Hand

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
    """References of the hand's position servos through closing and squeezing.

    Attributes:
        ratio: closing ratio of each finger (fingers,).
        stalled: fingers that the object has stopped (fingers,) bool.
        reference: servo references (n,) [rad or m].
    """

    def __init__(
        self, hand: Hand, closing: Closing, ratio: float, torque_limits: np.ndarray,
        stiffness: np.ndarray, damping: np.ndarray, friction: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        """Start at a closing ratio.

        Args:
            hand: whose motors they are.
            closing: the postures from open to closed.
            ratio: closing ratio of all fingers.
            torque_limits: of the motors (n,) [N m or N].
            stiffness: gains of their position servos (n,) [N m/rad or N/m].
            damping: of their joints (n,) [N m s/rad or N s/m].
            friction: of their gears, which they overcome beside the limits (n,) [N m or N]; None
                or empty: none.
        """
        self.closing = closing
        fingers, motors = len(hand.fingers), len(hand.motors)
        self._stops = np.zeros((fingers, motors), dtype=bool)
        for index, finger in enumerate(hand.fingers):
            self._stops[index, list(finger.stops)] = True
        self._shared = self._stops.sum(axis=0) > 1
        self.ratio = np.full(fingers, float(ratio))
        self.stalled = np.zeros(fingers, dtype=bool)
        self.reference = closing.angles(self.ratio)
        moves = np.abs(closing.angles(1.0) - closing.angles(0.0))
        least = np.minimum(OVER_FREE * damping * moves * closing.rate, NEAR_LIMIT * torque_limits)
        self._stall = np.maximum(STALL_SHARE * torque_limits, least)
        lost = friction if friction is not None and len(friction) else np.zeros(motors)
        self._stall = self._stall + lost
        self._load = np.zeros(motors)  # torques over the stall torques, at the last tick
        self._advance = np.zeros(fingers)  # of the closing ratios in the last tick
        sense = np.array([motor.flexes for motor in hand.motors])
        sense = np.where(sense == 0, np.sign(closing.travel), sense)
        demand = SQUEEZE_DEMAND * torque_limits + lost
        self._push = sense * closing.squeezes * demand / stiffness
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
            torques: motor torques now (n,) [N m or N].
            dt: length of the tick [s].

        Returns:
            servo references (n,) [rad or m].
        """
        load = np.abs(torques) / self._stall
        for f in np.flatnonzero(~self.stalled):
            over = self._stops[f] & (load > 1.0)
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

        A motor of several fingers goes on for as long as the first of them moves the object: only
        when the last one meets it, the object holds the motor.

        Args:
            angles: motor angles now (n,) [rad or m]; the squeeze starts at those of the first call,
                that of a motor of several fingers at those of every call.
            dt: length of the tick [s].

        Returns:
            servo references (n,) [rad or m].
        """
        if self._grip is None:
            self._grip = np.where(self._push != 0.0, angles, self.reference)
        self._grip[self._shared] = angles[self._shared]
        self._squeezed = min(1.0, self._squeezed + dt / SQUEEZE_TIME)
        self.reference = self._grip + self._squeezed * self._push
        return self.reference
