"""A finished run to compare with, counts of tries, runs in processes of their own."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sdh_sim.campaign import run_campaign
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT
from tests.support.trial_stand_ins import plan


@pytest.fixture(scope="session")
def whole(tmp_path_factory) -> Path:
    """An uninterrupted run by one worker."""
    out = tmp_path_factory.mktemp("whole")
    run_campaign(plan(), out, 1, trial=stand_ins.quick)
    return out


@pytest.fixture
def tries(tmp_path, monkeypatch) -> Callable[[], dict[int, int]]:
    """How often each seed was tried, as the stand-ins noted it."""
    folder = tmp_path / "tries"
    folder.mkdir()
    monkeypatch.setenv("STAND_IN_TRIES", str(folder))
    return lambda: {int(path.name): path.stat().st_size for path in folder.iterdir()}


_RUN = """
import resource, sys
def on_trial(row):
    print(row["trial"], flush=True)
    if len(sys.argv) > 5:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[5]), int(sys.argv[5])))
from sdh_sim.campaign.campaign import run_campaign
from sdh_sim.errors import CampaignError
from tests.support import trial_stand_ins as stand_ins
from tests.support.trial_stand_ins import plan
try:
    run_campaign(
        plan(int(sys.argv[2])), sys.argv[1], 2, resume=True, save_every=float(sys.argv[4]),
        trial=getattr(stand_ins, sys.argv[3]), on_trial=on_trial,
    )
except CampaignError as error:
    print(error, file=sys.stderr)
    sys.exit(error.status)
"""


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts runs in processes of their own; what a failing test leaves of them is ended."""
    started: list[subprocess.Popen[str]] = []

    def run(
        out: Path, trials: int, trial: str, save_every: float = 0.0, file_size: int | None = None
    ) -> subprocess.Popen[str]:
        # A group of its own: Ctrl-C in a terminal reaches the workers as well. A shell's
        # background job ignores SIGINT, and children inherit that.
        process = subprocess.Popen(
            [sys.executable, "-c", _RUN, str(out), str(trials), trial, str(save_every)]
            + ([] if file_size is None else [str(file_size)]),
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        started.append(process)
        return process

    yield run
    for process in started:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
