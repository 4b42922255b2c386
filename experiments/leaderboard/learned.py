"""Learned predictors beside the metrics, each trial scored by a model that did not see it.

They get what the metrics get: the readings, the joints and torques, and of the object pose, mass
and friction as they were perceived.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from experiments.success_prediction.baselines import (
    can_learn,
    has_learning,
    joint_features,
    logistic_scores,
    object_features,
    tactile_features,
)
from sdh_sim.analysis.leaderboard import Entrant, Outcomes

TREES = {"max_iter": 100, "learning_rate": 0.05, "max_leaf_nodes": 8, "random_state": 0}


def features_of(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Features (n, d) of the readings, the joints and torques, and the object."""
    return np.hstack([of(rows) for of in (tactile_features, joint_features, object_features)])


def learned_entrants(
    rows: Sequence[Mapping[str, Any]], outcomes: Outcomes, objects: np.ndarray
) -> list[Entrant]:
    """Logistic regression and boosted trees, on random folds and on objects not seen.

    None of them where scikit-learn is missing, or too few of an outcome are outside of a fold.

    Args:
        rows: of the trials.
        outcomes: of them.
        objects: (n,) number of each trial's object.
    """
    if not has_learning():
        return []
    features = features_of(rows)
    found = []
    for words, fold in (("", outcomes.fold), (", unseen objects", objects)):
        if not can_learn(outcomes.success, fold):
            continue
        for name, label, scores in (
            ("logistic", "logistic regression", logistic_scores),
            ("trees", "boosted trees", tree_scores),
        ):
            values = scores(features, outcomes.success, fold)
            key = f"{name}_unseen" if words else name
            found.append(Entrant(key, label + words, "learned", values, threshold=0.5))
    return found


def tree_scores(features: np.ndarray, success: np.ndarray, fold: np.ndarray) -> np.ndarray:
    """Probability of success (n,) by gradient boosting trained on the other folds.

    Args:
        features: (n, d).
        success: (n,) bool.
        fold: (n,) fold of each grasp.
    """
    from sklearn.ensemble import (  # pyright: ignore[reportMissingImports]
        HistGradientBoostingClassifier,
    )

    scores = np.full(len(success), np.nan)
    for k in np.unique(fold):
        train, test = fold != k, fold == k
        model = HistGradientBoostingClassifier(**TREES)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.fit(features[train], success[train])
        scores[test] = model.predict_proba(features[test])[:, 1]
    return scores
