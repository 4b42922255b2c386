"""Predictors without wrenches: what the wrench-based metrics have to do better than."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sdh_sim.records import TACTILE

FEWEST = 20  # trials of either outcome to learn from, outside of each fold
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


def tactile_features(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Of every pad its sum, its number of active taxels and where its pressure is centred.

    Args:
        rows: of trials of one hand, with its arrays ``tactile_…``; zeros stand for one that a row
            lacks.

    Returns:
        (n, 4 times the number of pads).
    """
    names = sorted({name for row in rows for name in row if name.startswith(TACTILE)})
    return np.hstack([_of_pads(rows, name) for name in names])


def _of_pads(rows: Sequence[Mapping[str, Any]], name: str) -> np.ndarray:
    shape = next((np.shape(row[name]) for row in rows if row.get(name) is not None), (0, 1, 1))
    found = []
    for row in rows:
        pads = np.zeros(shape) if row.get(name) is None else np.asarray(row[name], dtype=float)
        found.append([value for pad in pads for value in _of_pad(pad)])
    return np.array(found)


def _of_pad(pad: np.ndarray) -> list[float]:
    total = float(pad.sum())
    centre = [0.0] * pad.ndim
    if total > 0:
        centre = [float(np.average(i, weights=pad)) for i in np.indices(pad.shape)]
    return [float(np.log1p(total)), float((pad > 0).sum()), *centre]


def joint_features(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Motor angles [rad or m] and torques [N m or N] (n, 2 times the motors); zeros for none."""
    columns = []
    for name in ("joint_angles_rad", "motor_torque_nm"):
        size = max((np.size(row[name]) for row in rows if row.get(name) is not None), default=0)
        columns.append(np.array([_numbers(row, name, size) for row in rows]))
    return np.hstack(columns)


def object_features(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """What the wrench-based metrics know as well: the object's pose in the hand, mass, friction.

    As they were perceived where errors of perception were asked for, as the metrics got them.
    """
    return np.array([_of_object(row) for row in rows])


def _of_object(row: Mapping[str, Any]) -> list[float]:
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


def can_learn(success: np.ndarray, fold: np.ndarray) -> bool:
    """Whether there is more than one fold, and enough of both outcomes outside of each.

    Args:
        success: (n,) bool.
        fold: (n,) fold of each grasp.
    """
    folds = np.unique(fold)
    return len(folds) > 1 and all(
        min(success[fold != k].sum(), (~success[fold != k]).sum()) >= FEWEST for k in folds
    )


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
