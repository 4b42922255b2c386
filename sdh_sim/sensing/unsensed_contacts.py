"""Contacts that no taxel feels, found from what is known: the object's shape and pose, the hand.

Palm, link sides and the rubber beyond the border of an array hold objects too. Where they touch
follows from the joint angles and the tracked pose; how hard they press does not, so that only
bounds by the motors can use them.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

import graspq as gq
from sdh_sim.cell.contacts import contact_points
from sdh_sim.objects import ObjectInfo, object_spec
from sdh_sim.poses import rotation_of
from sdh_sim.robot import Hand, HandKinematics, HandPosture, taxel_names
from sdh_sim.sensing.hand_with_object import HandWithObject
from sdh_sim.sensing.pad_contact import PadContact
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.user_references import ObjectFolder

# Surfaces nearer than this count as touching: far more than the rounding of a stored pose, far less
# than what lies between parts that do not touch.
TOUCHING = 20e-6  # [m]


def unsensed_contacts(
    snapshot: TactileSnapshot, obj: ObjectInfo, kinematics: HandKinematics
) -> tuple[PadContact, ...]:
    """Where the hand touches the object and no taxel feels it, one contact per point.

    Args:
        snapshot: what the hand sensed, with the pose as the tracker has it.
        obj: the object.
        kinematics: the hand.

    Returns:
        contacts in the object's axes at its centre of mass, named by their link. Their normal
        force is not known: g* is infinite in truth and 0 in the contact.
    """
    joints = snapshot.joints
    if joints is None:
        joints = kinematics.joint_positions(snapshot.joint_angles)
    posture = kinematics.at(snapshot.joint_angles, joints)
    found = _shapes(kinematics.hand, obj.name, obj.folder).touching(
        joints, snapshot.object_pose_hand
    )
    return tuple(_contact(*contact, snapshot, obj, posture) for contact in found)


def _contact(
    link: str,
    point: np.ndarray,
    normal: np.ndarray,
    snapshot: TactileSnapshot,
    obj: ObjectInfo,
    posture: HandPosture,
) -> PadContact:
    rotation = rotation_of(snapshot.object_pose_hand[3:])
    centre_of_mass = snapshot.object_pose_hand[:3] + rotation @ obj.com_m
    linear, spin = posture.jacobian(link, point), posture.spin_jacobian(link)
    inward = rotation.T @ normal
    contact = gq.Contact(
        rotation.T @ (point - centre_of_mass), inward / np.linalg.norm(inward), obj.friction, 0.0
    )
    return PadContact(link, contact, np.vstack((rotation.T @ linear, rotation.T @ spin)))


class _Shapes(HandWithObject):
    """Collision shapes, and which of the hand's are the rubber of a pad."""

    def __init__(self, hand: Hand, name: str, folder: ObjectFolder | None) -> None:
        super().__init__(hand, object_spec(name, folder), TOUCHING)
        self._links = [self.model.body(int(body)).name for body in self.model.geom_bodyid]
        self._pads = hand.pads
        self._pad = np.full(self.model.ngeom, -1)  # per geom, index of the pad whose rubber it is
        for index, names in enumerate(taxel_names(hand)):
            self._pad[[self.model.geom(name).id for name in names if name]] = index

    def touching(
        self, joints: np.ndarray, pose: np.ndarray
    ) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Link, point (3,) [m] and unit normal into the object (3,), in the palm frame.

        Args:
            joints: all joint positions of the hand [rad].
            pose: of the object in the palm frame, x y z qw qx qy qz (7,).
        """
        self.pose_hand(joints)
        self.collide(pose)
        axes, origin = self.palm_axes, self.palm_pose[:3]
        found = contact_points(self.data, self.of_object)
        felt = self._felt(found)
        return [
            (self._links[part], axes.T @ (point - origin), axes.T @ normal)
            for (part, point, normal), by_taxels in zip(found, felt, strict=True)
            if not by_taxels
        ]

    def _felt(self, found: list[tuple[int, np.ndarray, np.ndarray]]) -> np.ndarray:
        """Which contacts, as ``contact_points`` gives them, act on a taxel (n,) bool."""
        felt = np.zeros(len(found), dtype=bool)
        if not found:
            return felt
        pads = self._pad[[part for part, _, _ in found]]
        for pad in np.unique(pads[pads >= 0]):
            here = np.flatnonzero(pads == pad)
            link = self.data.body(self._pads[pad].body)
            away = np.array([found[k][1] for k in here]) - link.xpos
            _, shares = self._pads[pad].array.shares(away @ link.xmat.reshape(3, 3))
            felt[here] = shares.any(axis=1)
        return felt


@lru_cache(maxsize=16)
def _shapes(hand: Hand, name: str, folder: ObjectFolder | None) -> _Shapes:
    return _Shapes(hand, name, folder)
