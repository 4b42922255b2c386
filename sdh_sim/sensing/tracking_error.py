"""What a tracker and a scale get wrong: errors of pose, friction and mass that the metrics see."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from sdh_sim.objects import ObjectInfo
from sdh_sim.poses import rotation_of
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.settings import TrialSettings


@dataclass(frozen=True)
class TrackingErrors:
    """Standard deviations of what a tracker and a scale get wrong, named as a trial's settings.

    Attributes:
        position_error: of the object's position along each axis [m].
        angle_error: of its rotation about each axis [rad].
        friction_error: of the friction, relative.
        mass_error: of the mass, relative.
    """

    position_error: float = 0.0
    angle_error: float = 0.0
    friction_error: float = 0.0
    mass_error: float = 0.0


def add_tracking_error(
    snapshot: TactileSnapshot,
    obj: ObjectInfo,
    settings: TrialSettings | TrackingErrors,
    rng: np.random.Generator,
) -> tuple[TactileSnapshot, ObjectInfo]:
    """The snapshot with the tracker's pose error, and the object as it is estimated.

    Args:
        snapshot: what the hand sensed, with the true pose.
        obj: the true object.
        settings: standard deviations of the errors.
        rng: always drawn from in the same way, so that one error does not change another.
    """
    shift, turn = rng.standard_normal(3), rng.standard_normal(3)
    friction, mass = rng.standard_normal(2)
    pose = snapshot.object_pose_hand.copy()
    pose[:3] += settings.position_error * shift
    # The tracker turns the object about its centre of mass: an error of rotation alone leaves
    # that in place.
    centre = rotation_of(pose[3:]) @ obj.com_m
    mujoco.mju_quatIntegrate(pose[3:], settings.angle_error * turn, 1.0)
    pose[:3] += centre - rotation_of(pose[3:]) @ obj.com_m
    known = replace(
        obj,
        friction=obj.friction * max(0.05, 1.0 + settings.friction_error * friction),
        mass_kg=obj.mass_kg * max(0.05, 1.0 + settings.mass_error * mass),
    )
    return replace(snapshot, object_pose_hand=pose), known
