"""Finger control: close along the preshape until stalled, then squeeze at the torque limit."""

from __future__ import annotations

import numpy as np

from sdh_sim import sdh2_constants as c
from sdh_sim.hand import FINGER_NAMES, preshape_angles

CLOSING_RATE = 0.6  # closing ratio per second: about 50 deg/s, a quarter of the top speed
STALL_SHARE = 0.45  # of its torque limit at which a motor counts as stopped by the object
SQUEEZE_TIME = 0.6  # [s] over which the grip is built up
# Torque that the squeezing reference asks of a motor the object does not let move, over its limit:
# just enough to saturate it. Far more would let the two fingers, together stronger than the thumb,
# push it back a long way before they balance.
SQUEEZE_DEMAND = 1.25
# Preshapes whose distal joints close as well; in the others they open while the finger closes,
# keeping the pad upright, and hold while the proximal joint squeezes.
CURLING = ("cylindrical", "spherical")


class FingerControl:
    """References of the 7 position servos through closing and squeezing.

    Attributes:
        ratio: closing ratio of each finger (3,).
        stalled: fingers that the object has stopped (3,) bool.
        reference: servo references (7,) [rad].
    """

    def __init__(
        self, preshape: str, ratio: float, torque_limits: np.ndarray, stiffness: np.ndarray
    ) -> None:
        self.preshape = preshape
        self.ratio = np.full(3, float(ratio))
        self.stalled = np.zeros(3, dtype=bool)
        self.reference = preshape_angles(preshape, self.ratio)
        self._limits = torque_limits
        finger = [FINGER_NAMES.index(m.finger) for m in c.MOTORS]
        self._finger = np.array(finger)
        self._flexion = np.array([m.kind != "spread" for m in c.MOTORS])
        squeezes = [
            m.kind == "proximal" or (m.kind == "distal" and preshape in CURLING) for m in c.MOTORS
        ]
        self._push = np.array(squeezes) * SQUEEZE_DEMAND * torque_limits / stiffness
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

        Args:
            torques: motor torques now (7,) [N m].
            dt: length of the tick [s].
        """
        loaded = (np.abs(torques) > STALL_SHARE * self._limits) & self._flexion
        for f in range(3):
            self.stalled[f] |= bool(loaded[self._finger == f].any())
        self.ratio[~self.stalled] = np.minimum(self.ratio[~self.stalled] + CLOSING_RATE * dt, 1.0)
        self.reference = preshape_angles(self.preshape, self.ratio)
        return self.reference

    def squeeze(self, angles: np.ndarray, dt: float) -> np.ndarray:
        """One tick of squeezing: move the references beyond where the object holds the fingers.

        Args:
            angles: motor angles now (7,) [rad]; those of the first call are where it starts.
            dt: length of the tick [s].
        """
        if self._grip is None:
            self._grip = np.where(self._push > 0.0, angles, self.reference)
        self._squeezed = min(1.0, self._squeezed + dt / SQUEEZE_TIME)
        self.reference = self._grip + self._squeezed * self._push
        return self.reference
