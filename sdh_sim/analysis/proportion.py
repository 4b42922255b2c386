"""A proportion with its 95 % confidence interval."""

from __future__ import annotations

import functools
from dataclasses import dataclass

CONFIDENCE = 0.95


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


@functools.lru_cache(maxsize=10_000)  # a report asks for each interval several times
def wilson_interval(k: int, n: int) -> tuple[float, float]:
    """Wilson's score interval of k of n, n > 0; 0 where k is 0 and 1 where k is n, exactly.

    E. B. Wilson: Probable inference, the law of succession, and statistical inference.
    Journal of the American Statistical Association 22 (1927).
    """
    # Most of a second to import: a trial that counts without an interval shall not wait for it.
    import scipy.stats

    found = scipy.stats.binomtest(k, n).proportion_ci(CONFIDENCE, method="wilson")
    return float(found.low), float(found.high)
