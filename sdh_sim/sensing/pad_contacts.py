"""Contacts of the pads with the object, as the hand perceives them (section II-B of the paper)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import graspq as gq
from sdh_sim.objects import ObjectInfo, surface_of
from sdh_sim.poses import rotation_of
from sdh_sim.robot import HandKinematics, TaxelArray
from sdh_sim.sensing.pad_contact import PadContact
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.settings import TAXEL_THRESHOLD

LOOK_DEPTH = 0.01  # beneath the pad's surface, in the finger [m]


def pad_contacts(
    snapshot: TactileSnapshot,
    obj: ObjectInfo,
    torque_limit: Sequence[float],
    pads: str,
    kinematics: HandKinematics,
    surface_share: float = 1.0,
    threshold: float = TAXEL_THRESHOLD,
) -> tuple[PadContact, ...]:
    """Contact model of every pad that reads something (II-B).

    g*, equation (6), is the largest normal force that the motors can bear at that contact alone,
    passive joints kept still.

    Normals are those of the object's surface, as in the paper: rubber that meets an edge or lies
    askew presses along them, 15° off the pad's own normal on average.

    Args:
        snapshot: what the hand sensed.
        obj: shape, friction and centre of mass of the object.
        torque_limit: of the groups of motors [N m or N].
        pads: ``all`` or the kind of array whose pads count.
        kinematics: the hand.
        surface_share: 1 takes the normals of the object's surface, 0 the pads' own, and what lies
            between a mean of both.
        threshold: share of its pad's largest reading that a taxel must exceed to count. Crosstalk
            lights taxels that touch nothing, and every one that counts exerts force.
    """
    posture = kinematics.at(snapshot.joint_angles, snapshot.joints)
    rotation, origin = rotation_of(snapshot.object_pose_hand[3:]), snapshot.object_pose_hand[:3]
    centre_of_mass = origin + rotation @ obj.com_m
    limits = kinematics.hand.torque_limits(torque_limit)
    found = []
    readings = {kind: iter(arrays) for kind, arrays in snapshot.tactile.items()}
    for pad in kinematics.hand.pads:
        reading = np.where(pad.array.live, next(readings[pad.array.kind]), 0.0)
        reading = np.where(reading > threshold * reading.max(), reading, 0.0)
        if pads not in ("all", pad.array.kind) or not (reading > 0.0).any():
            continue
        body = pad.body
        link_position, link_rotation = posture.link(body)
        point, normal, taxels = _tangent_patch(pad.array, reading)
        to_object = rotation.T @ link_rotation
        shift = rotation.T @ (link_position - centre_of_mass)
        linear = posture.jacobian(body, link_position + link_rotation @ point)
        jacobian = np.vstack((rotation.T @ linear, rotation.T @ posture.spin_jacobian(body)))
        centre = to_object @ point + shift
        patch = taxels @ to_object.T + shift
        pressure = reading[reading > 0.0]
        inward = _surface_normal(obj, to_object @ normal, patch, pressure, surface_share)
        patch -= np.outer((patch - centre) @ inward, inward)
        g_max = gq.max_normal_force(posture.of_motors(jacobian[:3]), inward, limits)
        tau_max = gq.max_torsion(obj.friction, g_max, pressure, patch, centre)
        contact = gq.Contact(centre, inward, obj.friction, g_max, tau_max, patch)
        found.append(PadContact(pad.name, contact, jacobian))
    return tuple(found)


def _surface_normal(
    obj: ObjectInfo, own: np.ndarray, patch: np.ndarray, weights: np.ndarray, share: float
) -> np.ndarray:
    """Unit normal of the object's surface under a pad, into the object (3,).

    Every taxel looks for the nearest surface from inside the finger, so that neither a dent in the
    rubber nor a pose some millimetres off turns the answer round. Taxels whose nearest surface
    faces them do not count; where none is left the pad's own normal does.
    """
    own = own / np.linalg.norm(own)
    surface = surface_of(obj.name, obj.folder)
    found = surface.inward_normals(patch + obj.com_m - LOOK_DEPTH * own)
    mean = np.where(found @ own > 0.0, weights, 0.0) @ found
    length = float(np.linalg.norm(mean))
    if length <= 0.0:
        return own
    mixed = share * mean / length + (1.0 - share) * own
    return mixed / np.linalg.norm(mixed)


def _tangent_patch(
    array: TaxelArray, reading: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pressure-weighted centre on the pad, its normal, and active taxels in the tangent plane.

    Returns:
        point (3,) [m], unit normal (3,) out of the pad, taxels (k, 3) [m], all in the link frame.
    """
    rows, columns = np.nonzero(reading > 0.0)
    weight = reading[rows, columns]
    # The mean in the array's own coordinates stays on the curved pad; a mean in space would not.
    point, normal = array.surface(
        float(np.average(rows, weights=weight)), float(np.average(columns, weights=weight))
    )
    centres = array.centres[rows, columns]
    return point, normal, centres - np.outer((centres - point) @ normal, normal)
