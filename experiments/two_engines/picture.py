"""The comparison of two engines as a figure: motions of both, and every bound's area under each."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.two_engines.agreement import Labels, scored
from experiments.two_engines.alignment import FULL
from experiments.two_engines.table import STRAIGHT
from sdh_sim.report.figure_style import save, style
from sdh_sim.trial.outcome import MAX_DISPLACEMENT_MM

KINDS = {"MuJoCo": "o", "Drake": "s", "both": "D"}
LEAST, MOST = 1e-2, 30.0  # of the axes of the motions [mm]


def draw(labels: Labels, stem: Path) -> Path:
    """Draw it as ``stem`` with the endings of the project's figures; the PNG is returned."""
    import matplotlib.pyplot as plt

    pairs = [
        (row, other)
        for row, other in zip(labels.rows, labels.found[FULL], strict=True)
        if other is not None
    ]
    moved = np.array([(a["displacement_mm"], b["displacement_mm"]) for a, b in pairs], dtype=float)
    moved = moved.clip(LEAST, MOST)
    both = zip(labels.found.get(STRAIGHT, []), labels.found[FULL], strict=False)
    motions = [(a["displacement_mm"], b["displacement_mm"]) for a, b in both if a and b]
    straight = np.array(motions, dtype=float).reshape(-1, 2).clip(LEAST, MOST)
    same = np.array([a["success"] == b["success"] for a, b in pairs])
    with style():
        figure, (left, right) = plt.subplots(
            1, 2, figsize=(6.4, 3.2), layout="constrained", width_ratios=(1, 1.2)
        )
        left.loglog(*moved[same].T, "o", ms=3, alpha=0.5, label="same label")
        left.loglog(*straight.T, ".", ms=3, color="C1", alpha=0.6, label="straight lift")
        left.loglog(*moved[~same].T, "x", ms=5, color="C3", label="another label")
        left.plot((LEAST, MOST), (LEAST, MOST), color="0.6", lw=0.8)
        for line in (left.axhline, left.axvline):
            line(MAX_DISPLACEMENT_MM, color="0.6", lw=0.8, ls=":")
        left.set_xlabel("moved in the hand, MuJoCo [mm]")
        left.set_ylabel("moved in the hand, Drake [mm]")
        left.legend(loc="upper left", frameon=False)
        scores = {
            name: kinds for name, kinds in scored(labels).items()
            if kinds["MuJoCo"].metric.startswith("q_") or name == "settling"
        }  # fmt: skip
        for place, kinds in enumerate(scores.values()):
            for step, (kind, mark) in enumerate(KINDS.items()):
                found = kinds[kind]
                if found.auc is None or found.auc_interval is None:
                    continue
                y = place + 0.22 * (step - 1)
                right.plot(found.auc_interval, [y, y], color=f"C{step}", lw=1.4)
                right.plot([found.auc], [y], mark, color=f"C{step}", ms=4)
        right.set_yticks(range(len(scores)), list(scores))
        right.invert_yaxis()
        right.set_xlabel("area under the ROC curve, 95 % interval")
        for step, (kind, mark) in enumerate(KINDS.items()):
            text = "where both agree" if kind == "both" else f"labels of {kind}"
            right.plot([], [], mark, color=f"C{step}", ms=4, label=text)
        right.legend(loc="lower left", frameon=False)
        _, png = save(figure, stem)
        plt.close(figure)
    return png
