"""What the row of a trial says of a snapshot and of the metrics on it."""

from __future__ import annotations

from sdh_sim.records import JOINTS, TACTILE, TrialRow
from sdh_sim.sensing import TactileSnapshot


def describe_snapshot(
    row: TrialRow, snapshot: TactileSnapshot, forces: tuple[float, float]
) -> None:
    """Set the columns of what the hand sensed.

    Args:
        row: of the trial, or of a moment of it.
        snapshot: what was sensed, with the true pose.
        forces: on the object, that taxels feel and that none does [N].
    """
    for kind, readings in snapshot.tactile.items():
        row[TACTILE + kind] = readings
    row.joint_angles_rad = snapshot.joint_angles
    if snapshot.joints is not None:
        row[JOINTS] = snapshot.joints
    row.motor_torque_nm = snapshot.motor_torques
    row.object_pose_hand = snapshot.object_pose_hand
    row.hand_pose_world = snapshot.hand_pose_world
    row.sensed_force_n, row.unsensed_force_n = forces
    row.unsensed_contact = row.unsensed_force_n > 0.0
