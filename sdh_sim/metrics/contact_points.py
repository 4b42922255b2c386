"""Contacts of a perceived grasp as arrays, and lengths and coefficients that metrics share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sdh_sim.sensing import PerceivedGrasp


def positions_of(grasp: PerceivedGrasp) -> np.ndarray:
    """Centres of the contacts (n, 3) [m], object axes, from the centre of mass."""
    return np.array([p.contact.position for p in grasp.contacts]).reshape(-1, 3)


def normals_of(grasp: PerceivedGrasp) -> np.ndarray:
    """Unit normals of the contacts into the object (n, 3), object axes."""
    return np.array([p.contact.normal for p in grasp.contacts]).reshape(-1, 3)


def friction_of(grasp: PerceivedGrasp) -> np.ndarray:
    """Coefficients of friction of the contacts (n,)."""
    return np.array([p.contact.friction for p in grasp.contacts])


def torsion_of(grasp: PerceivedGrasp) -> np.ndarray:
    """Largest moment about the normal over the normal force, of the contacts (n,) [m]."""
    limits = [(p.contact.max_torsion, p.contact.max_normal_force) for p in grasp.contacts]
    return np.array([torsion / force if force > 0 else 0.0 for torsion, force in limits])


def length_of(grasp: PerceivedGrasp) -> float:
    """Length that moments are divided by: half the diagonal of the object's box [m]."""
    return 0.5 * float(np.linalg.norm(grasp.obj.extents_m))
