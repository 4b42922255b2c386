"""From a tactile snapshot to contacts and tasks (sections II and III of the paper).

Everything is expressed in a frame with the object's axes and its origin at the centre of mass.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

import graspq as gq
from sdh_sim import sdh2_constants as c
from sdh_sim.hand import HandKinematics, live_mask, taxel_centres, torque_limits
from sdh_sim.object_shape import rotation_of
from sdh_sim.object_surface import surface_of
from sdh_sim.objects import ObjectInfo
from sdh_sim.pad_contact import PadContact
from sdh_sim.settings import TrialSettings
from sdh_sim.tactile import TactileSnapshot
from sdh_sim.unsensed import unsensed_contacts

TASK_RADIUS = 0.02 / 3  # [m]
TASK_SAMPLES = 20
GRAVITY = 9.81  # [m/s^2]
LOOK_DEPTH = 0.01  # beneath the pad's surface, in the finger [m]


@dataclass(frozen=True)
class PerceivedGrasp:
    """What a metric may know of a grasp.

    Attributes:
        snapshot: what the hand sensed.
        thing: the object as known: mass, friction, centre of mass.
        torque_limits: of the motors (7,) [N m].
        contacts: the pads in contact, object frame with its origin at the centre of mass.
        task: wrenches the hand must exert against gravity, same frame, (6, m) [N, N m].
        others: what touches besides ``contacts``: pads left out, and parts without taxels where
            geometry shows that they touch.
    """

    snapshot: TactileSnapshot
    thing: ObjectInfo
    torque_limits: np.ndarray
    contacts: tuple[PadContact, ...]
    task: np.ndarray
    others: tuple[PadContact, ...] = ()


def perceive(
    snapshot: TactileSnapshot,
    thing: ObjectInfo,
    torque_limit: tuple[float, float],
    pads: str,
    kinematics: HandKinematics,
) -> PerceivedGrasp:
    """Contacts and task of a snapshot; arguments as ``pad_contacts``."""
    every = pad_contacts(snapshot, thing, torque_limit, "all", kinematics)
    taken = [pads == "all" or contact.pad.endswith("distal") for contact in every]
    left_out = tuple(contact for contact, kept in zip(every, taken, strict=True) if not kept)
    return PerceivedGrasp(
        snapshot=snapshot,
        thing=thing,
        torque_limits=torque_limits(torque_limit),
        contacts=tuple(contact for contact, kept in zip(every, taken, strict=True) if kept),
        task=gravity_task(snapshot, thing),
        others=left_out + unsensed_contacts(snapshot, thing, kinematics),
    )


def misperceive(
    snapshot: TactileSnapshot,
    thing: ObjectInfo,
    settings: TrialSettings,
    rng: np.random.Generator,
) -> tuple[TactileSnapshot, ObjectInfo]:
    """The snapshot with the tracker's pose error, the object as misestimated (both may be exact).

    Args:
        snapshot: what the hand sensed, with the true pose.
        thing: the true object.
        settings: standard deviations of the errors.
        rng: always drawn from in the same way, so that one error does not change another.
    """
    shift, turn = rng.standard_normal(3), rng.standard_normal(3)
    friction, mass = rng.standard_normal(2)
    pose = snapshot.object_pose_hand.copy()
    pose[:3] += settings.position_error * shift
    # The tracker turns the object about its centre of mass: an error of rotation alone leaves
    # that in place.
    centre = rotation_of(pose[3:]) @ thing.com_m
    mujoco.mju_quatIntegrate(pose[3:], settings.angle_error * turn, 1.0)
    pose[:3] += centre - rotation_of(pose[3:]) @ thing.com_m
    known = replace(
        thing,
        friction=thing.friction * max(0.05, 1.0 + settings.friction_error * friction),
        mass_kg=thing.mass_kg * max(0.05, 1.0 + settings.mass_error * mass),
    )
    return replace(snapshot, object_pose_hand=pose), known


def pad_contacts(
    snapshot: TactileSnapshot,
    thing: ObjectInfo,
    torque_limit: tuple[float, float],
    pads: str,
    kinematics: HandKinematics,
    surface_share: float = 1.0,
) -> tuple[PadContact, ...]:
    """Contact model of every pad that reads something (II-B).

    Normals are those of the object's surface, as in the paper: rubber that meets an edge or lies
    askew presses along them, 15° off the pad's own normal on average.

    Args:
        snapshot: what the hand sensed.
        thing: shape, friction and centre of mass of the object.
        torque_limit: (spread and proximal, distal) [N m].
        pads: ``all`` or ``distal``.
        kinematics: the hand; its posture is changed.
        surface_share: 1 takes the normals of the object's surface, 0 the pads' own, and what lies
            between a mean of both.
    """
    kinematics.pose(snapshot.joint_angles)
    rotation, origin = rotation_of(snapshot.object_pose_hand[3:]), snapshot.object_pose_hand[:3]
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
        linear = kinematics.jacobian(body, link_position + link_rotation @ point)
        jacobian = np.vstack((rotation.T @ linear, rotation.T @ kinematics.spin_jacobian(body)))
        centre = to_object @ point + shift
        patch = taxels @ to_object.T + shift
        pressure = reading[reading > 0.0]
        inward = _surface_normal(thing, to_object @ normal, patch, pressure, surface_share)
        patch -= np.outer((patch - centre) @ inward, inward)
        g_max = gq.max_normal_force(jacobian[:3], inward, limits)
        tau_max = gq.max_torsion(thing.friction, g_max, pressure, patch, centre)
        contact = gq.Contact(centre, inward, thing.friction, g_max, tau_max, patch)
        found.append(PadContact(body, contact, jacobian))
    return tuple(found)


def _surface_normal(
    thing: ObjectInfo, own: np.ndarray, patch: np.ndarray, weights: np.ndarray, share: float
) -> np.ndarray:
    """Unit normal of the object's surface under a pad, into the object (3,).

    Every taxel looks for the nearest surface from inside the finger, so that neither a dent in the
    rubber nor a pose some millimetres off turns the answer round. Taxels whose nearest surface
    faces them do not count; where none is left the pad's own normal does.
    """
    own = own / np.linalg.norm(own)
    surface = surface_of(thing.name, thing.folder)
    found = surface.inward_normals(patch + thing.com_m - LOOK_DEPTH * own)
    mean = np.where(found @ own > 0.0, weights, 0.0) @ found
    length = float(np.linalg.norm(mean))
    if length <= 0.0:
        return own
    mixed = share * mean / length + (1.0 - share) * own
    return mixed / np.linalg.norm(mixed)


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
    hand = rotation_of(snapshot.hand_pose_world[3:])
    in_object = rotation_of(snapshot.object_pose_hand[3:]).T @ hand.T @ down
    return gq.gravity_tasks(thing.mass_kg, np.zeros(3), in_object, TASK_RADIUS, TASK_SAMPLES)
