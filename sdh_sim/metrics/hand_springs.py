"""What metrics of the hand's posture and compliance take from a perceived grasp."""

from __future__ import annotations

import numpy as np

import graspq as gq
from sdh_sim.metrics.contact_points import length_of
from sdh_sim.robot import HandKinematics
from sdh_sim.sensing import PadContact, PerceivedGrasp
from sdh_sim.settings import TrialSettings

# The rubber that trials have unless their settings say otherwise [Pa], [m].
MODULUS, THICKNESS = TrialSettings.pad_modulus, TrialSettings.pad_thickness


def kinematics_of(grasp: PerceivedGrasp) -> HandKinematics:
    """The hand of a grasp; raises ``graspq.GraspError`` where it is not known."""
    if grasp.kinematics is None:
        raise gq.GraspError(
            "kinematics: the perceived grasp has none; make it with perceive(...), or give "
            "PerceivedGrasp kinematics=hand_kinematics(hand)"
        )
    return grasp.kinematics


def point_hand(grasp: PerceivedGrasp) -> gq.HandBound:
    """The contacts behind their shared motors, each a soft point at its centre."""
    contacts = [_point(pad.contact) for pad in grasp.contacts]
    return gq.HandBound(
        contacts,
        [pad.jacobian for pad in grasp.contacts],
        grasp.torque_limits,
        transmission=grasp.transmission,
    )


def servo_stiffness(grasp: PerceivedGrasp) -> np.ndarray:
    """Gains of the motors' position servos in the hand's model (k,) [N m/rad or N/m]."""
    kinematics = kinematics_of(grasp)
    motors = [kinematics.model.actuator(name).id for name in kinematics.hand.motor_names]
    return kinematics.model.actuator_gainprm[motors, 0].copy()


def rubber_stiffness(grasp: PerceivedGrasp) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness of every contact's rubber: (n,) [N/m] alike in all directions, (n,) [N m/rad].

    Each taxel that counts is a column of rubber of stiffness E pitch² / thickness, as in the
    simulation; about the normal they turn around the contact's centre.
    """
    pads = {pad.name: pad.array.pitch for pad in kinematics_of(grasp).hand.pads}
    straight, twist = [], []
    for pad in grasp.contacts:
        column = MODULUS * pads[pad.pad] ** 2 / THICKNESS
        arms = _patch(pad) - pad.contact.position
        straight.append(column * len(arms))
        # One taxel alone turns about its own axis: a square column's second moment.
        own = len(arms) * pads[pad.pad] ** 2 / 6.0
        twist.append(column * (float((arms**2).sum()) + own))
    return np.array(straight), np.array(twist)


def compliant_grasp(grasp: PerceivedGrasp) -> gq.CompliantGrasp:
    """Contacts with the springs of their rubber and servos; the length is ``length_of``."""
    straight, twist = rubber_stiffness(grasp)
    return gq.CompliantGrasp(
        point_hand(grasp), straight, servo_stiffness(grasp), length_of(grasp), twist
    )


def weight_wrenches(grasp: PerceivedGrasp) -> np.ndarray:
    """What holds the weight at the centre of mass, once per direction of the weight (d, 6)."""
    forces = np.unique(np.round(grasp.task[:3].T, 12), axis=0)
    return np.hstack([forces, np.zeros_like(forces)])


def scaled_jacobian(grasp: PerceivedGrasp) -> np.ndarray:
    """Motor speeds to velocities of the contacts' centres over ``length_of`` (3 n, motors)."""
    hand = point_hand(grasp)
    return np.vstack([jacobian[0] for jacobian in hand.jacobians]) / length_of(grasp)


def _point(contact: gq.Contact) -> gq.Contact:
    return gq.Contact(
        contact.position,
        contact.normal,
        contact.friction,
        contact.max_normal_force,
        contact.max_torsion if contact.max_normal_force > 0.0 else 0.0,
    )


def _patch(pad: PadContact) -> np.ndarray:
    contact = pad.contact
    return contact.position[None] if contact.patch is None else contact.patch
