"""Grasps read back from a table of trials: any metric can be evaluated on them again.

Rows are dictionaries here, not ``TrialRow``: a table of an older version lacks columns, which is
not the same as a column without a value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from sdh_sim import records
from sdh_sim.objects import ObjectInfo, object_info
from sdh_sim.records import columns_of
from sdh_sim.robot import Hand, HandKinematics, built_in_hand, hand_kinematics
from sdh_sim.sensing import PerceivedGrasp, TactileSnapshot, perceive
from sdh_sim.settings import DEFAULT_HAND
from sdh_sim.user_references import ObjectFolder

_SNAPSHOT = ("joint_angles_rad", "motor_torque_nm", "object_pose_hand", "hand_pose_world")
_SDH2_ARRAYS = ("tactile_proximal", "tactile_distal")
_TRIAL = ("trial", "object", "seed", "success", "failure", "torque_limit_nm")


def read_stored(paths: Sequence[Path]) -> tuple[pa.Table, list[dict[str, Any]]]:
    """Tables of trials, one after the other, and their rows.

    A table of an older version need not have the columns that came later: the result has the
    columns that all of the tables have, those of later moments among them.

    Args:
        paths: of the tables.

    Returns:
        table, and for each trial its values by column name: arrays as numpy, null as None.

    Raises:
        RecordError: a table lacks what a snapshot consists of.
    """
    of_hand = records.hand_columns_of(paths)
    shared = columns_of(paths, (*records.SCHEMA.names, *of_hand))
    shared += records.moment_columns_of(paths)
    arrays = () if of_hand else _SDH2_ARRAYS
    names = list(dict.fromkeys((*_TRIAL, *_SNAPSHOT, *arrays, *shared)))
    table = pa.concat_tables([records.read_table(path, names) for path in paths])
    columns = {}
    for name in names:
        values = table.column(name).to_pylist()
        if records.column_named(name).shape:
            stacked = records.stack(table, name)
            values = [None if v is None else a for v, a in zip(values, stacked, strict=True)]
        columns[name] = values
    return table, [
        dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
    ]


def snapshot_of(row: Mapping[str, Any]) -> TactileSnapshot | None:
    """The snapshot of a row of the table, as the metrics got it.

    The pose is the tracker's where the row has one. Readings have the table's single precision,
    so that a metric evaluated again may differ from the stored one in its eighth digit or so.

    Args:
        row: a row as ``records.read_rows`` gives it.

    Returns:
        None where the trial ended before its snapshot.
    """
    if any(row.get(name) is None for name in _SNAPSHOT):
        return None
    pose = row.get("perceived_pose_hand")
    return TactileSnapshot(
        tactile={
            name.removeprefix(records.TACTILE): np.asarray(value, dtype=float)
            for name, value in row.items()
            if name.startswith(records.TACTILE) and value is not None
        },
        joint_angles=np.asarray(row["joint_angles_rad"], dtype=float),
        motor_torques=np.asarray(row["motor_torque_nm"], dtype=float),
        object_pose_hand=np.asarray(row["object_pose_hand"] if pose is None else pose, dtype=float),
        hand_pose_world=np.asarray(row["hand_pose_world"], dtype=float),
        gravity=row.get("gravity") or "",
        joints=row.get(records.JOINTS),
    )


def object_of(
    row: Mapping[str, Any], folders: Mapping[str, ObjectFolder] | None = None
) -> ObjectInfo:
    """The row's object with the mass and the friction that the metrics assumed.

    Args:
        row: a row as ``records.read_rows`` gives it.
        folders: of users' objects by name, as the run's plan has them.

    Raises:
        SettingsError: there is no such object any more.
    """
    obj = object_info(row["object"], (folders or {}).get(row["object"]))
    mass, friction = row.get("perceived_mass_kg"), row.get("perceived_friction")
    return replace(
        obj,
        mass_kg=obj.mass_kg if mass is None else mass,
        friction=obj.friction if friction is None else friction,
    )


def grasp_of(
    row: Mapping[str, Any],
    pads: str,
    kinematics: HandKinematics | None = None,
    folders: Mapping[str, ObjectFolder] | None = None,
    threshold: float | None = None,
) -> PerceivedGrasp | None:
    """The row's grasp as the metrics got it; None where the trial ended before its snapshot.

    Args:
        row: a row as ``records.read_rows`` gives it.
        pads: ``all`` or ``distal``.
        kinematics: the hand; None takes the built-in one that the row names.
        folders: of users' objects by name, as the run's plan has them.
        threshold: share of its pad's largest reading that a taxel must exceed to count; None
            takes the row's. Where a table of an older version has none every reading counts.

    Raises:
        SettingsError: there is no such object any more.
    """
    snapshot = snapshot_of(row)
    if snapshot is None:
        return None
    kinematics = kinematics or hand_kinematics(hand_of(row))
    share = row.get("taxel_threshold") or 0.0 if threshold is None else threshold
    limits = kinematics.hand.group_limits(row["torque_limit_nm"])
    return perceive(snapshot, object_of(row, folders), limits, pads, kinematics, share)


def hand_of(row: Mapping[str, Any]) -> Hand:
    """The hand of a row; raises SettingsError where there is no such hand any more."""
    return built_in_hand(row.get(records.HAND_NAME) or DEFAULT_HAND)


def at_lift_off(row: Mapping[str, Any]) -> dict[str, Any] | None:
    """The row with its second snapshot in the place of the first.

    Args:
        row: a row as ``records.read_rows`` gives it.

    Returns:
        None where no snapshot was taken at lift-off.
    """
    later = {
        name.removeprefix(records.LIFT_OFF): value
        for name, value in row.items()
        if name.startswith(records.LIFT_OFF)
    }
    if later.get("object_pose_hand") is None:
        return None
    return {**row, **later}
