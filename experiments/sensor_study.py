"""What each imperfection of the tactile arrays does to the prediction, on the same grasps.

Crosstalk lights taxels that touch nothing. The last rows show what the threshold on a pad's
readings (``--taxel-threshold``) makes of that: with 0 every reading counts, as in the paper.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least
from sdh_sim.analysis.comparison import auc
from sdh_sim.campaign.paper_preset import PAPER_SETTINGS
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.metrics import predict
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.sensing import SensorModel, TactileFrames, TactileSensor, take_snapshot
from sdh_sim.settings import TAXEL_THRESHOLD, TrialSettings
from sdh_sim.trial import Trial, classify

DSA = SensorModel()
PERFECT = SensorModel(
    dead_zone=0.0, clip=4095.0, crosstalk=0.0, creep_share=0.0, noise=0.0, gain_spread=0.0
)
IMPERFECTIONS: dict[str, SensorModel | None] = {
    "ideal": None,
    "12 bit alone": PERFECT,
    "+ dead zone": replace(PERFECT, dead_zone=DSA.dead_zone),
    "+ dead zone of 8 kPa": replace(PERFECT, dead_zone=8.0),
    "+ clip": replace(PERFECT, clip=DSA.clip),
    "+ crosstalk": replace(PERFECT, crosstalk=DSA.crosstalk),
    "+ creep": replace(PERFECT, creep_share=DSA.creep_share),
    "+ noise": replace(PERFECT, noise=DSA.noise),
    "+ gain spread": replace(PERFECT, gain_spread=DSA.gain_spread),
    "dsa: all of these": DSA,
    "dsa, 5 % dead taxels": replace(DSA, dead_share=0.05),
    "dsa, 20 % dead taxels": replace(DSA, dead_share=0.2),
}
VARIANTS: dict[str, tuple[SensorModel | None, float]] = {
    "every touched taxel": (None, 0.0),
    **{name: (model, TAXEL_THRESHOLD) for name, model in IMPERFECTIONS.items()},
    "+ crosstalk, threshold 0": (IMPERFECTIONS["+ crosstalk"], 0.0),
    **{f"dsa, threshold {share:g}": (DSA, share) for share in (0.0, 0.05, 0.2, 0.35)},
}
"""What the arrays are like, and the threshold that a reading must exceed to count; the first row is
what the others are compared with."""


@dataclass(frozen=True)
class Seen:
    """One grasp: label, and per variant q* under both bounds, numbers of contacts and taxels."""

    held: bool
    q: np.ndarray
    contacts: np.ndarray
    taxels: np.ndarray


def observe(job: tuple[str, int, Mapping[str, Any]]) -> Seen:
    """Run one grasp and predict from what each sensor reads."""
    name, seed, conditions = job
    settings = TrialSettings(object=name, **conditions)
    sensors = [
        TactileSensor(model, np.random.default_rng((seed, 1))) for model, _ in VARIANTS.values()
    ]
    trial = Trial(settings, seed, observers=[TactileFrames(sensor) for sensor in sensors])
    trial.acquire()
    snapshot = take_snapshot(trial.simulation)
    found = []
    for sensor, (_, threshold) in zip(sensors, VARIANTS.values(), strict=True):
        seen = replace(snapshot, tactile=trial.scene.hand.by_kind(sensor.read()))
        limits = settings.torque_limit
        said = predict(seen, trial.scene.obj, limits, settings.pads, threshold=threshold)
        patches = [pad.contact.patch for pad in said.contacts]
        taxels = sum(len(patch) for patch in patches if patch is not None)
        found.append((said.q_linf, said.q_l1, len(said.contacts), taxels))
    held = trial.touched and classify(trial.lift()) == "none"
    values = np.array(found)
    return Seen(held, values[:, :2], values[:, 2], values[:, 3])


def area_text(scores: np.ndarray, held: np.ndarray) -> str:
    """The area under the ROC curve, or a dash where all outcomes are alike."""
    area = auc(scores, held)
    return "–" if area is None else f"{area:.3f}"


def main(argv: list[str] | None = None) -> None:
    """Print the table."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=200, help="grasps, all objects [200]")
    parser.add_argument("--seed", type=int, default=3000, help="first seed [3000]")
    parser.add_argument("--precision", action="store_true",
                        help="fingertip grasps and distal pads, as in the paper")  # fmt: skip
    args = parser.parse_args(argv)
    at_least(parser, args, grasps=4, seed=0)
    conditions = PAPER_SETTINGS if args.precision else {}
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4, conditions) for k in range(args.grasps)]
    seen = run_all(observe, jobs, "grasps")
    held = np.array([s.held for s in seen])
    q = np.array([s.q for s in seen])
    contacts, taxels = np.array([s.contacts for s in seen]), np.array([s.taxels for s in seen])
    table = Table(title=f"{len(seen)} grasps, {held.sum()} held, seeds from {args.seed}")
    for heading in (
        "sensor", "AUC L∞", "AUC L1", "accuracy L∞ %", "accuracy L1 %", "q* higher, median %",
        "moved, 90 % below %", "contacts differ", "taxels",
    ):  # fmt: skip
        table.add_column(heading, justify="left" if heading == "sensor" else "right")
    for k, name in enumerate(VARIANTS):
        both = (q[:, 0, 0] > 0) & (q[:, k, 0] > 0)
        higher = 100 * (q[both, k, 0] / q[both, 0, 0] - 1)
        table.add_row(
            name,
            *(area_text(q[:, k, b], held) for b in (0, 1)),
            *(f"{100 * np.mean((q[:, k, b] > 1) == held):.1f}" for b in (0, 1)),
            f"{np.median(higher):+.1f}",
            f"{np.quantile(np.abs(higher), 0.9):.1f}",
            str(int((contacts[:, k] != contacts[:, 0]).sum())),
            f"{taxels[:, k].mean():.1f}",
        )
    Console(width=132).print(table)


if __name__ == "__main__":
    main()
