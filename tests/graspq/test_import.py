"""The library stands alone, imports fast, and its compiled code is ready on disk."""

import os
import subprocess
import sys

from tests.support.repository import ROOT

CALL = (
    "import numpy as np, graspq as gq, time; t = time.process_time();"
    "gq.task_scaling([np.vstack([np.eye(6), -np.eye(6)]).T], np.ones((6, 1)));"
    "print(time.process_time() - t)"
)


def run(code):
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", code],
        env=env,
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    ).stdout


def test_import_is_fast_and_brings_no_simulator():
    code = (
        "import time; t = time.process_time(); import graspq, sys;"
        "print(time.process_time() - t, *sorted(sys.modules))"
    )
    best = min(float(run(code).split()[0]) for _ in range(2))
    assert best < 1.0
    modules = set(run(code).split()[1:])
    assert not modules & {"mujoco", "sdh_sim", "experiments", "numba", "scipy.optimize", "trimesh"}


def test_no_module_of_the_library_names_a_simulator():
    for path in (ROOT / "graspq").glob("*.py"):
        text = path.read_text()
        assert "import mujoco" not in text
        assert "sdh_sim" not in text


def test_the_first_call_after_the_first_run_is_quick():
    run(CALL)
    assert float(run(CALL)) < 3.0
