"""What the table of grasps says: labels that change, and bounds against the loads borne."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from experiments.drives.grasps import BOUNDS, DRIVES, Seen, loads
from sdh_sim.analysis.comparison import Comparison, compare_scores, name_of
from sdh_sim.analysis.load_agreement import RatioSummary, load_ratios, summarise_ratios
from sdh_sim.analysis.paired_metrics import mcnemar
from sdh_sim.analysis.proportion import Proportion

PADS_ALONE = 0.99  # of the force on the object, from which on nothing else counts as touching
DIVERGED = "unstable_simulation"


@dataclass(frozen=True)
class LabelChange:
    """Labels with one drive against those with motors that yield.

    Attributes:
        drive: the other drive.
        held: share of grasps that hold with it.
        gained, lost: grasps that hold with it alone, and with motors that yield alone.
        changed: their share.
        p_value: McNemar's exact test.
        force: sum of normal forces at the snapshot over that with motors that yield, median.
        load: the same of the load borne; infinite and undefined ratios are left out.
    """

    drive: str
    held: Proportion
    gained: int
    lost: int
    changed: Proportion
    p_value: float
    force: float
    load: float


def by_drive(seen: Sequence[Seen]) -> dict[str, list[Seen]]:
    """Grasps that diverged with no drive, for each drive in the same order."""
    bad = {(s.object, s.seed) for s in seen if s.failure == DIVERGED}
    usable = [s for s in seen if (s.object, s.seed) not in bad]
    return {drive: [s for s in usable if s.drive == drive] for drive in DRIVES}


def label_changes(seen: Sequence[Seen]) -> list[LabelChange]:
    """A line for each drive, against ``yield``."""
    drives, found = by_drive(seen), []
    usual = drives["yield"]
    first = np.array([s.held for s in usual], dtype=bool)
    for drive in DRIVES:
        own = np.array([s.held for s in drives[drive]], dtype=bool)
        gained, lost = int((own & ~first).sum()), int((first & ~own).sum())
        pairs = list(zip(drives[drive], usual, strict=True))
        force = [(a.sensed_n + a.unsensed_n) / (b.sensed_n + b.unsensed_n) for a, b in pairs]
        load = [a.q_sim / b.q_sim for a, b in pairs if b.q_sim > 0.0 and not b.capped]
        found.append(
            LabelChange(
                drive, Proportion(int(own.sum()), len(own)), gained, lost,
                Proportion(gained + lost, len(own)), mcnemar(gained, lost),
                float(np.nanmedian(force)), float(np.median(load)) if load else float("nan"),
            )
        )  # fmt: skip
    return found


def label_table(seen: Sequence[Seen]) -> Table:
    """Labels by drive."""
    table = Table(title="labels by drive, against motors that yield")
    for head in ("drive", "held %", "gained", "lost", "changed %", "McNemar p",
                 "force, median ratio", "load borne, median ratio"):  # fmt: skip
        table.add_column(head, justify="left" if head == "drive" else "right")
    for line in label_changes(seen):
        table.add_row(
            line.drive, line.held.percent, str(line.gained), str(line.lost), line.changed.percent,
            f"{line.p_value:.2g}", f"{line.force:.2f}", f"{line.load:.2f}",
        )  # fmt: skip
    return table


@dataclass(frozen=True)
class BoundFit:
    """One bound with one drive.

    Attributes:
        drive, bound: which.
        comparison: of q* with the outcomes of the lift.
        ratio: of q*/q_sim, the grasps that bore the largest load left out; None where none is left.
        below: share of all grasps with q* at most what was borne.
        n, capped: grasps, and those that bore the largest load.
    """

    drive: str
    bound: str
    comparison: Comparison
    ratio: RatioSummary | None
    below: Proportion
    n: int
    capped: int


def bound_fits(seen: Sequence[Seen], known_com: bool) -> list[BoundFit]:
    """Every bound with every drive.

    Args:
        seen: the grasps.
        known_com: only those that pads alone hold with all drives, the centre of mass known.
    """
    drives = {d: [s for s in own if s.q_sim == s.q_sim] for d, own in by_drive(seen).items()}
    if known_com:
        others = {
            (s.object, s.seed)
            for own in drives.values()
            for s in own
            if not s.sensed_share > PADS_ALONE
        }
        drives = {
            d: [s for s in own if (s.object, s.seed) not in others] for d, own in drives.items()
        }
    found = []
    for drive, own in drives.items():
        held = np.array([s.held for s in own], dtype=bool)
        for bound in BOUNDS if own else ():
            q, q_sim, capped = loads(own, bound, known_com)
            ratios = load_ratios(q, q_sim, capped)
            found.append(
                BoundFit(
                    drive, bound, compare_scores(q, held, group=drive, metric=bound),
                    summarise_ratios(ratios),
                    Proportion(int((q <= q_sim).sum()), len(q)), len(own), int(capped.sum()),
                )
            )  # fmt: skip
    return found


def bound_table(seen: Sequence[Seen], known_com: bool) -> Table:
    """Bounds against loads borne, by drive."""
    what = "pads alone with every drive, the centre of mass known" if known_com else "every grasp"
    table = Table(title=f"bounds by drive: {what}")
    heads = ("drive", "bound", "grasps", "largest load borne", "q*/q_sim, median", "spread ×",
             "q* ≤ q_sim %", "AUC", "accuracy at 1 %")  # fmt: skip
    for head in heads:
        table.add_column(head, justify="left" if head in heads[:2] else "right")
    for fit in bound_fits(seen, known_com):
        first, ratio, median = fit.bound == BOUNDS[0], fit.ratio, "-"
        if ratio is not None:
            low, high = ratio.median_interval
            median = f"{ratio.median:.2f} ({low:.2f}–{high:.2f})"
        if first and fit.drive != DRIVES[0]:
            table.add_section()
        table.add_row(
            fit.drive if first else "", name_of(fit.bound), str(fit.n) if first else "",
            str(fit.capped) if first else "", median,
            "-" if ratio is None else f"{ratio.spread:.2f}", fit.below.percent,
            fit.comparison.area(), fit.comparison.accuracy.percent,
        )  # fmt: skip
    return table
