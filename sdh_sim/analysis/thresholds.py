"""Where to put the decision boundary: the most accurate one, and one as conservative as desired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdh_sim.analysis.proportion import Rate
from sdh_sim.analysis.resampling import RESAMPLES, Ladder, stratified_weights

FOLDS = 10
TARGETS = np.round(np.arange(0.0, 0.505, 0.01), 2)  # desired false positive rates
TARGETS.setflags(write=False)


def assign_folds(strata: np.ndarray, rng: np.random.Generator, folds: int = FOLDS) -> np.ndarray:
    """Fold of every trial (n,), each stratum spread evenly over them.

    Args:
        strata: (n,) label of each trial's stratum, such as its object and outcome.
        rng: shuffles within a stratum.
        folds: how many.
    """
    fold = np.empty(len(strata), dtype=np.int64)
    start = 0
    for label in sorted(set(strata.tolist())):
        members = rng.permutation(np.flatnonzero(strata == label))
        # Going on where the last stratum stopped keeps the folds of one size.
        fold[members] = (start + np.arange(len(members))) % folds
        start += len(members)
    return fold


def best_threshold(scores: np.ndarray, success: np.ndarray) -> float:
    """The threshold t at which "succeeds when score > t" is right most often.

    Among equally good ones the middle one; between two scores, their mean. -inf predicts success
    for every score above it.

    Args:
        scores: (n,) without NaN.
        success: (n,) bool.
    """
    ladder = Ladder.of(scores, success)
    good, bad = ladder.counts()
    right = np.concatenate(([0], (good - bad)[0]))  # plus the number of failures
    best = np.flatnonzero(right == right.max())
    return _between(ladder.levels, int(best[len(best) // 2]))


def _between(levels: np.ndarray, above: int) -> float:
    """A threshold that the first ``above`` of the falling levels exceed and no other."""
    if above == len(levels):
        return -np.inf
    if above == 0:
        return float(levels[0])
    upper, lower = float(levels[above - 1]), float(levels[above])
    if np.isfinite(upper) and np.isfinite(lower):
        middle = 0.5 * (upper + lower)
        return middle if lower <= middle < upper else lower
    return float(np.nextafter(upper, -np.inf)) if np.isfinite(upper) else lower


@dataclass(frozen=True)
class CrossValidated:
    """Right and wrong predictions with the threshold of each fold chosen on the other folds.

    Attributes:
        threshold: the best on all trials: what to use next.
        low, high: smallest and largest of the folds' thresholds.
        accuracy, true_positive_rate, true_negative_rate: over all folds together.
    """

    threshold: float
    low: float
    high: float
    accuracy: Rate
    true_positive_rate: Rate
    true_negative_rate: Rate


def cross_validate(scores: np.ndarray, success: np.ndarray, fold: np.ndarray) -> CrossValidated:
    """Choose the most accurate threshold on the other folds, apply it to each in turn.

    Args:
        scores: (n,) without NaN.
        success: (n,) bool.
        fold: (n,) fold of each trial.
    """
    predicted = np.zeros(len(scores), dtype=bool)
    chosen = []
    for k in np.unique(fold):
        held_out = fold == k
        threshold = best_threshold(scores[~held_out], success[~held_out])
        predicted[held_out] = scores[held_out] > threshold
        chosen.append(threshold)
    good, bad = int(success.sum()), int((~success).sum())
    tp, tn = int((predicted & success).sum()), int((~predicted & ~success).sum())
    return CrossValidated(
        threshold=best_threshold(scores, success),
        low=min(chosen),
        high=max(chosen),
        accuracy=Rate(tp + tn, len(scores)),
        true_positive_rate=Rate(tp, good),
        true_negative_rate=Rate(tn, bad),
    )


def threshold_for(scores: np.ndarray, success: np.ndarray, target: float) -> float:
    """Smallest threshold at which at most a share ``target`` of the failures is above it."""
    failing = np.sort(scores[~success])[::-1]
    allowed = int(np.floor(target * len(failing) + 1e-9))
    return float(failing[allowed]) if allowed < len(failing) else -np.inf


@dataclass(frozen=True)
class Calibration:
    """Threshold for a desired false positive rate, and what it costs.

    Attributes:
        targets: desired false positive rates (k,).
        threshold, threshold_low, threshold_high: smallest threshold that keeps to them on the
            trials at hand (k,), 95 % bootstrap band.
        tpr, tpr_low, tpr_high: share of the successes that is still predicted (k,), band.
        achieved: false positives among trials of the folds that did not choose (k,).
    """

    targets: np.ndarray
    threshold: np.ndarray
    threshold_low: np.ndarray
    threshold_high: np.ndarray
    tpr: np.ndarray
    tpr_low: np.ndarray
    tpr_high: np.ndarray
    achieved: tuple[Rate, ...]


def calibrate(
    scores: np.ndarray,
    success: np.ndarray,
    fold: np.ndarray,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
    targets: np.ndarray = TARGETS,
) -> Calibration | None:
    """Threshold against desired false positive rate; None where a class has no two members.

    Args:
        scores: (n,) without NaN.
        success: (n,) bool.
        fold: (n,) fold of each trial.
        rng, resamples: of the bootstrap, each class by itself.
        targets: (k,) desired false positive rates.
    """
    if success.sum() < 2 or (~success).sum() < 2:
        return None
    ladder = Ladder.of(scores, success)
    threshold, tpr = _at_targets(ladder, None, targets)
    thresholds, tprs = [], []
    for weights in stratified_weights(success, rng, resamples):
        t, y = _at_targets(ladder, weights, targets)
        thresholds.append(t)
        tprs.append(y)
    # Infinite thresholds (every trial passes) sort right, but cannot be interpolated between.
    t_low, t_high = np.quantile(
        np.concatenate(thresholds), [0.025, 0.975], axis=0, method="nearest"
    )
    y_low, y_high = np.quantile(np.concatenate(tprs), [0.025, 0.975], axis=0)
    return Calibration(
        targets=targets,
        threshold=threshold[0],
        threshold_low=t_low,
        threshold_high=t_high,
        tpr=tpr[0],
        tpr_low=y_low,
        tpr_high=y_high,
        achieved=tuple(_achieved(scores, success, fold, float(t)) for t in targets),
    )


def _at_targets(
    ladder: Ladder, weights: np.ndarray | None, targets: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Thresholds and true positive rates (r, k) for each row of weights."""
    good, bad = ladder.counts(weights)
    zero = np.zeros((len(good), 1), dtype=good.dtype)
    # Column j: what lies strictly above level j; the last column: everything.
    above_good = np.concatenate((zero, good), axis=1)
    above_bad = np.concatenate((zero, bad), axis=1)
    levels = np.append(ladder.levels, -np.inf)
    rows = np.arange(len(good))
    thresholds, rates = np.empty((2, len(good), len(targets)))
    for k, target in enumerate(targets):
        allowed = np.floor(target * bad[:, -1:] + 1e-9)
        last = (above_bad <= allowed).sum(axis=1) - 1
        thresholds[:, k] = levels[last]
        rates[:, k] = above_good[rows, last] / good[:, -1]
    return thresholds, rates


def _achieved(scores: np.ndarray, success: np.ndarray, fold: np.ndarray, target: float) -> Rate:
    passed = total = 0
    for k in np.unique(fold):
        held_out = (fold == k) & ~success
        threshold = threshold_for(scores[fold != k], success[fold != k], target)
        passed += int((scores[held_out] > threshold).sum())
        total += int(held_out.sum())
    return Rate(passed, total)
