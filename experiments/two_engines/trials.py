"""One trial in both engines: the snapshot of MuJoCo, carried on in Drake."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

from experiments.two_engines.alignment import Alignment
from experiments.two_engines.engine import DrakeSimulation
from experiments.two_engines.outcomes import gravity_factor, lift
from experiments.two_engines.start import Start, guessed_references, start_of
from experiments.two_engines.straight import straight_lift
from experiments.two_engines.table import STRAIGHT
from experiments.two_engines.translate import translate
from sdh_sim.errors import Diverged
from sdh_sim.runs import Job
from sdh_sim.trial import classify
from sdh_sim.trial.outcome import Motion


class Task(NamedTuple):
    """What a worker does.

    Attributes:
        job: the trial.
        row: of the run's table.
        alignments: to carry it on with, by name.
        ramp: which of them get the load ramp.
    """

    job: Job
    row: Mapping[str, Any]
    alignments: Mapping[str, Alignment]
    ramp: tuple[str, ...]


def set_off(start: Start, alignment: Alignment) -> DrakeSimulation:
    """Drake at the snapshot, all at rest."""
    simulation = DrakeSimulation(translate(start.scene, start.palm, start.obj, alignment))
    references = start.references if alignment.references else guessed_references(start)
    simulation.set_to(start.qpos, start.obj, references)
    return simulation


def compare(task: Task) -> list[dict[str, Any]]:
    """Rows of a trial: of MuJoCo with a straight lift, then what Drake makes with each alignment.

    Raises:
        RunError: as ``start_of``.
    """
    start = start_of(task.job, task.row)
    rows = []
    for name in (STRAIGHT, *task.alignments):
        begin = time.process_time()
        alignment = task.alignments.get(name)
        motion = _moved(start, alignment)
        failure = classify(motion)
        load = (math.nan, False)
        if alignment is not None and name in task.ramp:
            load = _load(start, alignment)
        rows.append(
            {
                "trial": task.job.trial, "object": task.job.settings.object,
                "alignment": name, "success": failure == "none", "failure": failure,
                "displacement_mm": motion.displacement_mm, "rotation_deg": motion.rotation_deg,
                "q_sim": load[0], "q_sim_capped": load[1],
                "seconds": time.process_time() - begin,
            }
        )  # fmt: skip
    return rows


def _moved(start: Start, alignment: Alignment | None) -> Motion:
    try:
        if alignment is None:
            return straight_lift(start)
        return lift(set_off(start, alignment), start.lift_time)
    except Diverged:
        return Motion(math.nan, math.nan, True)


def _load(start: Start, alignment: Alignment) -> tuple[float, bool]:
    try:
        found = gravity_factor(set_off(start, alignment))
    except Diverged:
        return math.nan, False
    return found.load, found.capped
