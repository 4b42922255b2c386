"""What a run of very many trials costs beside the trials: rows per second, memory, resume, compare.

    python -m experiments.benchmarks.scale --out scale                     # 100 000 trials
    python -m experiments.benchmarks.scale --out scale --executor dask

The trials take no time and give rows of half a real trial's size, so that what is measured is the
campaign: worker processes or a Dask cluster of two on this machine, the rows' way to the disk, a
stop in the middle, ``--resume``, the table, and ``sdh-sim compare`` of it.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from experiments.benchmarks.stand_in_trial import stand_in
from experiments.command_line import Parser, at_least
from sdh_sim.campaign import RunResult, run_campaign
from sdh_sim.cli.compare import compare
from sdh_sim.errors import Interrupted
from sdh_sim.objects import object_names
from sdh_sim.records import read_table
from sdh_sim.runs import MAX_TRIALS, RunFolder, RunPlan
from sdh_sim.settings import TrialSettings

MARKS = 10  # times that memory and time are noted


@dataclass
class Measured:
    """One run, measured; times in seconds, memory in MB.

    Attributes:
        executor: what ran the trials.
        trials: of the run.
        rows_per_second: kept on the disk, before the stop and after it.
        memory: of this process after each tenth of the run.
        stop: from the interrupt to the end of the first session.
        resume: from the second start to its first trial being given out.
        close: the last write of the table.
        table: size of the table.
        read: reading the columns of a comparison.
        compared: ``sdh-sim compare --no-report``.
        peak: largest memory of this process, the comparison with it.
    """

    executor: str
    trials: int
    rows_per_second: list[float]
    memory: list[float]
    stop: float
    resume: float
    close: float
    table: float
    read: float
    compared: float
    peak: float


def memory() -> float:
    """Memory of this process now [MB]; its largest where the system does not tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return peak_memory()
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def peak_memory() -> float:
    """Largest memory that this process had [MB]."""
    unit = 1.0 if sys.platform == "darwin" else 1e3
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def timed(call: Callable[[], object]) -> float:
    """Seconds that a call takes."""
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def measure(out: Path, trials: int, executor: str, workers: int) -> Measured:
    """Run so many stand-ins, stop in the middle, go on, compare.

    Args:
        out: folder of the run; a run that is there is replaced.
        trials: in all, a multiple of the number of objects.
        executor: ``processes`` or ``dask``.
        workers: processes.
    """
    names = object_names()
    plan = RunPlan(names, TrialSettings(names[0]), trials // len(names), 0)
    marks: list[float] = []
    middle = started = ended = 0.0
    number = 0

    def on_trial(row: object) -> None:
        nonlocal middle, ended, number
        ended = time.perf_counter()
        number += 1
        if number % max(plan.total // MARKS, 1) == 0:
            marks.append(memory())
        if number == plan.total // 2 and not middle:
            middle = ended
            raise KeyboardInterrupt

    def on_start(result: RunResult) -> None:
        nonlocal started, number
        started = time.perf_counter()
        number = result.counts.total()  # the last rows before a stop are kept and not announced

    options: dict[str, Any] = {"trial": stand_in, "executor": executor, "on_start": on_start}
    try:
        run_campaign(plan, out, workers, overwrite=True, on_trial=on_trial, **options)
    except Interrupted as stop:
        print(stop, file=sys.stderr)
    first = middle - started
    again = time.perf_counter()
    stopped = again - middle
    run_campaign(plan, out, workers, resume=True, on_trial=on_trial, **options)
    end = time.perf_counter()
    half = plan.total // 2
    table = RunFolder(out).table
    read = timed(lambda: read_table(table, ["object", "success", "failure", "q_linf", "q_l1"]))
    compared = timed(lambda: compare([out], pages=False))
    return Measured(
        executor,
        plan.total,
        [half / first, (plan.total - half) / (ended - started)],
        marks,
        stopped,
        started - again,
        end - ended,
        table.stat().st_size / 1e6,
        read,
        compared,
        peak_memory(),
    )


def main(argv: list[str] | None = None) -> int:
    """Measure one executor and print what came out."""
    parser = Parser(__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the run, replaced")
    parser.add_argument("--trials", type=int, default=100_000, help="in all [100000]")
    parser.add_argument("--executor", choices=("processes", "dask"), default="processes")
    parser.add_argument("--workers", type=int, default=2, help="worker processes [2]")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=100, workers=1)
    if args.trials > len(object_names()) * MAX_TRIALS:
        parser.error(f"--trials must be at most {len(object_names()) * MAX_TRIALS}")
    found = measure(args.out, args.trials, args.executor, args.workers)
    for name, value in asdict(found).items():
        values = value if isinstance(value, list) else [value]
        print(f"{name:16}", *(f"{v:.4g}" if isinstance(v, float) else v for v in values))
    (args.out / "scale.json").write_text(json.dumps(asdict(found), indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
