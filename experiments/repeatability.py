"""How sure the labels are: the same grasps with half the time step, and with small noise."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.parallel import run_all
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.rate import Rate
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial


@dataclass(frozen=True)
class Variant:
    """A change of the trial that should not change its label."""

    name: str
    timestep: float


VARIANTS = (
    Variant("half the time step, 1 ms", 0.001),
    Variant("twice the time step, 4 ms (fast)", 0.004),
)


@dataclass(frozen=True)
class Pair:
    """Labels and motion [mm] of one grasp at the default and in every variant."""

    object: str
    held: bool
    moved: float
    others: tuple[tuple[bool, float], ...]


def pair(job: tuple[str, int]) -> Pair:
    """Run one grasp in all variants."""
    name, seed = job
    rows = [
        run_trial(replace(TrialSettings(object=name), timestep=step), seed).row
        for step in (TrialSettings(object=name).timestep, *(v.timestep for v in VARIANTS))
    ]
    labels = [(bool(r["success"]), float(r.get("displacement_mm", np.nan))) for r in rows]
    return Pair(name, *labels[0], tuple(labels[1:]))


def noisy(job: tuple[str, int, int]) -> tuple[str, bool, float]:
    """Object, label and probability of success of one grasp."""
    name, seed, repeats = job
    row = run_trial(TrialSettings(object=name, repeats=repeats), seed).row
    return name, bool(row["success"]), float(row["success_probability"] or 0.0)


def main(argv: list[str] | None = None) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--grasps", type=int, default=400, help="for the time step [400]")
    parser.add_argument("--noisy", type=int, default=40, help="grasps to repeat with noise [40]")
    parser.add_argument("--repeats", type=int, default=10, help="copies of each [10]")
    parser.add_argument("--seed", type=int, default=1000, help="first seed [1000]")
    args = parser.parse_args(argv)
    if min(args.grasps, args.noisy, args.repeats) < 0 or args.seed < 0:
        parser.error("--grasps, --noisy, --repeats and --seed must not be negative")
    console = Console(width=110)
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4) for k in range(args.grasps)]
    if jobs:
        console.print(step_table(run_all(pair, jobs, "time steps"), args.seed))
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4, args.repeats) for k in range(args.noisy)]
    if jobs and args.repeats:
        console.print(noise_table(run_all(noisy, jobs, "copies"), args.repeats, args.seed))


def step_table(pairs: list[Pair], seed: int) -> Table:
    """Flipped labels and changed motion for each variant."""
    table = Table(title=f"{len(pairs)} grasps, seeds from {seed}, default step 2 ms")
    for heading in ("variant", "labels flipped", "95 % interval", "motion differs, median mm",
                    "90 % below mm"):  # fmt: skip
        table.add_column(heading, justify="left" if heading == "variant" else "right")
    for k, variant in enumerate(VARIANTS):
        flips = Rate(sum(p.held != p.others[k][0] for p in pairs), len(pairs))
        low, high = flips.interval or (0.0, 1.0)
        apart = [abs(p.moved - p.others[k][1]) for p in pairs if p.held and p.others[k][0]]
        table.add_row(
            variant.name,
            f"{flips.k} of {flips.n}",
            f"{100 * low:.1f} to {100 * high:.1f} %",
            f"{np.median(apart):.2f}" if apart else "-",
            f"{np.quantile(apart, 0.9):.2f}" if apart else "-",
        )
    return table


def noise_table(results: list[tuple[str, bool, float]], repeats: int, seed: int) -> Table:
    """How often copies with noise agree with the label of the grasp itself."""
    default = TrialSettings(object=PAPER_ORDER[0])
    table = Table(
        title=f"{repeats} copies of each grasp: hand {default.repeat_position * 1e3:g} mm, roll "
        f"{default.repeat_angle:g} rad, friction {100 * default.repeat_friction:g} %; "
        f"seeds from {seed}"
    )
    for heading in ("object", "grasps", "held", "copies that agree", "all agree", "toss-ups"):
        table.add_column(heading, justify="left" if heading == "object" else "right")
    for name in (*PAPER_ORDER, "all"):
        group = [(held, p) for o, held, p in results if name in (o, "all")]
        if not group:
            continue
        agree = np.array([p if held else 1.0 - p for held, p in group])
        table.add_row(
            name,
            str(len(group)),
            str(sum(held for held, _ in group)),
            f"{100 * agree.mean():.0f} %",
            str(int((agree == 1.0).sum())),
            str(int(((agree > 0.2) & (agree < 0.8)).sum())),
        )
    return table


if __name__ == "__main__":
    main()
