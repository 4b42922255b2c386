"""MuJoCo's contacts decoded, here and nowhere else: which parts touch, where, with what force."""

from __future__ import annotations

import mujoco
import numpy as np

from sdh_sim.cell.scene import HAND_GEOM, OBJECT_GEOM, Scene
from sdh_sim.robot.pads import TACTILE_SIZE


def taxel_forces(scene: Scene, data: mujoco.MjData) -> np.ndarray:
    """Normal force on every taxel, flat (486,) [N], cells that do not exist 0."""
    forces = np.zeros(TACTILE_SIZE)
    if data.ncon == 0 or data.nefc == 0:
        return forces
    contact = data.contact
    address = contact.efc_address
    # A contact out of reach of the constraint solver has no row.
    alive = address >= 0
    normal = data.efc_force[address[alive]]
    for geom in contact.geom[alive].T:
        taxel = scene.taxel[geom]
        hit = taxel >= 0
        np.add.at(forces, taxel[hit], normal[hit])
    return forces


def contact_arrows(scene: Scene, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
    """Contacts between object and hand: points (k, 3) [m] and forces on the object (k, 3) [N]."""
    points, forces = [], []
    wrench = np.empty(6)
    groups = scene.geom_group[data.contact.geom]
    for k in range(data.ncon):
        if data.contact.efc_address[k] < 0 or set(groups[k]) != {OBJECT_GEOM, HAND_GEOM}:
            continue
        mujoco.mj_contactForce(scene.model, data, k, wrench)
        # Rows of the contact frame are its axes; the force acts from geom 1 on geom 2.
        force = data.contact.frame[k].reshape(3, 3).T @ wrench[:3]
        points.append(data.contact.pos[k].copy())
        forces.append(force if groups[k, 1] == OBJECT_GEOM else -force)
    return np.array(points).reshape(-1, 3), np.array(forces).reshape(-1, 3)
