"""Metrics evaluated on stored grasps, with what each costs and where it fails."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import graspq as gq
from sdh_sim.metrics.field import KNOWN, described
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.metrics.stored_grasps import grasp_of
from sdh_sim.metrics.user_metrics import summary
from sdh_sim.robot import HandKinematics, hand_kinematics, hand_named
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.user_references import HandFolder, ObjectFolder, UserMetric

MapJobs = Callable[[Callable[[Any], Any], Sequence[Any], str], list[Any]]


class GraspScores(NamedTuple):
    """Metrics of one grasp.

    Attributes:
        values: (k,) in each metric's own orientation; NaN where it has none.
        seconds: (k,) of processor time; NaN where nothing was computed.
        faults: what a metric raised, by its name.
        sensed: whether a pad felt a contact.
    """

    values: np.ndarray
    seconds: np.ndarray
    faults: dict[str, str]
    sensed: bool


@dataclass(frozen=True)
class ScoreJob:
    """A stored grasp to be rated.

    Attributes:
        row: of the table of trials.
        pads: ``all``, or the kind of array whose pads count.
        hand: name of the hand; None takes the built-in one that the row names.
        hand_folder: of a user's hand.
        folders: of users' objects, by name.
        known: names of metrics.
        own: users' metrics.
    """

    row: Mapping[str, Any]
    pads: str
    hand: str | None
    hand_folder: HandFolder | None
    folders: Mapping[str, ObjectFolder]
    known: tuple[str, ...]
    own: tuple[UserMetric, ...]


def metrics_of(known: Sequence[str], own: Sequence[UserMetric]) -> tuple[FieldMetric, ...]:
    """The metrics of those names and the users' own, in that order."""
    return (*(KNOWN[name] for name in known), *map(described, own))


def score_job(job: ScoreJob) -> GraspScores | None:
    """Metrics of a stored grasp; None where the trial ended before its snapshot."""
    grasp = grasp_in(job)
    return None if grasp is None else score_grasp(grasp, metrics_of(job.known, job.own))


def grasp_in(job: ScoreJob) -> PerceivedGrasp | None:
    """The grasp of a job; None where the trial ended before its snapshot."""
    return grasp_of(job.row, job.pads, hand_of_job(job), job.folders)


def hand_of_job(job: ScoreJob) -> HandKinematics | None:
    """The hand of a job, found by each process for itself; None: the row names a built-in one."""
    return None if job.hand is None else hand_kinematics(hand_named(job.hand, job.hand_folder))


def score_grasp(grasp: PerceivedGrasp, metrics: Sequence[FieldMetric]) -> GraspScores:
    """Values, costs and faults of metrics; a metric that raises costs itself alone.

    A grasp without contacts gets each metric's worst value. A ``graspq.GraspError`` says that a
    metric cannot be computed for a grasp, which is no fault.
    """
    values = np.array([metric.worst for metric in metrics])
    seconds = np.full(len(metrics), math.nan)
    faults: dict[str, str] = {}
    for k, metric in enumerate(metrics):
        if not grasp.contacts and not (metric.name == "q_whole_hand" and grasp.others):
            continue
        values[k] = math.nan
        mine = copy.deepcopy(grasp) if metric.family == "own" else grasp
        start = time.process_time()
        try:
            values[k] = float(metric.function(mine))
        except gq.GraspError as error:
            if metric.family == "own":
                faults[metric.name] = summary(error)
        except (Exception, SystemExit) as error:
            faults[metric.name] = summary(error)
        seconds[k] = time.process_time() - start
    return GraspScores(values, seconds, faults, bool(grasp.contacts))
