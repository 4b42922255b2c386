"""Presets of ``sdh-sim lift``: the paper's study with its shares of outcomes, and a fast one."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sdh_sim.errors import SettingsError
from sdh_sim.records import NO_TRUTH, read_rows, read_table, write_rows
from sdh_sim.runs import RunFolder, columns_of_run

# Grasps of each kind in section IV-B, half stable and half not: 584 in all.
PAPER_SHARES = {"box": 67, "oval_bottle": 85, "spray_bottle": 71, "cylindrical_bottle": 69}
# Fingertip grasps, judged by the fingertips' pads, as in the paper.
PAPER_SETTINGS: Mapping[str, Any] = {"grasps": "precision", "pads": "distal"}
FAST_SETTINGS: Mapping[str, Any] = {"timestep": 0.004}
FIRST = 150  # trials of each object in the first round
MARGIN = 1.1  # on what the counts so far say is needed
MOST = 3000  # trials of each object; a share that this does not fill is out of reach
_OUTCOME = ("object", "success", "failure")


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


def mark_surplus(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Rows in the order of trials, ``surplus`` set on those beyond their share.

    Trials without an outcome are no surplus: a comparison counts them as what they are.
    """
    taken: Counter[tuple[str, bool]] = Counter()
    marked = []
    for row in sorted(rows, key=lambda r: r["trial"]):
        kind = row["object"], row["success"]
        truth = row["failure"] not in NO_TRUTH
        taken[kind] += truth
        beyond = truth and taken[kind] > PAPER_SHARES.get(row["object"], 0)
        marked.append({**row, "surplus": beyond})
    return marked


def fill_shares(
    folder: RunFolder,
    resume: bool,
    run_round: Callable[[int, bool], object],
    on_round: Callable[[Mapping[str, Share], int], object],
) -> dict[str, Share]:
    """Run rounds of more and more trials until the paper's shares are full; mark the surplus.

    Args:
        folder: of the run.
        resume: whether to continue the run that the folder may hold.
        run_round: brings the run to so many trials of each object; its second argument says
            whether to continue what the folder holds.
        on_round: called before every further round with the shares so far and its trials.

    Returns:
        the shares found; not all are full where that takes more than ``MOST`` trials.
    """
    trials = FIRST
    if resume and folder.holds_run():
        trials = max(trials, folder.read_plan().trials)
    while True:
        run_round(trials, resume)
        found = shares(read_table(folder.table, _OUTCOME).to_pylist())
        needed = trials_needed(found, trials)
        if needed == trials:
            break
        on_round(found, needed)
        trials, resume = needed, True
    added = columns_of_run(folder.read_plan().settings)
    write_rows(mark_surplus(read_rows(folder.table)), folder.table, added)
    return found


def check_full(found: Mapping[str, Share]) -> None:
    """Raise SettingsError where a share of the paper is not full."""
    short = [name for name, share in found.items() if not share.full]
    if short:
        raise SettingsError(
            f"preset: {', '.join(short)} cannot fill the paper's share in {MOST} trials; "
            "all that ran is kept; try other settings"
        )
