"""What each imperfection of the tactile arrays does to the prediction, on the same grasps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least
from experiments.parallel import run_all
from sdh_sim.analysis.comparison import auc
from sdh_sim.metrics import predict
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.sensing import SensorModel, TactileFrames, TactileSensor, take_snapshot
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, classify

DSA = SensorModel()
PERFECT = SensorModel(
    dead_zone=0.0, clip=4095.0, crosstalk=0.0, creep_share=0.0, noise=0.0, gain_spread=0.0
)
VARIANTS: dict[str, SensorModel | None] = {
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


@dataclass(frozen=True)
class Seen:
    """One grasp: label, and per variant q* under both bounds and the number of contacts."""

    held: bool
    q: np.ndarray
    contacts: np.ndarray


def observe(job: tuple[str, int]) -> Seen:
    """Run one grasp and predict from what each sensor reads."""
    name, seed = job
    settings = TrialSettings(object=name)
    sensors = [
        TactileSensor(model, np.random.default_rng((seed, 1))) for model in VARIANTS.values()
    ]
    trial = Trial(settings, seed, observers=[TactileFrames(sensor) for sensor in sensors])
    trial.acquire()
    snapshot = take_snapshot(trial.simulation)
    found = []
    for sensor in sensors:
        seen = replace(snapshot, tactile=trial.scene.hand.by_kind(sensor.read()))
        said = predict(seen, trial.scene.obj, settings.torque_limit, settings.pads)
        found.append((said.q_linf, said.q_l1, len(said.contacts)))
    held = trial.touched and classify(trial.lift()) == "none"
    values = np.array(found)
    return Seen(held, values[:, :2], values[:, 2])


def area_text(scores: np.ndarray, held: np.ndarray) -> str:
    """The area under the ROC curve, or a dash where all outcomes are alike."""
    area = auc(scores, held)
    return "–" if area is None else f"{area:.3f}"


def main(argv: list[str] | None = None) -> None:
    """Print the table."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=200, help="grasps, all objects [200]")
    parser.add_argument("--seed", type=int, default=3000, help="first seed [3000]")
    args = parser.parse_args(argv)
    at_least(parser, args, grasps=4, seed=0)
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4) for k in range(args.grasps)]
    seen = run_all(observe, jobs, "grasps")
    held = np.array([s.held for s in seen])
    q = np.array([s.q for s in seen])
    contacts = np.array([s.contacts for s in seen])
    table = Table(title=f"{len(seen)} grasps, {held.sum()} held, seeds from {args.seed}")
    for heading in ("sensor", "AUC L∞", "AUC L1", "accuracy L∞ %", "accuracy L1 %",
                    "q* moved, median %", "90 % below %", "contacts differ"):  # fmt: skip
        table.add_column(heading, justify="left" if heading == "sensor" else "right")
    for k, name in enumerate(VARIANTS):
        both = (q[:, 0, 0] > 0) & (q[:, k, 0] > 0)
        moved = 100 * np.abs(q[both, k, 0] / q[both, 0, 0] - 1)
        table.add_row(
            name,
            *(area_text(q[:, k, b], held) for b in (0, 1)),
            *(f"{100 * np.mean((q[:, k, b] > 1) == held):.1f}" for b in (0, 1)),
            f"{np.median(moved):.1f}",
            f"{np.quantile(moved, 0.9):.1f}",
            str(int((contacts[:, k] != contacts[:, 0]).sum())),
        )
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
