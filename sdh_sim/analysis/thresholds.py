"""Choice of the threshold: the most accurate one, and one for a desired false positive rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.resampling import RESAMPLES, RankedScores, stratified_weights
from sdh_sim.analysis.roc_area import FEWEST

FOLDS = 10
TARGETS = np.round(np.arange(0.0, 0.505, 0.01), 2)  # desired false positive rates
TARGETS.setflags(write=False)
LOWEST = float(np.finfo(float).min)  # a threshold that every score but -inf exceeds


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
        # Going on where the last stratum stopped keeps the folds equal in size.
        fold[members] = (start + np.arange(len(members))) % folds
        start += len(members)
    return fold


def exceeds(scores: np.ndarray, threshold: float) -> np.ndarray:
    """Where success is predicted (n,) bool: above the threshold, and everywhere where it is -inf.

    So that success can be predicted throughout even where scores of -inf are among them.
    """
    return (scores > threshold) | (threshold == -np.inf)


def best_threshold(scores: np.ndarray, success: np.ndarray) -> float:
    """The threshold t of the most accurate prediction "succeeds where score ``exceeds`` t".

    It lies midway between two neighbouring scores; of several that are equally accurate the
    middle one is taken. -inf where it is most accurate to predict success throughout.

    Args:
        scores: (n,) without NaN.
        success: (n,) bool.
    """
    ranked = RankedScores.of(scores, success)
    good, bad = ranked.counts()
    # Correct predictions, less the number of all failures.
    correct = np.concatenate(([0], (good - bad)[0]))
    best = np.flatnonzero(correct == correct.max())
    return _between(ranked.levels, int(best[len(best) // 2]))


def _between(levels: np.ndarray, above: int) -> float:
    """A threshold that the first ``above`` of the falling levels exceed, and no other does."""
    if above == len(levels):
        return -np.inf
    lower = max(float(levels[above]), LOWEST)
    if above == 0:
        return lower
    upper = float(levels[above - 1])
    if np.isfinite(upper) and lower > LOWEST:
        middle = 0.5 * (upper + lower)
        return middle if lower <= middle < upper else lower
    return float(np.nextafter(upper, -np.inf)) if np.isfinite(upper) else lower


@dataclass(frozen=True)
class CrossValidated:
    """How well a threshold predicts trials that were not used to choose it.

    Attributes:
        threshold: the most accurate one on all trials.
        low, high: smallest and largest of the thresholds chosen for the folds.
        accuracy, true_positive_rate, true_negative_rate: of all folds together.
    """

    threshold: float
    low: float
    high: float
    accuracy: Proportion
    true_positive_rate: Proportion
    true_negative_rate: Proportion


def cross_validate(scores: np.ndarray, success: np.ndarray, fold: np.ndarray) -> CrossValidated:
    """Predict each fold with the threshold that is most accurate on the others.

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
        predicted[held_out] = exceeds(scores[held_out], threshold)
        chosen.append(threshold)
    good, bad = int(success.sum()), int((~success).sum())
    tp, tn = int((predicted & success).sum()), int((~predicted & ~success).sum())
    return CrossValidated(
        threshold=best_threshold(scores, success),
        low=min(chosen),
        high=max(chosen),
        accuracy=Proportion(tp + tn, len(scores)),
        true_positive_rate=Proportion(tp, good),
        true_negative_rate=Proportion(tn, bad),
    )


def threshold_for(scores: np.ndarray, success: np.ndarray, target: float) -> float:
    """Smallest threshold that at most a share ``target`` of the failures exceeds."""
    failing = np.sort(scores[~success])[::-1]
    allowed = int(np.floor(target * len(failing) + 1e-9))
    if allowed >= len(failing):
        return -np.inf
    return max(float(failing[allowed]), LOWEST)


@dataclass(frozen=True)
class Calibration:
    """Threshold for a desired false positive rate, and the true positive rate that is left.

    Attributes:
        targets: (k,) desired false positive rates.
        threshold, threshold_low, threshold_high: (k,) smallest threshold with at most that false
            positive rate on all trials, and its 95 % bootstrap band.
        tpr, tpr_low, tpr_high: (k,) true positive rate at that threshold, and its band.
        achieved: (k,) false positive rate on trials that were not used to choose the threshold.
    """

    targets: np.ndarray
    threshold: np.ndarray
    threshold_low: np.ndarray
    threshold_high: np.ndarray
    tpr: np.ndarray
    tpr_low: np.ndarray
    tpr_high: np.ndarray
    achieved: tuple[Proportion, ...]


def calibrate(
    scores: np.ndarray,
    success: np.ndarray,
    fold: np.ndarray,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
    targets: np.ndarray = TARGETS,
) -> Calibration | None:
    """Threshold for each desired false positive rate; None with fewer than ten of an outcome.

    Args:
        scores: (n,) without NaN.
        success: (n,) bool.
        fold: (n,) fold of each trial.
        rng, resamples: of the bootstrap, successes and failures separately.
        targets: (k,) desired false positive rates.
    """
    if min(success.sum(), (~success).sum()) < FEWEST:
        return None
    ranked = RankedScores.of(scores, success)
    threshold, tpr = _at_targets(ranked, None, targets)
    thresholds, tprs = [], []
    for weights in stratified_weights(success, rng, resamples):
        t, y = _at_targets(ranked, weights, targets)
        thresholds.append(t)
        tprs.append(y)
    # Nearest: a threshold may be -inf, which cannot be interpolated.
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
    ranked: RankedScores, weights: np.ndarray | None, targets: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Thresholds and true positive rates (r, k) for each row of weights."""
    good, bad = ranked.counts(weights)
    zero = np.zeros((len(good), 1), dtype=good.dtype)
    # Column j: trials strictly above level j; the last column: all trials.
    above_good = np.concatenate((zero, good), axis=1)
    above_bad = np.concatenate((zero, bad), axis=1)
    levels = np.append(np.maximum(ranked.levels, LOWEST), -np.inf)
    rows = np.arange(len(good))
    thresholds, rates = np.empty((2, len(good), len(targets)))
    for k, target in enumerate(targets):
        allowed = np.floor(target * bad[:, -1:] + 1e-9)
        last = (above_bad <= allowed).sum(axis=1) - 1
        thresholds[:, k] = levels[last]
        rates[:, k] = above_good[rows, last] / good[:, -1]
    return thresholds, rates


def _achieved(
    scores: np.ndarray, success: np.ndarray, fold: np.ndarray, target: float
) -> Proportion:
    passed = total = 0
    for k in np.unique(fold):
        held_out = (fold == k) & ~success
        threshold = threshold_for(scores[fold != k], success[fold != k], target)
        passed += int(exceeds(scores[held_out], threshold).sum())
        total += int(held_out.sum())
    return Proportion(passed, total)
