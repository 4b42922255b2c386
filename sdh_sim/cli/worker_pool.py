"""Run a function over many jobs in worker processes, with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
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
    with _pool(len(jobs), workers) as pool:
        results: Iterable[Result] = pool.map(function, jobs, chunksize=1)
        console = Console(stderr=True)
        return list(track(results, description=title, total=len(jobs), console=console))


def run_each(
    function: Callable[[Job], Result], jobs: Sequence[Job], title: str, workers: int | None = None
) -> Iterator[Result]:
    """Results as they are found, to be stored at once; arguments as of ``run_all``.

    Where the caller stops or a job raises, jobs that have not begun are given up.
    """
    if not jobs:
        return
    with _pool(len(jobs), workers) as pool:
        waiting = [pool.submit(function, job) for job in jobs]
        console = Console(stderr=True)
        done = track(as_completed(waiting), title, total=len(waiting), console=console)
        try:
            for future in done:
                yield future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _pool(jobs: int, workers: int | None) -> ProcessPoolExecutor:
    count = max(1, min(workers or default_workers(), jobs))
    spawn = get_context("spawn")
    return ProcessPoolExecutor(count, mp_context=spawn, initializer=limit_threads)
