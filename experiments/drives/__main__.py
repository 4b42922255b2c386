"""What the drives of the hand change: labels, loads borne, and which bound predicts them.

    python -m experiments.drives --trials 100 --out drives

Every grasp is tried three times, with motors that yield, hold and lock, on the same way to the
object, and loaded as in ``experiments.devices``. A run that was stopped goes on where it was.
"""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

from rich.console import Console

from experiments.command_line import Parser, at_least, fail
from experiments.drives.findings import bound_table, label_table
from experiments.drives.grasps import LOAD_SPEED, Job, observe
from experiments.drives.picture import draw
from experiments.drives.table import TABLE, GraspTable
from sdh_sim.errors import SettingsError
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.run_options import default_workers
from sdh_sim.runs.plan import trial_seed
from sdh_sim.settings import TrialSettings
from sdh_sim.thread_limits import limit_threads


def run(table: GraspTable, jobs: list[Job], workers: int, minutes: float) -> None:
    """Try the grasps that are missing, until time is up."""
    end = time.monotonic() + 60.0 * minutes
    left = [job for job in jobs if (job.settings.object, job.seed) not in table.done]
    if not left:
        return
    context = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=limit_threads) as pool:
        futures = [pool.submit(observe, job) for job in left]
        for future in as_completed(futures):
            if not future.cancelled():
                table.add(future.result())
            if time.monotonic() > end:
                pool.shutdown(wait=False, cancel_futures=True)
                break


def main(argv: list[str] | None = None) -> None:
    """Print the tables, draw the figure."""
    parser = Parser(__doc__)
    parser.add_argument("--trials", type=int, default=100, help="for each object [100]")
    parser.add_argument("--seed", type=int, default=31, help="of the run [31]")
    parser.add_argument("--hand", default="schunk_sdh2", help="of the models [schunk_sdh2]")
    parser.add_argument("--gear-friction", type=float, default=0.25, help="of hold [0.25]")
    parser.add_argument("--workers", type=int, default=default_workers(), help="processes")
    parser.add_argument("--minutes", type=float, default=1e6, help="stop after these; go on later")
    parser.add_argument("--out", type=Path, default=Path("drives"), help="folder of the results")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=1, seed=0, workers=1)
    try:
        settings = TrialSettings("box", hand=args.hand, gear_friction=args.gear_friction)
        jobs = [
            Job(replace(settings, object=name), trial_seed(args.seed, name, index))
            for index in range(args.trials)
            for name in PAPER_ORDER
        ]
        conditions = {"seed": args.seed, "hand": args.hand, "gear_friction": args.gear_friction}
        table = GraspTable(args.out, conditions | {"load_speed": LOAD_SPEED})
        run(table, jobs, args.workers, args.minutes)
        wanted = {(job.settings.object, job.seed) for job in jobs}
        seen = [s for s in table.seen if (s.object, s.seed) in wanted]
        if not seen:
            fail("no grasp is finished; give it more --minutes")
        console = Console(width=130)
        console.print(f"{len(seen) // 3} grasps of {len(jobs)}")
        console.print(label_table(seen))
        for known_com in (False, True):
            console.print(bound_table(seen, known_com))
        print(f"every grasp: {args.out / TABLE}")
        print(f"figure: {draw(seen, args.out / 'drives')}")
    except SettingsError as error:
        fail(str(error))
    except OSError as error:
        fail(f"cannot write to {args.out}: {error.strerror or error}; choose another --out")


if __name__ == "__main__":
    main()
