"""Contacts that no taxel feels, found from what is known: the object's shape and pose, the hand.

Palm, link sides and the rubber beyond the border of an array hold objects too. Where they touch
follows from the joint angles and the tracked pose; how hard they press does not, so that only
bounds by the motors can use them.
"""

from __future__ import annotations

from functools import lru_cache

import mujoco
import numpy as np

import graspq as gq
from sdh_sim import poses
from sdh_sim.cell.contacts import contact_points
from sdh_sim.objects import OBJECT, ObjectInfo, object_spec
from sdh_sim.poses import rotation_of
from sdh_sim.robot import Hand, HandKinematics, HandPosture, hand_spec, taxel_names
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


class _Shapes:
    """Collision shapes of a hand and of one object."""

    def __init__(self, hand: Hand, name: str, folder: ObjectFolder | None) -> None:
        spec = hand_spec(hand)
        frame = spec.worldbody.add_frame()
        spec.attach(object_spec(name, folder), prefix=OBJECT, frame=frame)
        spec.body(f"{OBJECT}object").add_freejoint(name="free")
        self._model = model = spec.compile()
        self._data = mujoco.MjData(model)
        owner = [model.body(int(body)).name for body in model.geom_bodyid]
        self._of_object = np.array([body.startswith(OBJECT) for body in owner])
        self._link = owner
        self._pads = hand.pads
        self._pad = np.full(model.ngeom, -1)  # per geom, index of the pad whose rubber it is
        for index, names in enumerate(taxel_names(hand)):
            self._pad[[model.geom(name).id for name in names if name]] = index
        model.geom_margin[~self._of_object] = TOUCHING
        free = int(model.joint("free").qposadr[0])
        self._free = slice(free, free + 7)
        self._hand = slice(0, free)
        self._palm = model.body(hand.palm).id

    def touching(
        self, joints: np.ndarray, pose: np.ndarray
    ) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Link, point (3,) [m] and unit normal into the object (3,), in the palm frame.

        Args:
            joints: all joint positions of the hand [rad].
            pose: of the object in the palm frame, x y z qw qx qy qz (7,).
        """
        model, data = self._model, self._data
        data.qpos[self._hand] = joints
        mujoco.mj_kinematics(model, data)
        palm = poses.body_pose(data, self._palm)
        data.qpos[self._free] = poses.compose(palm, pose)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        axes = data.xmat[self._palm].reshape(3, 3)
        found = contact_points(data, self._of_object)
        felt = self._felt(found)
        return [
            (self._link[part], axes.T @ (point - palm[:3]), axes.T @ normal)
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
            link = self._data.body(self._pads[pad].body)
            away = np.array([found[k][1] for k in here]) - link.xpos
            _, shares = self._pads[pad].array.shares(away @ link.xmat.reshape(3, 3))
            felt[here] = shares.any(axis=1)
        return felt


@lru_cache(maxsize=16)
def _shapes(hand: Hand, name: str, folder: ObjectFolder | None) -> _Shapes:
    return _Shapes(hand, name, folder)
