"""The columns of a run's table, besides those that every table has."""

from __future__ import annotations

from sdh_sim.records import Column, HandShape, added_columns, hand_columns
from sdh_sim.settings import DEFAULT_HAND, TrialSettings


def columns_of_run(settings: TrialSettings) -> tuple[Column, ...]:
    """Those of its hand, where it is not the SDH-2, and those of users' metrics.

    Raises:
        SettingsError: no such hand.
    """
    metrics = added_columns(settings.metrics)
    if settings.hand == DEFAULT_HAND and settings.hand_folder is None:
        return metrics
    from sdh_sim.robot import hand_in, hand_kinematics  # what knows hands takes its time to load

    hand = hand_in(settings)
    counts = {kind: sum(pad.array.kind == kind for pad in hand.pads) for kind in hand.arrays}
    shapes = {kind: (counts[kind], *array.shape) for kind, array in hand.arrays.items()}
    kinematics = hand_kinematics(hand)
    joints = kinematics.model.nq if kinematics.passive else 0
    return (*hand_columns(HandShape(len(hand.motors), shapes, joints)), *metrics)
