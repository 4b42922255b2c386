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
    has_learning,
    logistic_scores,
    object_features,
)
from sdh_sim.analysis.leaderboard import Entrant, Outcomes
from sdh_sim.records import TACTILE

FEWEST = 20  # trials of either outcome to learn from
TREES = {"max_iter": 100, "learning_rate": 0.05, "max_leaf_nodes": 8, "random_state": 0}


def features_of(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Features (n, d): of every pad its sum, taxels and centre; joints, torques, the object.

    Zeros stand where a trial has no snapshot.
    """
    arrays = sorted({name for row in rows for name in row if _is_array(name)})
    columns = [np.array([_pad_features(row.get(name), _shape(rows, name)) for row in rows])
               for name in arrays]  # fmt: skip
    for name in ("joint_angles_rad", "motor_torque_nm"):
        size = max((np.size(row[name]) for row in rows if row.get(name) is not None), default=0)
        columns.append(
            np.array([_or_zeros(row.get(name), (size,)).reshape(-1) for row in rows], float)
        )
    columns.append(np.array([object_features(row) for row in rows]))
    return np.hstack(columns)


def _is_array(name: str) -> bool:
    return name.startswith(TACTILE)


def _shape(rows: Sequence[Mapping[str, Any]], name: str) -> tuple[int, ...]:
    return next((np.shape(row[name]) for row in rows if row.get(name) is not None), (0, 1, 1))


def _or_zeros(value: Any, shape: tuple[int, ...]) -> np.ndarray:
    return np.zeros(shape) if value is None else np.asarray(value, dtype=float)


def _pad_features(value: Any, shape: tuple[int, ...]) -> list[float]:
    found: list[float] = []
    for pad in _or_zeros(value, shape):
        total = float(pad.sum())
        centre = [0.0] * pad.ndim
        if total > 0:
            centre = [float(np.average(i, weights=pad)) for i in np.indices(pad.shape)]
        found += [float(np.log1p(total)), float((pad > 0).sum()), *centre]
    return found


def learned_entrants(
    rows: Sequence[Mapping[str, Any]], outcomes: Outcomes, objects: np.ndarray
) -> list[Entrant]:
    """Logistic regression and boosted trees, on random folds and on objects not seen.

    None where scikit-learn is missing, or a fold would leave fewer than twenty of an outcome.

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
        if not _enough(outcomes.success, fold):
            continue
        for name, label, scores in (
            ("logistic", "logistic regression", logistic_scores),
            ("trees", "boosted trees", tree_scores),
        ):
            values = scores(features, outcomes.success, fold)
            key = f"{name}_unseen" if words else name
            found.append(Entrant(key, label + words, "learned", values, threshold=0.5))
    return found


def _enough(success: np.ndarray, fold: np.ndarray) -> bool:
    folds = np.unique(fold)
    return len(folds) > 1 and all(
        min(success[fold != k].sum(), (~success[fold != k]).sum()) >= FEWEST for k in folds
    )


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
