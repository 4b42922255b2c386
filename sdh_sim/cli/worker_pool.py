"""Run a function over many jobs in worker processes, with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

from rich.console import Console
from rich.progress import track

from sdh_sim.run_options import default_workers
from sdh_sim.thread_limits import limit_threads

Job = TypeVar("Job")
Result = TypeVar("Result")


def run_all(
    function: Callable[[Job], Result], jobs: Sequence[Job], title: str, workers: int | None = None
) -> list[Result]:
    """Results in the order of the jobs.

    Args:
        function: module-level function of one job.
        jobs: picklable.
        title: before the progress bar, which goes to stderr.
        workers: processes, by default one per core.
    """
    count = min(workers or default_workers(), len(jobs))
    with ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=limit_threads
    ) as pool:
        results: Iterable[Result] = pool.map(function, jobs, chunksize=1)
        console = Console(stderr=True)
        return list(track(results, description=title, total=len(jobs), console=console))
