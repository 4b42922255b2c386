"""What a check of the validation leaves: rows of its table, and curves for its picture."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        quantity: what is compared.
        unit: of the two values.
        predicted: by the closed form.
        simulated: by MuJoCo.
        tolerance: allowed deviation as a share of ``scale``.
        reason: why that much is allowed.
        scale: what deviations are measured against; None is the predicted value.
        judged: False for a known deviation of the contact model, which is reported with the bound
            expected of it but decides nothing.
    """

    quantity: str
    unit: str
    predicted: float
    simulated: float
    tolerance: float
    reason: str
    scale: float | None = None
    judged: bool = True

    @property
    def deviation(self) -> float:
        """Simulated less predicted as a share of the scale."""
        scale = abs(self.predicted if self.scale is None else self.scale)
        return (self.simulated - self.predicted) / scale if scale > 0.0 else math.nan

    @property
    def passed(self) -> bool:
        """Within the tolerance; a value that is not a number never is."""
        return abs(self.deviation) <= self.tolerance


@dataclass(frozen=True)
class Result:
    """Rows of one check and the curves its picture is drawn from."""

    rows: tuple[Row, ...]
    curves: dict[str, Any] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Every judged row is within its tolerance."""
        return all(row.passed for row in self.rows if row.judged)


def threshold(
    slips: Callable[[float], bool], low: float, high: float, share: float = 1e-3
) -> float:
    """Value between low and high above which ``slips`` turns True, to a share of ``high``.

    Returns:
        The middle of the last bracket; nan when the ends do not bracket the change.
    """
    if slips(low) or not slips(high):
        return math.nan
    width = share * high
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if slips(middle) else (middle, high)
    return 0.5 * (low + high)
