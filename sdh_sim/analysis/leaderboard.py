"""Metrics side by side on the same trials: how well each ranks grasps, how it compares to the best.

Every metric is compared on every trial: where it has no value the grasp counts as the worst of all,
so that no metric gains by refusing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sdh_sim.analysis.load_agreement import spearman
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.roc_area import AreaDifference, auc, auc_interval, compare_areas
from sdh_sim.analysis.thresholds import CrossValidated, cross_validate


@dataclass(frozen=True)
class Entrant:
    """A metric with its values on some trials.

    Attributes:
        name, label, family: of the metric.
        values: (n,) in its own orientation; NaN where it has none.
        high_is_good: its orientation.
        threshold: the value beyond which it predicts success, or None.
        cost_us: processor time of one grasp [µs], the median; NaN where unknown.
        fault: what it raised first, empty where nothing.
    """

    name: str
    label: str
    family: str
    values: np.ndarray
    high_is_good: bool = True
    threshold: float | None = None
    cost_us: float = math.nan
    fault: str = ""

    @property
    def scores(self) -> np.ndarray:
        """Values turned so that high is good, -inf where there is none (n,)."""
        turned = self.values if self.high_is_good else -self.values
        return np.where(np.isnan(turned), -np.inf, turned)


@dataclass(frozen=True)
class Outcomes:
    """What became of the trials.

    Attributes:
        success: (n,) bool.
        fold: (n,) of cross-validation.
        q_sim: (n,) load held [weights]; NaN where it was not tested; None: nowhere.
        displacement_mm: (n,) motion in the hand during the lift; NaN where it is not known.
        sensed: (n,) bool, whether a pad felt a contact; the other grasps are each metric's worst,
            which its remarks do not count.
    """

    success: np.ndarray
    fold: np.ndarray
    q_sim: np.ndarray | None
    displacement_mm: np.ndarray
    sensed: np.ndarray


@dataclass(frozen=True)
class Standing:
    """How a metric does on a group of trials.

    Attributes:
        entrant: the metric.
        n: trials.
        missing: those without a value, which count as the worst grasps.
        infinite: those with an infinite value.
        constant: all values are alike: it ranks nothing.
        auc, auc_interval: area under the ROC curve; None where an outcome does not occur.
        best: accuracy at the threshold that is most accurate on other trials; None where an
            outcome occurs less than twice.
        own: accuracy at the metric's own threshold, of no trials where it has none.
        rank_load: rank correlation with q_sim; above 0 is good. None where it is undefined.
        rank_motion: rank correlation with the motion in the hand; above 0 is good.
        behind: area less that of the best metric, with DeLong's interval and test; None for the
            best itself.
        holm_p: the test's p-value with Holm's correction for so many metrics; None as ``behind``.
    """

    entrant: Entrant
    n: int
    missing: int
    infinite: int
    constant: bool
    auc: float | None
    auc_interval: tuple[float, float] | None
    best: CrossValidated | None
    own: Proportion
    rank_load: float | None
    rank_motion: float | None
    behind: AreaDifference | None = None
    holm_p: float | None = None

    @property
    def remarks(self) -> str:
        """What a reader must know of the values, in a few words."""
        found = []
        if self.entrant.fault:
            found.append(f"failed ({self.entrant.fault})")
        if self.missing:
            found.append(f"no value for {self.missing}")
        if self.infinite:
            found.append(f"infinite for {self.infinite}")
        if self.constant:
            found.append("constant")
        return "; ".join(found)


@dataclass(frozen=True)
class Leaderboard:
    """Standings by group of trials, the best first.

    Attributes:
        standings: by group.
    """

    standings: Mapping[str, tuple[Standing, ...]] = field(default_factory=dict)

    @property
    def main(self) -> str:
        """The group of all trials."""
        return list(self.standings)[-1]


def rank_all(
    entrants: Sequence[Entrant], outcomes: Outcomes, groups: Mapping[str, np.ndarray]
) -> Leaderboard:
    """Rank metrics on every group of trials.

    Args:
        entrants: the metrics, of different names.
        outcomes: of the trials.
        groups: which trials (n,) belong to each, as ``groups_of`` gives them.

    Raises:
        ValueError: two entrants of one name, or arrays of other lengths.
    """
    names = [entrant.name for entrant in entrants]
    if len(set(names)) != len(names):
        raise ValueError(f"metrics: got a name twice among {names}")
    for entrant in entrants:
        if entrant.values.shape != outcomes.success.shape:
            raise ValueError(f"{entrant.name}: expected {outcomes.success.shape} values")
    return Leaderboard({g: _rank(entrants, outcomes, members) for g, members in groups.items()})


def _rank(
    entrants: Sequence[Entrant], outcomes: Outcomes, members: np.ndarray
) -> tuple[Standing, ...]:
    found = [_standing(entrant, outcomes, members) for entrant in entrants]
    found.sort(key=lambda s: -1.0 if s.auc is None else s.auc, reverse=True)
    if not found or found[0].auc is None:
        return tuple(found)
    success = outcomes.success[members]
    leader = found[0].entrant.scores[members]
    behind = [
        compare_areas(s.entrant.scores[members], leader, success) if k else None
        for k, s in enumerate(found)
    ]
    corrected = holm([None if b is None else b.p_value for b in behind])
    return tuple(
        replace(s, behind=b, holm_p=p) for s, b, p in zip(found, behind, corrected, strict=True)
    )


def _standing(entrant: Entrant, outcomes: Outcomes, members: np.ndarray) -> Standing:
    values, scores = entrant.values[members], entrant.scores[members]
    success, fold = outcomes.success[members], outcomes.fold[members]
    own = Proportion(0, 0)
    if entrant.threshold is not None:
        turned = entrant.threshold if entrant.high_is_good else -entrant.threshold
        own = Proportion(int(((scores > turned) == success).sum()), len(success))
    load = None
    if outcomes.q_sim is not None:
        tested = ~np.isnan(outcomes.q_sim[members])
        load = spearman(scores[tested], outcomes.q_sim[members][tested])
    motion = outcomes.displacement_mm[members]
    known = ~np.isnan(motion)
    two_sided = min(success.sum(), (~success).sum()) >= 2
    looked_at = values[outcomes.sensed[members]]
    return Standing(
        entrant=entrant,
        n=len(success),
        missing=int(np.isnan(looked_at).sum()),
        infinite=int(np.isinf(looked_at).sum()),
        constant=len(looked_at) > 1 and bool((looked_at == looked_at[0]).all()),
        auc=auc(scores, success),
        auc_interval=auc_interval(scores, success),
        best=cross_validate(scores, success, fold) if two_sided else None,
        own=own,
        rank_load=load,
        rank_motion=spearman(scores[known], -motion[known]),
    )


def holm(p_values: Sequence[float | None]) -> list[float | None]:
    """p-values with Holm's correction, in their order; None stays None.

    S. Holm: A simple sequentially rejective multiple test procedure, 1979.
    """
    known = sorted((p, k) for k, p in enumerate(p_values) if p is not None)
    found: list[float | None] = [None] * len(p_values)
    largest = 0.0
    for place, (p, k) in enumerate(known):
        largest = max(largest, min(1.0, p * (len(known) - place)))
        found[k] = largest
    return found
