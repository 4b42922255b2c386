"""The predictors that the study compares: the metrics' variants, and baselines without wrenches."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from experiments.success_prediction import baselines
from experiments.success_prediction.metric_grid import Variant
from experiments.success_prediction.metric_scores import Candidate, folds_and_outcomes


def wrench_candidates(values: Mapping[Variant, np.ndarray]) -> list[Candidate]:
    """The metrics as predictors."""
    return [
        Candidate(
            group=v.group,
            assumes=v.assumes,
            pads=v.pads,
            scores=scores,
            boundary=1.0 if v.has_boundary else None,
            drop_missing=v.kind == "volume",
            is_load=v.has_boundary,
        )
        for v, scores in values.items()
    ]


def plain_candidates(rows: Sequence[Mapping[str, Any]], table: pa.Table) -> list[Candidate]:
    """Predictors without wrenches; the learned ones where scikit-learn is installed."""
    found = []
    for pads, kinds in (("distal", baselines.PAD_KINDS[:1]), ("all", baselines.PAD_KINDS)):
        for text, function in (
            ("sum of readings", baselines.sum_of_readings),
            ("number of pads in contact", baselines.pads_in_contact),
            ("number of active taxels", baselines.active_taxels),
        ):
            scores = np.array([function(row, kinds) for row in rows])
            found.append(Candidate("no wrenches", text, pads, scores))
    if not baselines.has_learning():
        print("without scikit-learn (the extra 'learn'): no logistic regression", file=sys.stderr)
        return found
    tactile, joints, known = (
        of(rows)
        for of in (
            *(baselines.tactile_features, baselines.joint_features),
            baselines.object_features,
        )
    )
    for text, features in (
        ("tactile", (tactile,)),
        ("tactile and joints", (tactile, joints)),
        ("tactile, joints, object pose", (tactile, joints, known)),
    ):
        for unseen in (False, True):
            scores = _learn(np.hstack(features), table, unseen)
            if scores is not None:
                words = text + (", unseen objects" if unseen else "")
                found.append(Candidate("logistic regression", words, "all", scores, boundary=0.5))
    return found


def _learn(features: np.ndarray, table: pa.Table, unseen: bool) -> np.ndarray | None:
    """Each grasp's score by a model trained on the other folds; None with too few outcomes.

    Args:
        features: (n, d).
        table: of the trials.
        unseen: train on the other objects instead of on the other random folds; None is given
            where there is one object alone.
    """
    success, usable, fold = folds_and_outcomes(table)
    if unseen:
        names = table.column("object").to_pylist()
        fold = np.unique(names, return_inverse=True)[1]
    if not baselines.can_learn(success[usable], fold[usable]):
        return None
    scores = np.full(len(success), np.nan)
    scores[usable] = baselines.logistic_scores(features[usable], success[usable], fold[usable])
    return scores
