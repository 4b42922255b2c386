"""The figure of the study: q*/q_sim of every grasp, bound by bound, the drives side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.drives.findings import by_drive
from experiments.drives.grasps import BOUNDS, DRIVES, Seen, loads
from sdh_sim.analysis.comparison import name_of
from sdh_sim.analysis.load_agreement import load_ratios
from sdh_sim.report.figure_style import colour_of, save, style

EDGE = 4.0  # of the figure: powers of two of the ratio
NAMES = {"yield": "yield", "hold": "hold", "lock": "lock"}


def draw(seen: Sequence[Seen], stem: Path) -> Path:
    """Draw the figure as SVG and PNG; returns the PNG."""
    import matplotlib.pyplot as plt

    with style():
        figure, panels = plt.subplots(
            1, len(DRIVES), figsize=(7.2, 3.2), sharey=True, layout="constrained"
        )
        for axes, (drive, all_seen) in zip(panels, by_drive(seen).items(), strict=True):
            own = [s for s in all_seen if s.q_sim == s.q_sim]
            for place, bound in enumerate(BOUNDS):
                q, q_sim, capped = loads(own, bound, False)
                ratios = load_ratios(q, q_sim, capped)
                with np.errstate(divide="ignore"):
                    heights = np.clip(np.log2(ratios), -EDGE, EDGE)
                jitter = np.random.default_rng(place).uniform(-0.2, 0.2, len(heights))
                axes.plot(place + jitter, heights, ".", ms=2.5, alpha=0.35, color=colour_of(bound))
                if len(heights):
                    median = float(np.quantile(heights, 0.5, method="nearest"))
                    axes.plot([place - 0.32, place + 0.32], [median] * 2, lw=2.2,
                              color=colour_of(bound))  # fmt: skip
            axes.axhline(0.0, lw=0.8, color="0.4", zorder=0)
            labels = [name_of(b).removeprefix("q* ").replace(" ", "\n") for b in BOUNDS]
            axes.set_xticks(range(len(BOUNDS)), labels, fontsize=7.0)
            capped_n = sum(bool(s.capped) for s in own)
            axes.set_title(f"{NAMES[drive]} (n = {len(own) - capped_n})")
            axes.set_ylim(-EDGE - 0.25, EDGE + 0.25)
            ticks = range(-int(EDGE), int(EDGE) + 1, 2)
            axes.set_yticks(list(ticks), ["≤ 1/16", "1/4", "1", "4", "≥ 16"])
        panels[0].set_ylabel("predicted over simulated load, q*/q_sim")
        _, png = save(figure, stem)
        plt.close(figure)
    return png
