"""The tactile arrays as a device: what they report of the pressure on their taxels.

Sources of the ``dsa`` preset: dead-weight tests of a distal pad, published as sums of counts:
4513 F - 3953 at F newton under a stamp of 10.5 mm side, taxels clipped near 3500 of 4095; slopes of
2810, 4513 and 5074 counts/N at 0.5, 3 and 10 s after contact; 16 to 28 taxels lit under 9.5. What
is marked as an assumption is not published.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import sparse

from sdh_sim.robot import Hand, built_in_hand

FRAME_RATE = 30.0  # frames per second of the real arrays
TAXELS_SEED = 20170529  # of the spread and the dead taxels: one hand, the same in every trial


@dataclass(frozen=True)
class SensorModel:
    """One kind of array.

    Attributes:
        gain: counts per kPa above the dead zone, 3 s after contact.
        dead_zone: pressure below which a taxel reads nothing [kPa]: 21 lit taxels share the 3953
            counts (with no crosstalk 9.5 taxels would, and it were 8 kPa).
        clip: greatest reading [counts]; readings are whole counts, 12 bit.
        crosstalk: share of a taxel's pressure that each of its four neighbours takes over; 0.1
            lights 21 taxels under a stamp of 3 by 3, in the middle of the published range. Rubber
            beside the outermost taxels passes on as much.
        creep_share: share of the final reading that comes late, as in a standard linear solid.
        creep_time: time constant of the late share [s]; both fit the three published slopes.
        noise: standard deviation of a loaded taxel's reading [counts] (assumption).
        gain_spread: relative standard deviation of the taxels' gains (assumption).
        dead_share: share of taxels that read nothing at all.
    """

    gain: float = 52.0
    dead_zone: float = 3.6
    clip: float = 3500.0
    crosstalk: float = 0.1
    creep_share: float = 0.587
    creep_time: float = 1.85
    noise: float = 4.0
    gain_spread: float = 0.05
    dead_share: float = 0.0

    def counts(
        self,
        pressure: np.ndarray,
        gains: float | np.ndarray = 1.0,
        noise: float | np.ndarray = 0.0,
    ) -> np.ndarray:
        """Whole counts for pressures [kPa], any shape: the static part of a reading.

        Args:
            pressure: on each taxel, crosstalk and creep included [kPa].
            gains: of each taxel over the nominal gain.
            noise: of each taxel [counts]; unloaded taxels have none.
        """
        raw = (pressure - self.dead_zone) * self.gain * gains
        return np.floor(np.clip(np.where(raw > 0.0, raw + noise, 0.0), 0.0, self.clip))


PRESETS: dict[str, SensorModel | None] = {"dsa": SensorModel(), "ideal": None}
"""``ideal`` reports the pressure itself."""

# Slope 3 s after contact over the final one: the gain is quoted at 3 s.
CREEP_REFERENCE = 3.0  # [s]


class TactileSensor:
    """The arrays of a hand in time; ``frame`` must be called at FRAME_RATE while it touches.

    Attributes:
        model: the kind of array, None for an ideal one.
        hand: whose arrays they are.
    """

    def __init__(
        self, model: SensorModel | None, rng: np.random.Generator, hand: Hand | None = None
    ) -> None:
        """Without a load.

        Args:
            model: as above.
            rng: of the noise.
            hand: as above; None: the SDH-2.
        """
        self.model, self.hand = model, hand or built_in_hand()
        self._rng = rng
        size = self.hand.tactile_size
        self._area = taxel_areas(self.hand)
        self._pressure = np.zeros(size)
        self._late = np.zeros(size)
        self._gains = np.ones(size)
        if model is not None:
            taxels = np.random.default_rng(TAXELS_SEED)
            self._gains += model.gain_spread * taxels.standard_normal(size)
            self._gains[taxels.random(size) < model.dead_share] = 0.0

    def frame(self, forces: np.ndarray, beside: np.ndarray | None = None) -> None:
        """Take in the load of a frame, 1 / FRAME_RATE after the last.

        Args:
            forces: normal force on every taxel (taxels,) [N].
            beside: normal force on rubber beside every taxel under which there is none (taxels,)
                [N]; crosstalk lights the taxel by its share of it. None: no such force.
        """
        self._pressure = forces / self._area * 1e-3
        if self.model is None:
            return
        self._pressure = spread_pressure(self._pressure, self.model.crosstalk, self.hand)
        if beside is not None:
            self._pressure += self.model.crosstalk * beside / self._area * 1e-3
        decay = np.exp(-1.0 / (FRAME_RATE * self.model.creep_time))
        self._late = self._pressure + decay * (self._late - self._pressure)

    def read(self) -> np.ndarray:
        """Readings of the last frame (taxels,) [kPa].

        From the ``dsa`` arrays, counts over gain as a user has them: the dead zone is lost.
        """
        model = self.model
        if model is None:
            return self._pressure.copy()
        share = model.creep_share
        at_reference = 1.0 - share * np.exp(-CREEP_REFERENCE / model.creep_time)
        sensed = ((1.0 - share) * self._pressure + share * self._late) / at_reference
        noise = model.noise * self._rng.standard_normal(len(sensed))
        return model.counts(sensed, self._gains, noise) / model.gain


@lru_cache(maxsize=8)
def taxel_areas(hand: Hand) -> np.ndarray:
    """Area of every taxel of a hand, flat (taxels,) [m^2]."""
    return np.concatenate([np.full(pad.array.live.size, pad.array.pitch**2) for pad in hand.pads])


def spread_pressure(pressure: np.ndarray, share: float, hand: Hand) -> np.ndarray:
    """Pressure (taxels,) after each taxel gave a share of it to each live neighbour.

    The sum over an array stays.
    """
    neighbours, degree = _neighbours(hand)
    return pressure + share * (neighbours @ pressure - degree * pressure)


@lru_cache(maxsize=8)
def _neighbours(hand: Hand) -> tuple[sparse.csr_array, np.ndarray]:
    """Which taxels of a hand touch along an edge (taxels, taxels), and how many each (taxels,)."""
    touch = np.zeros((hand.tactile_size, hand.tactile_size))
    for offset, pad in zip(hand.pad_offsets[:-1], hand.pads, strict=True):
        live = pad.array.live
        index = offset + np.arange(live.size).reshape(live.shape)
        for first, second in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
            both = live[first] & live[second]
            a, b = index[first][both], index[second][both]
            touch[a, b] = touch[b, a] = 1.0
    found = sparse.csr_array(touch)
    return found, found.sum(axis=1)
