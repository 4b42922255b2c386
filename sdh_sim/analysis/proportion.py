"""A share with its interval of confidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_Z95 = 1.959963984540054  # 97.5 % quantile of the standard normal distribution


@dataclass(frozen=True)
class Rate:
    """A share k of n with its 95 % Wilson interval; everything but k, n is None when n = 0."""

    k: int
    n: int

    @property
    def value(self) -> float | None:
        """k / n."""
        return self.k / self.n if self.n else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's score interval: right to the ends 0 and 1, where k / n ± z s is not."""
        if not self.n:
            return None
        p, z2 = self.k / self.n, _Z95**2
        centre = p + z2 / (2 * self.n)
        half = _Z95 * float(np.sqrt(p * (1 - p) / self.n + z2 / (4 * self.n**2)))
        scale = 1 + z2 / self.n
        low, high = (centre - half) / scale, (centre + half) / scale
        # The ends are exact where k is 0 or n; rounding must not step over them.
        return (0.0 if self.k == 0 else low), (1.0 if self.k == self.n else high)
