"""How certain the labels are: the same grasps with other time steps, moved a little, with noise.

What moving the hand by 10 µm changes is how far a label can be known at all: a time step that
changes no more is fine enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cell import scene_of
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, run_trial
from sdh_sim.trial.repeats import perturbed

CLOSE = 1.0  # motions nearer than this are one motion, whatever their labels [mm, deg]


@dataclass(frozen=True)
class Variant:
    """A change of the trial that should not change its label.

    Attributes:
        name: for the table.
        timestep: [s].
        aside: standard deviation of the hand's place along each axis [m].
    """

    name: str
    timestep: float = TrialSettings.timestep
    aside: float = 0.0


VARIANTS = (
    Variant("half the time step, 1 ms", timestep=0.001),
    Variant("twice the time step, 4 ms (fast)", timestep=0.004),
    Variant("the hand 10 µm aside", aside=1e-5),
    Variant("the hand 0.1 mm aside", aside=1e-4),
)


class Label(NamedTuple):
    """Label of a trial and how far the object moved and turned in the hand [mm, deg]."""

    held: bool
    moved: float
    turned: float

    def near(self, other: Label) -> bool:
        """Whether two motions are the same within CLOSE."""
        return abs(self.moved - other.moved) < CLOSE and abs(self.turned - other.turned) < CLOSE


@dataclass(frozen=True)
class Pair:
    """Label of one grasp at the default and in every variant."""

    usual: Label
    others: tuple[Label, ...]


def pair(job: tuple[str, int]) -> Pair:
    """Run one grasp in all variants."""
    name, seed = job
    usual = Trial(TrialSettings(object=name), seed)
    return Pair(_label(usual), tuple(_label(_variant(usual, v)) for v in VARIANTS))


def _variant(usual: Trial, variant: Variant) -> Trial:
    motion = usual.motion
    if variant.aside:
        noise = replace(usual.settings, repeat_position=variant.aside, repeat_angle=0.0)
        rng = np.random.default_rng((usual.seed, 1))
        motion = perturbed(scene_of(noise), motion, rng) or motion
    settings = replace(usual.settings, timestep=variant.timestep)
    return Trial(settings, usual.seed, motion=motion)


def _label(trial: Trial) -> Label:
    failure, motion = trial.grasp_and_lift()
    return Label(failure == "none", motion.displacement_mm, motion.rotation_deg)


def noisy(job: tuple[str, int, int]) -> tuple[str, bool, float]:
    """Object, label and probability of success of one grasp."""
    name, seed, repeats = job
    row = run_trial(TrialSettings(object=name, repeats=repeats), seed).row
    return name, bool(row["success"]), float(row["success_probability"] or 0.0)


def main(argv: list[str] | None = None) -> None:
    """Print both tables."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=400, help="for the time step [400]")
    parser.add_argument("--noisy", type=int, default=40, help="grasps to repeat with noise [40]")
    parser.add_argument("--repeats", type=int, default=10, help="copies of each [10]")
    parser.add_argument("--seed", type=int, default=1000, help="first seed [1000]")
    args = parser.parse_args(argv)
    at_least(parser, args, grasps=0, noisy=0, repeats=0, seed=0)
    console = Console(width=110)
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4) for k in range(args.grasps)]
    if jobs:
        console.print(step_table(run_all(pair, jobs, "time steps"), args.seed))
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4, args.repeats) for k in range(args.noisy)]
    if jobs and args.repeats:
        console.print(noise_table(run_all(noisy, jobs, "copies"), args.repeats, args.seed))


def step_table(pairs: list[Pair], seed: int) -> Table:
    """Flipped labels and changed motion for each variant."""
    table = Table(
        title=f"{len(pairs)} grasps, seeds from {seed}, default step 2 ms",
        caption=f"moved alike: within {CLOSE:g} mm and {CLOSE:g}°, on either side of a limit",
    )
    for heading in ("variant", "labels flipped", "95 % interval", "of them moved alike",
                    "held: motion differs, median mm", "90 % below mm"):  # fmt: skip
        table.add_column(heading, justify="left" if heading == "variant" else "right")
    for k, variant in enumerate(VARIANTS):
        both = [(p.usual, p.others[k]) for p in pairs]
        flipped = [(a, b) for a, b in both if a.held != b.held]
        flips = Proportion(len(flipped), len(pairs))
        low, high = flips.interval or (0.0, 1.0)
        apart = [abs(a.moved - b.moved) for a, b in both if a.held and b.held]
        table.add_row(
            variant.name,
            f"{flips.k} of {flips.n}",
            f"{100 * low:.1f} to {100 * high:.1f} %",
            str(sum(a.near(b) for a, b in flipped)),
            f"{np.median(apart):.3f}" if apart else "-",
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
