"""Which bound fits which device: q* against the load held, on a one-motor jaw and on the SDH-2.

    python -m experiments.devices --trials 100 --out devices

The same objects on both. On independent motors contacts are bounded each by itself (L∞), on a
device with one motor by their sum (L1); what the motors can do through their transmission
(capability) is asked on both. Every grasp, held or not, is loaded by one rule: from the snapshot,
the table taken away, with a weight that grows from nothing, until the object has moved 10 mm or
10°. Medians count every grasp: a ratio is 0 where q* is, infinite where the grasp bears nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least, fail
from sdh_sim.analysis.comparison import Comparison, compare_scores, name_of
from sdh_sim.analysis.load_agreement import (
    RatioSummary,
    load_ratios,
    spearman,
    summarise_ratios,
)
from sdh_sim.atomic_files import write_atomic
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import Diverged
from sdh_sim.metrics import METRICS, evaluate
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.report.figure_style import colour_of, save, style
from sdh_sim.runs.plan import trial_seed
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.sensing.perceived_grasp import gravity_task
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, classify

BOUNDS = ("q_linf", "q_l1", "q_capability", "q_whole_hand")
# With this force on its motor, about half of the jaw's grasps hold, as on the SDH-2.
DEVICES = {
    "schunk_sdh2": TrialSettings("box"),
    "parallel_jaw": TrialSettings("box", hand="parallel_jaw", torque_limit=(40.0,)),
}
PADS_ALONE = 0.99  # of the force on the object, from which on nothing else counts as touching
EDGE = 3.0  # of the figure: powers of two of the ratio
NAMES = {"schunk_sdh2": "SDH-2, seven motors", "parallel_jaw": "parallel jaw, one motor"}


@dataclass(frozen=True)
class Seen:
    """One trial.

    Attributes:
        device: key of DEVICES.
        held: whether the grasp held in the lift.
        loads: predicted by each bound, and held in simulation, in weights (bounds + 1,).
        known_com: predicted where the centre of mass is known, not within TASK_RADIUS (bounds,).
        capped: the largest load was held.
        object: name of the object.
        seed: of the trial.
        sensed: share of the hand's force on the object that the pads felt, at the snapshot.
    """

    device: str
    held: bool
    loads: np.ndarray
    capped: bool
    object: str = ""
    seed: int = 0
    sensed: float = 1.0
    known_com: np.ndarray = field(default_factory=lambda: np.full(len(BOUNDS), np.nan))


@dataclass(frozen=True)
class Job:
    """A trial to run."""

    device: str
    settings: TrialSettings
    seed: int


def observe(job: Job) -> Seen | None:
    """Run one grasp; None where nothing was touched, or the simulation diverged."""
    trial = Trial(job.settings, job.seed)
    try:
        trial.acquire()
        if not trial.touched:
            return None
        trial.snapshot()
        held = classify(trial.lift()) == "none"
        load = trial.load()
    except Diverged:
        return None
    assert trial.prediction is not None
    predicted = [trial.prediction.values[bound] for bound in BOUNDS]
    row = trial.row
    assert row.sensed_force_n is not None
    assert row.unsensed_force_n is not None
    share = row.sensed_force_n / (row.sensed_force_n + row.unsensed_force_n)
    loads = np.array([*predicted, load.load])
    name = job.settings.object
    known_com = with_known_com(trial.prediction.grasp)
    return Seen(job.device, held, loads, load.capped, name, job.seed, share, known_com)


def with_known_com(grasp: PerceivedGrasp) -> np.ndarray:
    """Every bound on a task without the uncertainty of the centre of mass (bounds,)."""
    exact = replace(grasp, task=gravity_task(grasp.snapshot, grasp.obj, radius=0.0))
    values = evaluate(exact, {bound: METRICS[bound] for bound in BOUNDS})
    return np.array([values[bound] for bound in BOUNDS])


@dataclass(frozen=True)
class Finding:
    """One bound on one device.

    Attributes:
        device: key of DEVICES.
        bound: member of BOUNDS.
        comparison: with the outcomes of the lift.
        ratios: q*/q_sim of the grasps that gave way (k,), as ``load_ratios`` counts them.
        ratio: their summary; None where no grasp gave way.
        correlation: Spearman's, of q* and q_sim.
        capped: grasps that bore the largest load tried.
    """

    device: str
    bound: str
    comparison: Comparison
    ratios: np.ndarray
    ratio: RatioSummary | None
    correlation: float | None
    capped: int


def findings(seen: Sequence[Seen]) -> list[Finding]:
    """Every bound on every device."""
    found = []
    for device in dict.fromkeys(s.device for s in seen):
        own = [s for s in seen if s.device == device]
        held, capped = (np.array([getattr(s, name) for s in own]) for name in ("held", "capped"))
        loads = np.array([s.loads for s in own])
        for k, bound in enumerate(BOUNDS):
            q, q_sim = np.maximum(np.nan_to_num(loads[:, k]), 0.0), loads[:, -1]
            ratios = load_ratios(q, q_sim, capped)
            found.append(
                Finding(
                    device,
                    bound,
                    compare_scores(q, held, group=device, metric=bound),
                    ratios,
                    summarise_ratios(ratios),
                    spearman(q, q_sim),
                    int(capped.sum()),
                )
            )
    return found


def csv_of(seen: Sequence[Seen]) -> str:
    """A line for every grasp: where it comes from, what was predicted, what it bore."""
    known = [f"{bound}_known_com" for bound in BOUNDS]
    heads = ("device", "object", "seed", "held", *BOUNDS, "q_sim", "capped", "sensed_share", *known)
    lines = [
        (s.device, s.object, s.seed, int(s.held), *s.loads, int(s.capped), s.sensed, *s.known_com)
        for s in seen
    ]
    return "\n".join(",".join(map(str, line)) for line in [heads, *lines]) + "\n"


def table_of(found: Sequence[Finding], title: str) -> Table:
    """A line for every bound on every device."""
    heads = ("device", "bound", "grasps", "q*/q_sim, median", "spread ×", "rank corr.", "AUC",
             "accuracy at 1 %", "TPR %", "FPR %")  # fmt: skip
    table = Table(title=title)
    for head in heads:
        table.add_column(head, justify="left" if head in heads[:2] else "right")
    for f in found:
        c, ratio, median = f.comparison, f.ratio, "-"
        if ratio is not None:
            low, high = ratio.median_interval
            median = f"{ratio.median:.2f} ({low:.2f}–{high:.2f})"
        first = f.bound == BOUNDS[0]
        if first and f is not found[0]:
            table.add_section()
        table.add_row(
            NAMES[f.device] if first else "",
            name_of(f.bound),
            str(c.n) if first else "",
            median,
            "-" if ratio is None else f"{ratio.spread:.2f}",
            "-" if f.correlation is None else f"{f.correlation:.2f}",
            c.area(),
            *(rate.percent for rate in
              (c.accuracy, c.true_positive_rate, c.false_positive_rate)),
        )  # fmt: skip
    return table


def draw(found: Sequence[Finding], stem: Path) -> Path:
    """q*/q_sim of every grasp, bound by bound, the devices side by side."""
    import matplotlib.pyplot as plt

    devices = list(dict.fromkeys(f.device for f in found))
    with style():
        figure, panels = plt.subplots(
            1, len(devices), figsize=(7.2, 3.0), sharey=True, layout="constrained"
        )
        for axes, device in zip(np.atleast_1d(panels), devices, strict=True):
            own = [f for f in found if f.device == device]
            for place, f in enumerate(own):
                # What is beyond the axis stands at its edge.
                with np.errstate(divide="ignore"):
                    ratios = np.clip(np.log2(f.ratios), -EDGE, EDGE)
                jitter = np.random.default_rng(place).uniform(-0.18, 0.18, len(ratios))
                axes.plot(place + jitter, ratios, ".", ms=2.5, alpha=0.35,
                          color=colour_of(f.bound))  # fmt: skip
                if f.ratio is not None:
                    median = np.clip(f.ratio.median, 2.0**-EDGE, 2.0**EDGE)
                    axes.plot([place - 0.3, place + 0.3], [np.log2(median)] * 2, lw=2.2,
                              color=colour_of(f.bound))  # fmt: skip
            axes.axhline(0.0, lw=0.8, color="0.4", zorder=0)
            labels = [name_of(f.bound).removeprefix("q* ").replace(" ", "\n") for f in own]
            axes.set_xticks(range(len(own)), labels)
            axes.set_title(NAMES[device])
            axes.set_ylim(-EDGE - 0.2, EDGE + 0.2)
            axes.set_yticks(range(-3, 4), ["≤ 1/8", "1/4", "1/2", "1", "2", "4", "≥ 8"])
        np.atleast_1d(panels)[0].set_ylabel("predicted over simulated load, q*/q_sim")
        _, png = save(figure, stem)
        plt.close(figure)
    return png


def main(argv: list[str] | None = None) -> None:
    """Print the table, draw the figure."""
    parser = Parser(__doc__)
    parser.add_argument("--trials", type=int, default=100, help="for each object [100]")
    parser.add_argument("--seed", type=int, default=31, help="of the run [31]")
    parser.add_argument("--out", type=Path, default=Path("devices"), help="folder of the figure")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=1, seed=0)
    jobs = [
        Job(device, replace(settings, object=name), trial_seed(args.seed, name, index))
        for device, settings in DEVICES.items()
        for name in PAPER_ORDER
        for index in range(args.trials)
    ]
    seen = [s for s in run_all(observe, jobs, "grasps") if s is not None]
    found = findings(seen)
    console = Console(width=140)
    console.print(table_of(found, "every grasp"))
    pads_alone = [s for s in seen if s.sensed > PADS_ALONE]
    if all(any(s.device == device for s in pads_alone) for device in DEVICES):
        heading = f"grasps that nothing but the pads holds ({PADS_ALONE:.0%} of the force)"
        console.print(table_of(findings(pads_alone), heading))
        known = [replace(s, loads=np.append(s.known_com, s.loads[-1])) for s in pads_alone]
        console.print(table_of(findings(known), f"{heading}, the centre of mass known exactly"))
    try:
        args.out.mkdir(parents=True, exist_ok=True)
        write_atomic(args.out / "devices.csv", csv_of(seen).encode())
        print(f"every grasp: {args.out / 'devices.csv'}")
        print(f"figure: {draw(found, args.out / 'devices')}")
    except OSError as error:
        fail(f"cannot write to {args.out}: {error.strerror or error}; choose another --out")


if __name__ == "__main__":
    main()
