"""What Krug et al. (2017) report of 584 real grasps: section IV-B, figures 7 and 8.

Tests of a prediction "holds when q* >= 1" from the distal pads. Accuracies, areas under the ROC
curve and shares of the failing grasps let through are published; the true positive rates of all
grasps follow from them, since half of the grasps were stable.
"""

from __future__ import annotations

GRASPS = 584

_ACCURACY = {"q_linf": 0.745, "q_l1": 0.625}
_FALSE_POSITIVE = {"q_linf": 0.25, "q_l1": 0.02}
_AUC = {"q_linf": 0.820, "q_l1": 0.824}

REFERENCE: dict[tuple[str, str], dict[str, float]] = {
    ("overall", metric): {
        "accuracy": _ACCURACY[metric],
        "tnr": 1.0 - _FALSE_POSITIVE[metric],
        "tpr": 2.0 * _ACCURACY[metric] - (1.0 - _FALSE_POSITIVE[metric]),
        "auc": _AUC[metric],
    }
    for metric in _ACCURACY
}
REFERENCE["box", "q_l1"] = {"tpr": 0.045}
DERIVED = (("overall", "tpr"),)
"""Numbers that follow from published ones and are not printed themselves."""
