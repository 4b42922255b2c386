"""A proportion with its 95 % confidence interval."""

from __future__ import annotations

import math
from dataclasses import dataclass

_Z95 = 1.959963984540054  # 97.5 % quantile of the standard normal distribution


@dataclass(frozen=True)
class Proportion:
    """k of n trials; its value and interval are None where n is 0."""

    k: int
    n: int

    @property
    def value(self) -> float | None:
        """k / n."""
        return self.k / self.n if self.n else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's score interval, which never leaves 0 to 1."""
        return wilson_interval(self.k, self.n) if self.n else None

    @property
    def percent(self) -> str:
        """Value and interval in percent, as in "86 (83–88)"; a dash where there are none."""
        return self.in_percent()

    def in_percent(self, digits: int = 0) -> str:
        """As ``percent``, with so many digits after the point."""
        if self.value is None or self.interval is None:
            return "-"
        value, low, high = (f"{100 * x:.{digits}f}" for x in (self.value, *self.interval))
        return f"{value} ({low}–{high})"


def wilson_interval(k: float, n: int) -> tuple[float, float]:
    """Wilson's score interval of k of n, n > 0; 0 where k is 0 and 1 where k is n, exactly.

    E. B. Wilson: Probable inference, the law of succession, and statistical inference.
    Journal of the American Statistical Association 22 (1927).
    """
    # SciPy's binomtest(k, n).proportion_ci(method="wilson") differs in the last bit, which a stored
    # trial with repeats keeps (success_low, success_high) and its repetition is compared with. It
    # also takes a hundred times as long, and its import most of a second. A test compares the two.
    p, z2 = k / n, _Z95**2
    centre = p + z2 / (2 * n)
    half = _Z95 * math.sqrt(p * (1 - p) / n + z2 / (4 * n**2))
    scale = 1 + z2 / n
    return (
        0.0 if k == 0 else (centre - half) / scale,
        1.0 if k == n else (centre + half) / scale,
    )
