"""How fast trials run: simulated seconds per second, the time inside MuJoCo, and two workers."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import mujoco
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least
from sdh_sim.campaign import run_campaign
from sdh_sim.campaign.paper_preset import FAST_SETTINGS
from sdh_sim.cell import scene_builder
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.runs import RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial


@dataclass
class Stopwatch:
    """Sums the time inside a wrapped function and counts its calls."""

    seconds: float = 0.0
    calls: int = 0

    def wrap(self, function):
        """The function with its time taken."""

        def timed(*args, **kwargs):
            start = time.perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                self.seconds += time.perf_counter() - start
                self.calls += 1

        return timed


def one_core(settings: TrialSettings, trials: int, seed: int) -> tuple[float, float, float, int]:
    """Simulated time [s], wall time [s], time inside mj_step [s] and scene compilations."""
    steps, builds = Stopwatch(), Stopwatch()
    with patch.object(scene_builder, "build_scene", builds.wrap(scene_builder.build_scene)):
        run_trial(settings, seed - 1)  # compiles the scene and loads compiled metrics
        with patch.object(mujoco, "mj_step", steps.wrap(mujoco.mj_step)):
            start = time.perf_counter()
            simulated = sum(run_trial(settings, seed + k).sim_seconds for k in range(trials))
            wall = time.perf_counter() - start
    return simulated, wall, steps.seconds, builds.calls


def campaign_seconds(settings: TrialSettings, workers: int, trials: int, seed: int) -> float:
    """Wall time of a campaign over all objects, between its first finished trial and its last.

    Starting the processes is left out: it is paid once however long the run.
    """
    plan = RunPlan(PAPER_ORDER, settings, trials, seed)
    stamps: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        run_campaign(
            plan, Path(folder) / "run", workers,
            on_trial=lambda row: stamps.append(time.perf_counter()),
        )  # fmt: skip
    return (stamps[-1] - stamps[0]) / (len(stamps) - 1) * len(stamps)


def main(argv: list[str] | None = None) -> None:
    """Print the tables."""
    parser = Parser(__doc__)
    parser.add_argument("--trials", type=int, default=10, help="trials per object [10]")
    parser.add_argument("--seed", type=int, default=0, help="first seed [0]")
    parser.add_argument("--preset", choices=("fast",), help="as of sdh-sim lift")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=1, seed=0)
    settings = TrialSettings(
        object=PAPER_ORDER[0], **(FAST_SETTINGS if args.preset == "fast" else {})
    )
    console = Console()
    kind = f"{args.preset} preset, " if args.preset else ""
    table = Table(title=f"{kind}one core, {args.trials} trials each, seed {args.seed}")
    for heading in ("object", "simulated s", "wall s", "× real time", "in mj_step", "compiled"):
        table.add_column(heading, justify="left" if heading == "object" else "right")
    sums = [0.0, 0.0, 0.0]
    for name in PAPER_ORDER:
        simulated, wall, stepping, compiled = one_core(
            replace(settings, object=name), args.trials, args.seed + 1
        )
        sums = [a + b for a, b in zip(sums, (simulated, wall, stepping), strict=True)]
        table.add_row(*_cells(name, simulated, wall, stepping), str(compiled))
    table.add_row(*_cells("all", *sums), "")
    console.print(table)
    one, two = (campaign_seconds(settings, workers, args.trials, args.seed) for workers in (1, 2))
    count = 4 * args.trials
    console.print(
        f"campaign of {count} trials: {60 * count / one:.0f} trials a minute with 1 worker, "
        f"{60 * count / two:.0f} with 2 ({one / two:.2f} times)"
    )


def _cells(name: str, simulated: float, wall: float, stepping: float) -> tuple[str, ...]:
    return (
        name,
        f"{simulated:.1f}",
        f"{wall:.2f}",
        f"{simulated / wall:.1f}",
        f"{100 * stepping / wall:.0f} %",
    )


if __name__ == "__main__":
    main()
