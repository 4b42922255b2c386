"""Compile the metrics once before several workers would each compile all of them.

In a new environment Numba compiles for half a minute, and what one process compiles another
does not wait for. Two processes with different halves take half as long; where anything is on the
disk already, nothing is done.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
COMMON = """
import contextlib
import numpy as np
import graspq as gq
spots = [(0.03, 0, 0), (-0.02, 0.02, 0), (-0.02, -0.02, 0.01)]
grip = [gq.Contact(p, -np.array(p) / np.linalg.norm(p), 0.6, 10.0, 0.01) for p in spots]
tasks = gq.gravity_tasks(0.5, np.zeros(3), [0, 0, -9.81])
"""
HALVES = (
    """
sets = [gq.contact_wrenches(c) for c in grip]
for bound in ("linf", "l1"):
    gq.task_scaling(sets, tasks, bound)
    gq.epsilon(sets, bound)
    with contextlib.suppress(gq.GraspError):
        gq.volume(sets, bound)
gq.task_scaling_batch([sets], tasks)
gq.epsilon_batch([sets])
""",
    """
jacobians = [np.random.default_rng(k).normal(size=(6, 7)) * 0.05 for k in range(3)]
for torque in (None, np.full(7, 0.5)):
    for edges in (12, None):
        hand = gq.HandBound(grip, jacobians, np.ones(7), torque)
        gq.hand_task_scaling(hand, tasks, edges=edges)
gq.task_scaling([gq.contact_wrenches(c) for c in grip], tasks, unloading=False)
sets = [gq.contact_wrenches(c, None) for c in grip]
gq.task_scaling(sets, tasks)
with contextlib.suppress(gq.GraspError):
    gq.epsilon(sets)
with contextlib.suppress(gq.GraspError):
    gq.WrenchSpace(sets).slice("force", 0.1)
""",
)


def pytest_configure(config: pytest.Config) -> None:
    """Compile where several workers will need it and nothing is compiled yet."""
    if hasattr(config, "workerinput") or not getattr(config.option, "numprocesses", None):
        return
    cache = Path(os.environ.get("NUMBA_CACHE_DIR", ROOT / "graspq" / "_compiled" / "__pycache__"))
    if any(cache.rglob("*.nbi")):
        return
    running = [
        subprocess.Popen(
            [sys.executable, "-c", COMMON + half], cwd=ROOT,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        for half in HALVES
    ]  # fmt: skip
    for process in running:
        process.wait()  # what fails here fails in a test that says so
