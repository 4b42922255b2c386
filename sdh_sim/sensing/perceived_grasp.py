"""From a tactile snapshot to contacts and tasks (sections II and III of the paper).

Everything is expressed in a frame with the object's axes and its origin at the centre of mass.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

import graspq as gq
from sdh_sim.objects import ObjectInfo
from sdh_sim.poses import rotation_of
from sdh_sim.robot import HandKinematics, built_in_hand, hand_kinematics
from sdh_sim.sensing.pad_contact import PadContact
from sdh_sim.sensing.pad_contacts import pad_contacts
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.sensing.unsensed_contacts import unsensed_contacts
from sdh_sim.sensing.weight_directions import GRAVITY, directions_of, unit_vector
from sdh_sim.settings import TAXEL_THRESHOLD

TASK_RADIUS = 0.02 / 3  # [m]
TASK_SAMPLES = 20


@dataclass(frozen=True)
class PerceivedGrasp:
    """What a metric may know of a grasp.

    Attributes:
        snapshot: what the hand sensed.
        obj: the object as known: mass, friction, centre of mass.
        torque_limits: of the motors (n,) [N m or N].
        contacts: the pads in contact, object frame with its origin at the centre of mass.
        task: wrenches the hand must exert against gravity, same frame, (6, m) [N, N m].
        others: what touches besides ``contacts``: pads left out, and what geometry shows to touch
            where no taxel feels it, on parts without taxels and beyond the border of an array.
        transmission: moment arms of the motors about the columns of the contacts' Jacobians
            (motors, columns); None: the columns are the motors.
        kinematics: the hand, whose motors' ranges and servos some metrics need; None: not known.
            Copies share it; pickled, a built-in hand is its name, a user's is not known any more.
        pads: whose readings made ``contacts``: ``all``, or the kind of array.
        threshold: share of its pad's largest reading that a taxel had to exceed to count.
    """

    snapshot: TactileSnapshot
    obj: ObjectInfo
    torque_limits: np.ndarray
    contacts: tuple[PadContact, ...]
    task: np.ndarray
    others: tuple[PadContact, ...] = ()
    transmission: np.ndarray | None = None
    kinematics: HandKinematics | None = None
    pads: str = "all"
    threshold: float = TAXEL_THRESHOLD

    def __deepcopy__(self, memo: dict[int, Any]) -> PerceivedGrasp:
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        shared = {"kinematics": values.pop("kinematics")}
        return type(self)(**copy.deepcopy(values, memo), **shared)

    def __getstate__(self) -> dict[str, Any]:
        hand = self.kinematics.hand if self.kinematics else None
        name = hand.name if hand and hand.folder is None else None
        return self.__dict__ | {"kinematics": name}

    def __setstate__(self, state: dict[str, Any]) -> None:
        name = state["kinematics"]
        known = hand_kinematics(built_in_hand(name)) if name is not None else None
        self.__dict__.update(state | {"kinematics": known})

    @property
    def thing(self) -> ObjectInfo:
        """The object, by the name that earlier versions had; use ``obj``."""
        return self.obj


def perceive(
    snapshot: TactileSnapshot,
    obj: ObjectInfo,
    torque_limit: Sequence[float],
    pads: str,
    kinematics: HandKinematics | None = None,
    threshold: float = TAXEL_THRESHOLD,
) -> PerceivedGrasp:
    """Contacts and task of a snapshot.

    Args:
        snapshot: what the hand sensed.
        obj: shape, mass, friction and centre of mass of the object.
        torque_limit: of the groups of motors [N m or N].
        pads: whose readings make ``contacts``: ``all``, or the kind of array.
        kinematics: the hand; None takes the one of the process.
        threshold: share of its pad's largest reading that a taxel must exceed to count.
    """
    kinematics = kinematics or hand_kinematics()
    every = pad_contacts(snapshot, obj, torque_limit, "all", kinematics, threshold=threshold)
    kinds = {pad.name: pad.array.kind for pad in kinematics.hand.pads}
    taken = [pads in ("all", kinds[contact.pad]) for contact in every]
    left_out = tuple(contact for contact, kept in zip(every, taken, strict=True) if not kept)
    return PerceivedGrasp(
        snapshot=snapshot,
        obj=obj,
        torque_limits=kinematics.hand.torque_limits(torque_limit),
        contacts=tuple(contact for contact, kept in zip(every, taken, strict=True) if kept),
        task=gravity_task(snapshot, obj),
        others=left_out + unsensed_contacts(snapshot, obj, kinematics),
        transmission=kinematics.transmission(snapshot.joint_angles, snapshot.joints),
        kinematics=kinematics,
        pads=pads,
        threshold=threshold,
    )


def gravity_task(
    snapshot: TactileSnapshot, obj: ObjectInfo, radius: float | None = None
) -> np.ndarray:
    """Wrenches that hold the object's weight around its centre of mass, (6, m).

    Where the weight acts along several directions in turn, those of all of them.

    Args:
        snapshot: with the directions.
        obj: mass and centre of mass.
        radius: within which the centre of mass lies [m]; None: ``TASK_RADIUS``.
    """
    if radius is None:
        radius = TASK_RADIUS
    if snapshot.gravity:
        weights = [GRAVITY * unit_vector(name) for name in directions_of(snapshot.gravity)]
    else:
        down = np.array([0.0, 0.0, -GRAVITY])
        hand = rotation_of(snapshot.hand_pose_world[3:])
        weights = [rotation_of(snapshot.object_pose_hand[3:]).T @ hand.T @ down]
    return np.hstack(
        [
            gq.gravity_tasks(obj.mass_kg, np.zeros(3), weight, radius, TASK_SAMPLES)
            for weight in weights
        ]
    )
