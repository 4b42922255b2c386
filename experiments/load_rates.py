"""Whether q_sim depends on how fast the load grows."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import Diverged
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, load_test

SPEEDS = (0.5, 1.0, 2.0, 4.0)


def loads(job: tuple[str, int]) -> list[float] | None:
    """q_sim of one grasp at every speed; None where it holds nothing, or where nothing touches."""
    name, seed = job
    trial = Trial(TrialSettings(object=name), seed)
    try:
        trial.acquire()
        if not trial.touched:
            return None
        values = [trial.load(speed).load for speed in SPEEDS]
    except Diverged:
        return None
    return values if min(values) > 0.0 else None


def main(argv: list[str] | None = None) -> None:
    """Print the table."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=60, help="grasps to try [60]")
    parser.add_argument("--seed", type=int, default=2000, help="first seed [2000]")
    args = parser.parse_args(argv)
    at_least(parser, args, grasps=1, seed=0)
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4) for k in range(args.grasps)]
    found = [r for r in run_all(loads, jobs, "load tests") if r is not None]
    q = np.array(found)
    reference = q[:, SPEEDS.index(1.0)]
    table = Table(title=f"{len(found)} grasps that bear a load, seeds from {args.seed}")
    for heading in ("load grows", "q_sim over speed 1, median", "5 to 95 %", "capped"):
        table.add_column(heading, justify="right")
    rows = [(f"× {speed:g}", q[:, k]) for k, speed in enumerate(SPEEDS)]
    for name, values in rows:
        ratio = values / reference
        low, high = np.quantile(ratio, (0.05, 0.95))
        capped = int((values >= load_test.CAP).sum())
        table.add_row(name, f"{np.median(ratio):.3f}", f"{low:.3f} to {high:.3f}", str(capped))
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
