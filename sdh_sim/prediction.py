"""From a tactile snapshot to contacts and task scaling factors (sections II and III of the paper).

Everything is expressed in a frame with the object's axes and its origin at the centre of mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

import graspq as gq
from sdh_sim import sdh2_constants as c
from sdh_sim.hand import HandKinematics, live_mask, taxel_centres, torque_limits
from sdh_sim.objects import ObjectInfo
from sdh_sim.tactile import TactileSnapshot

EDGES = 12
AUGMENT = "hf"
TASK_RADIUS = 0.02 / 3  # [m]
TASK_SAMPLES = 20
GRAVITY = 9.81  # [m/s^2]


@dataclass(frozen=True)
class PadContact:
    """One pad's contact as the hand perceives it.

    Attributes:
        pad: name, such as ``thumb_distal``.
        contact: position, normal, g*, tau* and taxels, in the object frame at the centre of mass.
        jacobian: of the contact point, object axes (3, 7) [m/rad].
    """

    pad: str
    contact: gq.Contact
    jacobian: np.ndarray


@dataclass(frozen=True)
class Prediction:
    """Task scaling factors of a snapshot.

    Attributes:
        q_linf, q_l1: equations (9) and (10); 0 when the grasp cannot exert the task.
        reason: why a value is 0, empty otherwise.
        contacts: the pads in contact.
    """

    q_linf: float
    q_l1: float
    reason: str
    contacts: tuple[PadContact, ...]


def pad_contacts(
    snapshot: TactileSnapshot,
    thing: ObjectInfo,
    torque_limit: tuple[float, float],
    pads: str,
    kinematics: HandKinematics,
) -> tuple[PadContact, ...]:
    """Contact model of every pad that reads something (II-B).

    Args:
        snapshot: what the hand sensed.
        thing: friction and centre of mass of the object.
        torque_limit: (spread and proximal, distal) [N m].
        pads: ``all`` or ``distal``.
        kinematics: the hand; its posture is changed.
    """
    kinematics.pose(snapshot.joint_angles)
    rotation, origin = _matrix(snapshot.object_pose_hand[3:]), snapshot.object_pose_hand[:3]
    centre_of_mass = origin + rotation @ thing.com_m
    limits = torque_limits(torque_limit)
    found = []
    for index, (finger, kind) in enumerate(c.PADS):
        if pads == "distal" and kind != "distal":
            continue
        array = (snapshot.proximal if kind == "proximal" else snapshot.distal)[index % 3]
        reading = np.where(live_mask(kind), array, 0.0)
        if not (reading > 0.0).any():
            continue
        body = f"{finger}_{kind}"
        link_position, link_rotation = kinematics.link(body)
        point, normal, taxels = _tangent_patch(kind, reading)
        to_object = rotation.T @ link_rotation
        shift = rotation.T @ (link_position - centre_of_mass)
        jacobian = rotation.T @ kinematics.jacobian(body, link_position + link_rotation @ point)
        inward = to_object @ normal
        inward /= np.linalg.norm(inward)
        g_max = gq.max_normal_force(jacobian, inward, limits)
        centre = to_object @ point + shift
        patch = taxels @ to_object.T + shift
        tau_max = gq.max_torsion(thing.friction, g_max, reading[reading > 0.0], patch, centre)
        contact = gq.Contact(centre, inward, thing.friction, g_max, tau_max, patch)
        found.append(PadContact(body, contact, jacobian))
    return tuple(found)


def _tangent_patch(kind: str, reading: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pressure-weighted centre on the pad, its normal, and active taxels in the tangent plane.

    Returns:
        point (3,) [m], unit normal (3,) out of the pad, taxels (k, 3) [m], all in the link frame.
    """
    rows, columns = np.nonzero(reading > 0.0)
    weight = reading[rows, columns]
    # The mean in the array's own coordinates stays on the curved pad; a mean in space would not.
    point, normal = c.pad_surface(
        kind, float(np.average(rows, weights=weight)), float(np.average(columns, weights=weight))
    )
    centres = taxel_centres(kind)[rows, columns]
    return point, normal, centres - np.outer((centres - point) @ normal, normal)


def gravity_task(snapshot: TactileSnapshot, thing: ObjectInfo) -> np.ndarray:
    """Wrenches that hold the object against gravity around its centre of mass, (6, m)."""
    down = np.array([0.0, 0.0, -GRAVITY])
    hand = _matrix(snapshot.hand_pose_world[3:])
    in_object = _matrix(snapshot.object_pose_hand[3:]).T @ hand.T @ down
    return gq.gravity_tasks(thing.mass_kg, np.zeros(3), in_object, TASK_RADIUS, TASK_SAMPLES)


def predict(
    snapshot: TactileSnapshot,
    thing: ObjectInfo,
    torque_limit: tuple[float, float],
    pads: str,
    kinematics: HandKinematics,
) -> Prediction:
    """q* under both bounds from the snapshot and the known object; arguments as pad_contacts."""
    contacts = pad_contacts(snapshot, thing, torque_limit, pads, kinematics)
    if not contacts:
        return Prediction(0.0, 0.0, "no pad reads a contact", ())
    sets = [gq.contact_wrenches(p.contact, edges=EDGES, augment=AUGMENT) for p in contacts]
    task = gravity_task(snapshot, thing)
    linf = gq.task_scaling(sets, task, bound="linf")
    l1 = gq.task_scaling(sets, task, bound="l1")
    return Prediction(linf.value, l1.value, linf.reason or l1.reason or "", contacts)


def _matrix(quat: np.ndarray) -> np.ndarray:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quat, dtype=float))
    return matrix.reshape(3, 3)
