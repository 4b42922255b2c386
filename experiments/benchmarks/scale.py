"""What a run of very many trials costs beside the trials: rows per second, memory, resume, compare.

    python -m experiments.benchmarks.scale --out scale                     # 100 000 trials
    python -m experiments.benchmarks.scale --out scale --executor dask

The trials take no time and give rows of a real trial's size, so that what is measured is the
campaign: worker processes or a Dask cluster of two on this machine, the rows' way to the disk, a
stop in the middle, ``--resume``, the table, and ``sdh-sim compare`` of it.
"""

from __future__ import annotations

import itertools
import json
import os
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.command_line import Parser, at_least
from sdh_sim.campaign import run_campaign
from sdh_sim.cli.compare import compare
from sdh_sim.errors import Interrupted
from sdh_sim.objects import object_names
from sdh_sim.records import FAILURES, read_table
from sdh_sim.runs import MAX_TRIALS, RunFolder, RunPlan
from sdh_sim.settings import TrialSettings

MARKS = 10  # times that memory and time are noted


@dataclass(frozen=True)
class StandIn:
    """What ``run_trial`` returns, as far as a campaign looks."""

    row: dict[str, Any]
    log: Any = None
    sim_seconds: float = 4.0
    wall_seconds: float = 0.0


def stand_in(settings: TrialSettings, seed: int, log: bool = False) -> StandIn:
    """A row that the seed decides, as large as a real one, without a trial."""
    rng = np.random.default_rng(seed)
    failure = FAILURES[int(rng.integers(6))]  # those that count in a comparison
    q = rng.gamma(2.0, 0.5)
    return StandIn(
        {
            "object": settings.object,
            "seed": seed,
            "success": failure == "none",
            "failure": failure,
            "displacement_mm": float(rng.gamma(2.0, 4.0)),
            "rotation_deg": float(rng.gamma(2.0, 4.0)),
            "q_linf": q,
            "q_l1": 0.6 * q,
            "q_reason": "",
            "contacts": int(rng.integers(1, 7)),
            "mass_kg": 0.5,
            "torque_limit_nm": rng.uniform(size=7),
            "joint_angles_rad": rng.uniform(size=7),
            # Readings have twelve bits, and most taxels feel nothing.
            "tactile_proximal": _readings(rng, (3, 14, 6)),
            "tactile_distal": _readings(rng, (3, 13, 6)),
            "sim_seconds": 4.0,
        }
    )


def _readings(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return np.where(rng.uniform(size=shape) < 0.15, rng.integers(1, 4096, shape) * 60.0, 0.0)


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
    seen = itertools.count(1)
    marks: list[float] = []
    begin, middle, started, ended = time.perf_counter(), 0.0, 0.0, 0.0

    def on_trial(row: object) -> None:
        nonlocal middle, ended
        ended = time.perf_counter()
        number = next(seen)
        if number % max(plan.total // MARKS, 1) == 0:
            marks.append(memory())
        if number == plan.total // 2:
            middle = ended
            raise KeyboardInterrupt

    def on_start(result: object) -> None:
        nonlocal started
        started = time.perf_counter()

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
