"""A file with users' metrics, good and bad, and a trial that has their columns."""

from __future__ import annotations

import math
from pathlib import Path

from sdh_sim.metrics import find_metrics
from sdh_sim.records import METRIC_ERROR
from sdh_sim.runs import RunPlan
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import UserMetric
from tests.support import trial_stand_ins as stand_ins
from tests.support.repository import ROOT

EXAMPLE = ROOT / "docs" / "examples" / "my_metric.py"
SOURCE = """
import math, sys

def thumb(grasp):
    return float(grasp.snapshot.distal[2].sum())

thumb.threshold = 3

def raises(grasp):
    raise ValueError("no\\nsecond line")

def leaves(grasp):
    sys.exit(3)

def text(grasp):
    return "1.0"

def nothing(grasp):
    return None

def infinite(grasp):
    return math.inf

def spoils(grasp):
    grasp.snapshot.distal[:] = -1.0
    grasp.torque_limits[:] = 0.0
    return 1

class Callable_:
    threshold = 0.25
    def __call__(self, grasp):
        return 2.0

made = Callable_()
number = 3.0
strange = Callable_()
strange.threshold = "high"
error = thumb
BIG = thumb
"""


def metric_file(folder: Path) -> Path:
    """A file with ``SOURCE``."""
    path = folder / "mine.py"
    path.write_text(SOURCE)
    return path


def find(file: Path, *names: str) -> tuple[UserMetric, ...]:
    """The metrics of those names in a file."""
    return find_metrics([f"{file}:{name}" for name in names])


def with_metrics(settings: TrialSettings, seed: int, log: bool = False) -> stand_ins.Result:
    """A stand-in for a trial whose rows have users' metrics, with gaps."""
    row = stand_ins.make_row(settings.object, seed)
    if row["failure"] != "no_contact":
        for k, metric in enumerate(settings.metrics):
            missing = seed % 5 == k
            row[metric.column] = math.nan if missing else row["q_linf"] + k
            row[METRIC_ERROR] = f"{metric.name}: ValueError: no" if missing else ""
    if seed % 7 == 3:
        raise ZeroDivisionError
    return stand_ins.Result(row)


def plan_with(file: Path, trials: int, objects=("box", "oval_bottle")) -> RunPlan:
    """A run of so many trials for each object, with two metrics of a file."""
    settings = TrialSettings(objects[0], metrics=find(file, "thumb", "raises"))
    return RunPlan(objects, settings, trials, 0)
