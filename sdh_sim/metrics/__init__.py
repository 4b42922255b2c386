"""Grasp metrics: built in and users' own, of a perceived grasp or of one in a table of trials.

Other rooms use what is named here.
"""

from graspq.warm_up import warm_up
from sdh_sim.metrics.built_in import METRICS, evaluate, hand_bound, task_scaling, wrench_sets
from sdh_sim.metrics.prediction import NO_READING, Prediction, predict
from sdh_sim.metrics.stored_grasps import grasp_of, object_of, read_stored, snapshot_of
from sdh_sim.metrics.user_metrics import fault_lines, find_metrics, load_metric

__all__ = [
    "METRICS",
    "NO_READING",
    "Prediction",
    "evaluate",
    "fault_lines",
    "find_metrics",
    "grasp_of",
    "hand_bound",
    "load_metric",
    "object_of",
    "predict",
    "read_stored",
    "snapshot_of",
    "task_scaling",
    "warm_up",
    "wrench_sets",
]
