"""Presets of ``sdh-sim lift``: the paper's study with its shares of outcomes, and a fast one."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sdh_sim.records.rows import Row
from sdh_sim.records.trial_row import NO_TRUTH

# Grasps of each kind in section IV-B, half stable and half not: 584 in all.
PAPER_SHARES = {"box": 67, "oval_bottle": 85, "spray_bottle": 71, "cylindrical_bottle": 69}
# Fingertip grasps, judged by the fingertips' pads, as in the paper.
PAPER_SETTINGS: Mapping[str, Any] = {"grasps": "precision", "pads": "distal"}
FAST_SETTINGS: Mapping[str, Any] = {"timestep": 0.004}
FIRST = 150  # trials of each object in the first round
MARGIN = 1.1  # on what the counts so far say is needed
MOST = 3000  # trials of each object; a share that this does not fill is out of reach


@dataclass(frozen=True)
class Share:
    """How far an object's share is filled.

    Attributes:
        wanted: grasps of each outcome.
        stable, unstable: grasps found.
    """

    wanted: int
    stable: int
    unstable: int

    @property
    def full(self) -> bool:
        """Both outcomes have what is wanted."""
        return min(self.stable, self.unstable) >= self.wanted


def shares(rows: Iterable[Mapping[str, Any]]) -> dict[str, Share]:
    """How far the paper's shares are filled by trials with ``object``, ``success``, ``failure``."""
    count: Counter[tuple[str, bool]] = Counter(
        (row["object"], row["success"]) for row in rows if row["failure"] not in NO_TRUTH
    )
    return {
        name: Share(wanted, count[name, True], count[name, False])
        for name, wanted in PAPER_SHARES.items()
    }


def trials_needed(found: Mapping[str, Share], trials: int) -> int:
    """Trials of each object that should fill every share; ``trials`` where all are full.

    Args:
        found: what ``trials`` trials of each object gave.
        trials: number of trials so far.
    """
    needed = trials
    for share in found.values():
        if not share.full:
            rate = (min(share.stable, share.unstable) + 1) / trials
            needed = max(needed, trials + 1, math.ceil(MARGIN * share.wanted / rate))
    return min(needed, max(2 * trials, trials + 1), MOST)


def mark_surplus(rows: Iterable[Row]) -> list[Row]:
    """Rows in the order of trials, ``surplus`` set on those beyond their share."""
    taken: Counter[tuple[str, bool]] = Counter()
    marked = []
    for row in sorted(rows, key=lambda r: r["trial"]):
        kind = row["object"], row["success"]
        truth = row["failure"] not in NO_TRUTH
        taken[kind] += truth
        beyond = not truth or taken[kind] > PAPER_SHARES.get(row["object"], 0)
        marked.append({**row, "surplus": beyond})
    return marked
