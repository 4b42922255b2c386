"""MuJoCo's contacts decoded, here and nowhere else: which parts touch, where, with what force.

A contact of MuJoCo names two geoms; the first axis of its frame points from the first to the
second. It bears force only where the constraint solver has a row for it (``efc_address >= 0``).
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim.cell.scene import ARM_GEOM, GROUP_NAMES, HAND_GEOM, OBJECT_GEOM, TABLE_GEOM, Scene


def touching(scene: Scene, data: mujoco.MjData, first: int, second: int) -> np.ndarray:
    """Which contacts are between geoms of two groups, bearing force or not (ncon,) bool."""
    groups = np.sort(scene.geom_group[data.contact.geom], axis=1)
    return (groups == sorted((first, second))).all(axis=1)


def object_on_table(scene: Scene, data: mujoco.MjData) -> bool:
    """Whether the object touches the table."""
    return bool(touching(scene, data, OBJECT_GEOM, TABLE_GEOM).any())


def robot_touches(scene: Scene, data: mujoco.MjData) -> str:
    """What the hand or the arm touches, itself included: a name of GROUP_NAMES, or nothing."""
    groups = np.sort(scene.geom_group[data.contact.geom], axis=1)
    touching = groups[np.isin(groups[:, 1], (HAND_GEOM, ARM_GEOM))]
    return GROUP_NAMES[int(touching[0, 0])] if len(touching) else ""


class HandContact(NamedTuple):
    """A contact of the hand.

    Attributes:
        finger: index of the finger, -1: no finger. Where the hand touches itself it is that of the
            first of its two parts that is one.
        group: of what is touched, an index of GROUP_NAMES.
        normal: of the contact in the world, in either sense (3,).
    """

    finger: int
    group: int
    normal: np.ndarray


def hand_contacts(scene: Scene, data: mujoco.MjData) -> list[HandContact]:
    """Where the hand touches anything, itself included, bearing force or not."""
    contact = data.contact
    groups, fingers = scene.geom_group[contact.geom], scene.geom_finger[contact.geom]
    found = []
    for k in np.flatnonzero((groups == HAND_GEOM).any(axis=1)):
        own = int(groups[k, 0] != HAND_GEOM)  # which of the two geoms is the hand's
        if groups[k, 1 - own] == HAND_GEOM and fingers[k, own] < 0:
            own = 1 - own
        normal = contact.frame[k, :3].copy()
        found.append(HandContact(int(fingers[k, own]), int(groups[k, 1 - own]), normal))
    return found


class RubberContacts(NamedTuple):
    """Contacts of the pads' rubber that bear force, and the taxels that feel them.

    The spheres that stand for the rubber are larger than a taxel, so a contact may lie off the
    taxel whose sphere makes it: by some millimetres where the surface that it meets lies askew,
    or at an edge. It is felt where it acts; what acts beyond the array's border no taxel feels
    itself, though crosstalk may light the ones beside it.

    Attributes:
        contact: index of the contact (n,).
        normal: its normal force (n,) [N].
        taxels: flat indices of the taxels around it (n, 4).
        shares: of its force that they feel (n, 4), which sum to 1 or, off the array, to 0.
        neighbours: off the array, flat indices of the taxels beside it (n, 4).
        beside: which of these there are (n, 4).
    """

    contact: np.ndarray
    normal: np.ndarray
    taxels: np.ndarray
    shares: np.ndarray
    neighbours: np.ndarray
    beside: np.ndarray


def rubber_contacts(scene: Scene, data: mujoco.MjData) -> RubberContacts:
    """Where the pads bear on anything, and which taxels feel it."""
    contact, model = data.contact, scene.model
    if data.ncon == 0 or data.nefc == 0:
        return RubberContacts(np.zeros(0, np.int64), np.zeros(0), *np.zeros((4, 0, 4), np.int64))
    of_pair = scene.taxel[contact.geom]
    found = np.flatnonzero((of_pair >= 0).any(axis=1) & (contact.efc_address >= 0))
    geom = contact.geom[found, of_pair[found].argmax(axis=1)]
    pads = np.searchsorted(scene.hand.pad_offsets, scene.taxel[geom], side="right") - 1
    links = model.geom_bodyid[geom]
    away = contact.pos[found] - data.xpos[links]
    points = np.einsum("nj,njk->nk", away, data.xmat[links].reshape(-1, 3, 3))
    taxels, shares = np.zeros((len(found), 4), np.int64), np.zeros((len(found), 4))
    neighbours, beside = np.zeros((len(found), 4), np.int64), np.zeros((len(found), 4), bool)
    kinds = scene.hand.pad_kinds[pads]
    for kind, array in enumerate(scene.hand.arrays.values()):
        here = kinds == kind
        if here.any():
            taxels[here], shares[here] = array.shares(points[here])
            neighbours[here], beside[here] = array.beside(points[here])
    offsets = scene.hand.pad_offsets[pads][:, None]
    normal = data.efc_force[contact.efc_address[found]]
    return RubberContacts(found, normal, taxels + offsets, shares, neighbours + offsets, beside)


def taxel_forces(scene: Scene, data: mujoco.MjData) -> np.ndarray:
    """Normal force on every taxel, flat (taxels,) [N], 0 where a pad has no taxel."""
    forces = np.zeros(scene.hand.tactile_size)
    rubber = rubber_contacts(scene, data)
    np.add.at(forces, rubber.taxels, rubber.normal[:, None] * rubber.shares)
    return forces


def forces_beside_taxels(scene: Scene, data: mujoco.MjData) -> np.ndarray:
    """Normal force on rubber beside every taxel under which there is none, flat (taxels,) [N].

    It acts beyond the border of an array, or where a taxel is missing. No taxel feels it, but
    crosstalk passes on a share of it, as between taxels.
    """
    forces = np.zeros(scene.hand.tactile_size)
    rubber = rubber_contacts(scene, data)
    np.add.at(forces, rubber.neighbours, rubber.normal[:, None] * rubber.beside)
    return forces


def hand_force(scene: Scene, data: mujoco.MjData) -> tuple[float, float]:
    """Normal force between object and hand: that taxels feel, and all that none does [N].

    The latter is on parts without taxels, and on rubber beyond the border of an array.
    """
    if data.ncon == 0:
        return 0.0, 0.0
    bearing = touching(scene, data, OBJECT_GEOM, HAND_GEOM) & (data.contact.efc_address >= 0)
    rubber = rubber_contacts(scene, data)
    felt = np.zeros(len(bearing), dtype=bool)
    felt[rubber.contact] = rubber.shares.any(axis=1)
    sensed, unsensed = (
        float(data.efc_force[data.contact.efc_address[bearing & which]].sum())
        for which in (felt, ~felt)
    )
    return sensed, unsensed


class ObjectForces(NamedTuple):
    """Contacts of the hand with the object that bear force, in the world.

    Attributes:
        points: (k, 3) [m].
        forces: on the object (k, 3) [N].
        normals: into the object (k, 3).
        geoms: of the hand (k,).
    """

    points: np.ndarray
    forces: np.ndarray
    normals: np.ndarray
    geoms: np.ndarray


def forces_on_object(scene: Scene, data: mujoco.MjData) -> ObjectForces:
    """Where the hand bears on the object, and with what force."""
    points, forces, normals, geoms = [], [], [], []
    wrench = np.empty(6)
    contact = data.contact
    bearing = touching(scene, data, OBJECT_GEOM, HAND_GEOM) & (contact.efc_address >= 0)
    for k in np.flatnonzero(bearing):
        mujoco.mj_contactForce(scene.model, data, int(k), wrench)
        # Rows of the contact frame are its axes; the force acts from geom 1 on geom 2.
        frame = contact.frame[k].reshape(3, 3)
        force = frame.T @ wrench[:3]
        points.append(contact.pos[k].copy())
        on_second = scene.geom_group[contact.geom[k, 1]] == OBJECT_GEOM
        forces.append(force if on_second else -force)
        normals.append(frame[0] if on_second else -frame[0])
        geoms.append(contact.geom[k, 0 if on_second else 1])
    return ObjectForces(
        points=np.array(points).reshape(-1, 3),
        forces=np.array(forces).reshape(-1, 3),
        normals=np.array(normals).reshape(-1, 3),
        geoms=np.array(geoms, dtype=np.int64),
    )


def contact_points(
    data: mujoco.MjData, of_object: np.ndarray
) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Contacts between an object and other geoms, bearing force or not.

    Args:
        data: of any model, collisions found.
        of_object: which geoms are the object's (ngeom,) bool.

    Returns:
        the other geom, point (3,) [m] and unit normal into the object (3,), in the world.
    """
    found = []
    contact = data.contact
    for k in range(data.ncon):
        first, second = contact.geom[k]
        if of_object[first] == of_object[second]:
            continue
        part = second if of_object[first] else first
        normal = contact.frame[k, :3] * (1.0 if part == first else -1.0)
        found.append((int(part), contact.pos[k].copy(), normal))
    return found
