"""Predictors without wrenches: what the wrench-based metrics have to do better than."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

PENALTIES = (0.001, 0.01, 0.1, 1.0, 10.0)  # inverse strengths to choose from, inside each fold
PAD_KINDS = ("tactile_distal", "tactile_proximal")


def sum_of_readings(row: Mapping[str, Any], kinds: Sequence[str] = PAD_KINDS) -> float:
    """Sum of all taxels [kPa]."""
    return float(sum(np.sum(array) for array in _arrays(row, kinds)))


def pads_in_contact(row: Mapping[str, Any], kinds: Sequence[str] = PAD_KINDS) -> float:
    """Number of pads that read something."""
    return float(sum((pad > 0).any() for array in _arrays(row, kinds) for pad in array))


def active_taxels(row: Mapping[str, Any], kinds: Sequence[str] = PAD_KINDS) -> float:
    """Number of taxels that read something."""
    return float(sum((array > 0).sum() for array in _arrays(row, kinds)))


def _arrays(row: Mapping[str, Any], kinds: Sequence[str]) -> list[np.ndarray]:
    return [np.asarray(row[kind]) for kind in kinds if row.get(kind) is not None]


def tactile_features(row: Mapping[str, Any]) -> list[float]:
    """Of every pad its sum, its number of active taxels and where its pressure is centred."""
    found: list[float] = []
    for kind in PAD_KINDS:
        array = row.get(kind)
        for finger in range(3):
            pad = np.zeros((1, 1)) if array is None else np.asarray(array[finger], dtype=float)
            total = pad.sum()
            centre = [0.0, 0.0]
            if total > 0:
                centre = [float(np.average(i, weights=pad)) for i in np.indices(pad.shape)]
            found += [float(np.log1p(total)), float((pad > 0).sum()), *centre]
    return found


def joint_features(row: Mapping[str, Any]) -> list[float]:
    """Motor angles [rad] and torques [N m]."""
    return _numbers(row, "joint_angles_rad", 7) + _numbers(row, "motor_torque_nm", 7)


def object_features(row: Mapping[str, Any]) -> list[float]:
    """What the wrench-based metrics know as well: the object's pose in the hand, mass, friction.

    As they were perceived where errors of perception were asked for, as the metrics got them.
    """
    pose = "object_pose_hand" if row.get("perceived_pose_hand") is None else "perceived_pose_hand"
    return [
        *_numbers(row, pose, 7),
        *_numbers(row, "hand_pose_world", 7),
        *(_perceived(row, "mass_kg"), _perceived(row, "friction")),
    ]


def _perceived(row: Mapping[str, Any], name: str) -> float:
    value = row.get(f"perceived_{name}")
    return float((row.get(name) if value is None else value) or 0.0)


def _numbers(row: Mapping[str, Any], name: str, size: int) -> list[float]:
    value = row.get(name)
    return [0.0] * size if value is None else [float(v) for v in np.asarray(value).reshape(-1)]


def has_learning() -> bool:
    """Whether scikit-learn, the optional extra ``learn``, is installed."""
    import importlib.util

    return importlib.util.find_spec("sklearn") is not None


def logistic_scores(features: np.ndarray, success: np.ndarray, fold: np.ndarray) -> np.ndarray:
    """Probability of success of every grasp, by a model trained on the other folds.

    Logistic regression on standardised features; how strongly it is penalised is chosen inside
    the folds that train.

    Args:
        features: (n, d).
        success: (n,) bool, each outcome at least five times outside of every fold.
        fold: (n,) fold of each grasp: random ones, or one per object to predict objects that the
            model has not seen.
    """
    from sklearn.linear_model import LogisticRegression  # pyright: ignore[reportMissingImports]
    from sklearn.model_selection import (  # pyright: ignore[reportMissingImports]
        GridSearchCV,
        StratifiedKFold,
    )
    from sklearn.pipeline import make_pipeline  # pyright: ignore[reportMissingImports]
    from sklearn.preprocessing import StandardScaler  # pyright: ignore[reportMissingImports]

    scores = np.full(len(success), np.nan)
    for k in np.unique(fold):
        train, test = fold != k, fold == k
        model = GridSearchCV(
            make_pipeline(StandardScaler(), LogisticRegression(max_iter=5000)),
            {"logisticregression__C": list(PENALTIES)},
            scoring="neg_log_loss",
            cv=StratifiedKFold(5, shuffle=True, random_state=0),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its solver warns at every iteration limit
            model.fit(features[train], success[train])
        scores[test] = model.predict_proba(features[test])[:, 1]
    return scores
