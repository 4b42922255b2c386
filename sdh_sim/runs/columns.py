"""The columns of a run's table, besides those that every table has."""

from __future__ import annotations

from sdh_sim.records import (
    Column,
    HandShape,
    added_columns,
    hand_columns,
    lift_off_columns,
    settling_columns,
)
from sdh_sim.settings import DEFAULT_HAND, TrialSettings


def columns_of_run(settings: TrialSettings) -> tuple[Column, ...]:
    """Those of its hand, where it is not the SDH-2, of users' metrics, of lift-off and settling.

    Raises:
        SettingsError: no such hand.
    """
    added = (*_of_hand(settings), *added_columns(settings.metrics))
    columns = (*added, *lift_off_columns(added)) if settings.lift_off else added
    if settings.settle == "none":
        return columns
    return (*columns, *settling_columns(added, settings.settle == "metrics"))


def _of_hand(settings: TrialSettings) -> tuple[Column, ...]:
    if settings.hand == DEFAULT_HAND and settings.hand_folder is None:
        return ()
    from sdh_sim.robot import hand_in, hand_kinematics  # what knows hands takes its time to load

    hand = hand_in(settings)
    counts = {kind: sum(pad.array.kind == kind for pad in hand.pads) for kind in hand.arrays}
    shapes = {kind: (counts[kind], *array.shape) for kind, array in hand.arrays.items()}
    kinematics = hand_kinematics(hand)
    joints = kinematics.model.nq if kinematics.passive else 0
    return hand_columns(HandShape(len(hand.motors), shapes, joints))
