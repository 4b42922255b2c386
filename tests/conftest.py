"""One numerical thread and one worker per process, the metrics compiled before any test runs.

Numerical libraries start a thread per core in every process; with a test process per core these
wait for each other: a test of regressions took four times as long.

In a new environment Numba compiles for half a minute. Two processes share it (``graspq.warm_up``);
where everything is on the disk already, nothing is done.

Commands that do not say how many workers they want get one, not one per core: the cores are busy
with other tests, and the start of a worker takes longer than most trials.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from sdh_sim.run_options import default_workers
from sdh_sim.thread_limits import limit_threads

ROOT = Path(__file__).resolve().parents[1]

limit_threads()  # before numpy is imported; worker processes inherit it


def pytest_xdist_auto_num_workers() -> int:
    """One worker more than there are cores: many tests wait for processes that they start."""
    return default_workers() + 1


def pytest_configure(config: pytest.Config) -> None:
    """Compile where several workers will need it and nothing is compiled yet."""
    if hasattr(config, "workerinput") or not getattr(config.option, "numprocesses", None):
        return
    cache = Path(os.environ.get("NUMBA_CACHE_DIR", ROOT / "graspq" / "_compiled" / "__pycache__"))
    if any(cache.rglob("*.nbi")):
        return
    warm = [sys.executable, "-c", "from graspq.warm_up import warm_up; warm_up()"]
    running = [
        subprocess.Popen(warm, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(2)
    ]
    for process in running:
        process.wait()  # what fails here fails in a test that says so


@pytest.fixture(scope="session", autouse=True)
def one_worker() -> Iterator[None]:
    """Where a test does not ask for more."""
    with pytest.MonkeyPatch.context() as patch:
        for module in ("lift_request", "demo", "worker_pool"):
            patch.setattr(f"sdh_sim.cli.{module}.default_workers", lambda: 1)
        yield
